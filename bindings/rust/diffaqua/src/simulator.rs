// SPDX-License-Identifier: MIT
//! One scene: a shape space, material, water, solver; its present design and state.
use std::{fmt, ptr, sync::Arc};

use crate::{
    Answer, Controller, GradientCheckOptions, GradientReport, ObjectiveTerm, Result, ShapeSpace, SimulatorInfo,
    SimulatorOptions, Tape, callback,
    error::{check, require_length},
    handle::{Handle, count, given, index, start, wanted},
    objective::raw_terms,
    sys,
    water::Current,
};

/// Positions (m) and velocities (m/s), each `[n_nodes][dims]`.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Positions.
    pub q: Vec<f64>,
    /// Velocities.
    pub v: Vec<f64>,
}

/// One scene in a built space. Set weights before anything that needs a body.
///
/// It moves between threads, but is not shared:
///
/// ```compile_fail,E0277
/// fn share<T: Sync>() {}
/// share::<diffaqua::Simulator>();
/// ```
pub struct Simulator {
    // Freed before what its callbacks need.
    handle: Handle<sys::dqa_simulator>,
    n_cells: usize,
    pub(crate) current: Option<Arc<Current>>,
    /// Rows of the table of currents; 1 without one.
    pub(crate) table_rows: usize,
}

// SAFETY: distinct objects may be used concurrently, and one by one thread at a time; the closures of currents are Send
// and Sync.
unsafe impl Send for Simulator {}

impl Simulator {
    pub(crate) fn get(&self) -> *mut sys::dqa_simulator {
        self.handle.get()
    }

    /// A scene without a design.
    pub fn new(space: &ShapeSpace, options: &SimulatorOptions) -> Result<Self> {
        let raw = options.raw();
        // SAFETY: the space, `raw` and the token in it live for the call.
        let handle = Handle::create(sys::dqa_simulator_free, |out| unsafe {
            sys::dqa_simulator_create(space.get(), &raw, out)
        })?;
        Ok(Simulator { handle, n_cells: space.info()?.n_cells, current: None, table_rows: 1 })
    }

    /// Sizes, totals and the clock.
    pub fn info(&self) -> Result<SimulatorInfo> {
        // SAFETY: the handle lives; the library writes `size` bytes.
        SimulatorInfo::ask(|out, size| unsafe { sys::dqa_simulator_get_info(self.get(), out, size) })
    }

    /// Elements of positions, and of velocities.
    fn state_size(&self) -> Result<usize> {
        self.info().map(|info| info.n_nodes * info.dims)
    }

    /// Cells of the full box.
    pub(crate) fn n_cells(&self) -> usize {
        self.n_cells
    }

    // ---------------------------------------------------------------- design
    /// New design from weights `[n_bases]` on the simplex: density, cells, muscles, factor. The state goes back to rest
    /// and the clock to 0. On failure, as [`Status::NotConverged`](crate::Status::NotConverged), the old design stays.
    pub fn set_weights(&mut self, weights: &[f64]) -> Result<()> {
        self.set_weights_with(weights, |_, _| ())
    }

    /// The same with a report of (done, total).
    pub fn set_weights_with<A: Answer>(
        &mut self,
        weights: &[f64],
        progress: impl FnMut(usize, usize) -> A,
    ) -> Result<()> {
        // SAFETY: array and progress live for the call.
        callback::with_progress(progress, |report, data| unsafe {
            sys::dqa_simulator_set_weights(self.get(), start(weights), count(weights), report, data)
        })
    }

    /// Of the present design `[n_bases]`.
    pub fn weights(&self) -> Result<Vec<f64>> {
        let mut weights = vec![0.0; self.info()?.n_bases];
        // SAFETY: the array has as many elements as it says.
        check(unsafe { sys::dqa_simulator_get_weights(self.get(), weights.as_mut_ptr(), count(&weights)) })?;
        Ok(weights)
    }

    /// Young's modulus and muscle stiffness (Pa) by cell of the full box `[n_cells]`; None: the uniform value of the
    /// options. The state goes back to rest.
    pub fn set_material(&mut self, young_modulus: Option<&[f64]>, muscle_stiffness: Option<&[f64]>) -> Result<()> {
        for (name, values) in [("young_modulus", young_modulus), ("muscle_stiffness", muscle_stiffness)] {
            if let Some(values) = values {
                require_length(name, values.len(), self.n_cells, "[n_cells]")?;
            }
        }
        let (solid, muscle) = (given(young_modulus).0, given(muscle_stiffness).0);
        // SAFETY: the arrays that are given have n_cells elements.
        check(unsafe { sys::dqa_simulator_set_material(self.get(), solid, muscle, index(self.n_cells)) })
    }

    /// Nodes of the full box that keep their place; none frees all. The state goes back to rest.
    pub fn set_fixed_nodes(&mut self, nodes: &[i32]) -> Result<()> {
        // SAFETY: the array has as many elements as it says.
        check(unsafe { sys::dqa_simulator_set_fixed_nodes(self.get(), start(nodes), count(nodes)) })
    }

    /// Index in the full box of each node of the design `[n_nodes]`.
    pub fn node_box_index(&self) -> Result<Vec<i32>> {
        let mut nodes = vec![0; self.info()?.n_nodes];
        // SAFETY: the array has as many elements as it says.
        check(unsafe { sys::dqa_simulator_node_box_index(self.get(), nodes.as_mut_ptr(), count(&nodes)) })?;
        Ok(nodes)
    }

    /// (threshold, estimate): the option `threshold` that keeps the estimated relative error of leaving faint cells out
    /// at or below `tolerance`, in (0, 1), at the design `weights`.
    pub fn suggest_threshold(&self, weights: &[f64], tolerance: f64) -> Result<(f64, f64)> {
        let (mut threshold, mut estimate, n) = (0.0, 0.0, count(weights));
        // SAFETY: the array has as many elements as it says.
        check(unsafe {
            sys::dqa_simulator_suggest_threshold(
                self.get(),
                start(weights),
                n,
                tolerance,
                &mut threshold,
                &mut estimate,
            )
        })?;
        Ok((threshold, estimate))
    }

    // ---------------------------------------------------------------- motion
    /// One step with actuation `[n_signals]`, each in [-1, 1], appended to `tape`. On failure the state is that before
    /// the call: [`Status::NotConverged`](crate::Status::NotConverged), [`Status::Diverged`](crate::Status::Diverged),
    /// [`Status::Memory`](crate::Status::Memory) where the tape's budget is too small.
    pub fn step(&mut self, actuation: &[f64], tape: Option<&mut Tape>) -> Result<()> {
        let tape = Tape::recording(tape, self, None)?;
        // SAFETY: the array has as many elements as it says; the tape keeps the closures that its steps need.
        check(unsafe { sys::dqa_simulator_step(self.get(), start(actuation), count(actuation), tape.get()) })
    }

    /// n_steps steps driven by a controller, appended to `tape`. On failure the state is that after the last whole
    /// step, and the tape holds the whole ones.
    pub fn rollout(&mut self, controller: &Controller, n_steps: usize, tape: Option<&mut Tape>) -> Result<()> {
        self.rollout_with(controller, n_steps, tape, |_, _| ())
    }

    /// The same with a report of (done, total).
    pub fn rollout_with<A: Answer>(
        &mut self,
        controller: &Controller,
        n_steps: usize,
        tape: Option<&mut Tape>,
        progress: impl FnMut(usize, usize) -> A,
    ) -> Result<()> {
        let tape = Tape::recording(tape, self, Some(controller))?;
        // SAFETY: all handles and the progress live for the call; the tape keeps the closures that its steps need.
        callback::with_progress(progress, |report, data| unsafe {
            sys::dqa_simulator_rollout(self.get(), controller.get(), index(n_steps), tape.get(), report, data)
        })
    }

    /// Positions and velocities.
    pub fn state(&self) -> Result<State> {
        let n = self.state_size()?;
        let mut state = State { q: vec![0.0; n], v: vec![0.0; n] };
        self.state_into(Some(&mut state.q), Some(&mut state.v))?;
        Ok(state)
    }

    /// The same into arrays of the caller's; None: not wanted.
    pub fn state_into(&self, q: Option<&mut [f64]>, v: Option<&mut [f64]>) -> Result<()> {
        let ((q, nq), (v, nv)) = (wanted(q), wanted(v));
        // SAFETY: the arrays have as many elements as they say.
        check(unsafe { sys::dqa_simulator_get_state(self.get(), q, nq, v, nv) })
    }

    /// Sets positions (None: at rest) and velocities (None: zero), each `[n_nodes][dims]`, and the clock to step 0.
    pub fn set_state(&mut self, q: Option<&[f64]>, v: Option<&[f64]>) -> Result<()> {
        let ((q, nq), (v, nv)) = (given(q), given(v));
        // SAFETY: the arrays have as many elements as they say.
        check(unsafe { sys::dqa_simulator_set_state(self.get(), q, nq, v, nv) })
    }

    /// What controllers see `[5][dims]`: velocities of the head, centre and tail sensors (m/s), offsets of the head and
    /// of the tail sensor from the centre sensor (m).
    pub fn sensors(&self) -> Result<Vec<f64>> {
        let mut sensors = vec![0.0; self.info()?.n_sensors];
        self.sensors_into(&mut sensors)?;
        Ok(sensors)
    }

    /// The same into an array of the caller's.
    pub fn sensors_into(&self, sensors: &mut [f64]) -> Result<()> {
        // SAFETY: the array has as many elements as it says.
        check(unsafe { sys::dqa_simulator_sensors(self.get(), sensors.as_mut_ptr(), count(sensors)) })
    }

    /// Hydrodynamic totals of the last step `[4][dims]`: drag, thrust (N), then their means over the wet surface
    /// (N/m^2).
    pub fn forces(&self) -> Result<Vec<f64>> {
        let mut forces = vec![0.0; 4 * self.info()?.dims];
        // SAFETY: the array has as many elements as it says.
        check(unsafe { sys::dqa_simulator_forces(self.get(), forces.as_mut_ptr(), count(&forces)) })?;
        Ok(forces)
    }

    // ---------------------------------------------------------------- proof
    /// Proves (or refutes) the gradient of the objective of a rollout from the present state by finite differences
    /// along one random direction. The simulator is unchanged. Without a controller, actuations alternate smoothly.
    pub fn check_gradient(
        &self,
        controller: Option<&Controller>,
        terms: &[ObjectiveTerm],
        options: &GradientCheckOptions,
    ) -> Result<GradientReport> {
        let (driver, raw) = (controller.map_or(ptr::null_mut(), Controller::get), raw_terms(terms));
        // SAFETY: all handles, terms and options live for the call; the library writes `size` bytes.
        GradientReport::ask(|out, size| unsafe {
            sys::dqa_check_gradient(self.get(), driver, start(&raw), count(&raw), &options.raw(), out, size)
        })
    }
}

impl fmt::Debug for Simulator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Simulator").field(&self.info()).finish()
    }
}
