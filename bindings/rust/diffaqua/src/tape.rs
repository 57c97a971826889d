// SPDX-License-Identifier: MIT
//! The record of a rollout, losses of it, and the backward sweep.
use std::{any::Any, fmt, ptr, sync::Arc};

use crate::{
    Answer, Controller, Error, ObjectiveTerm, Result, Seed, Simulator, State, Status, TapeOptions, TapeStatistics, Wrt,
    callback,
    error::check,
    handle::{Handle, count, index, start, wanted},
    objective::raw_terms,
    sys,
};

type Keep = Arc<dyn Any + Send + Sync>;

/// Sizes of what is recorded.
#[derive(Clone, Copy, Default)]
struct Sizes {
    n_nodes: usize,
    dims: usize,
    n_bases: usize,
    n_signals: usize,
    n_cells: usize,
    table_rows: usize,
    /// Of the controller of the rollout; None: steps without one.
    n_parameters: Option<usize>,
}

/// The record of one rollout: design, controller parameters, states, actuations. Reading may be shared by threads.
pub struct Tape {
    // Freed before what the callbacks of its steps need.
    handle: Handle<sys::dqa_tape>,
    keeps: Vec<Keep>,
    sizes: Sizes,
}

// SAFETY: distinct objects may be used concurrently; the closures it keeps are Send and Sync.
unsafe impl Send for Tape {}
// SAFETY: a finished tape is read-only and may be shared; recording and clearing need it exclusively.
unsafe impl Sync for Tape {}

impl Tape {
    /// An empty tape without a memory budget for rollouts of the simulator.
    pub fn new(simulator: &Simulator) -> Result<Self> {
        Self::with_options(simulator, &TapeOptions::new())
    }

    /// An empty tape for rollouts of the simulator; the first recorded step fixes design and initial state.
    pub fn with_options(simulator: &Simulator, options: &TapeOptions) -> Result<Self> {
        // SAFETY: simulator and options live for the call.
        let handle = Handle::create(sys::dqa_tape_free, |out| unsafe {
            sys::dqa_tape_create(simulator.get(), &options.raw(), out)
        })?;
        Ok(Tape { handle, keeps: Vec::new(), sizes: Sizes::default() })
    }

    fn get(&self) -> *mut sys::dqa_tape {
        self.handle.get()
    }

    /// Before a call that records: sizes, and the closures of the steps, which it keeps even if the call fails
    /// half-way.
    pub(crate) fn recording<'a>(
        tape: Option<&'a mut Tape>,
        simulator: &Simulator,
        controller: Option<&Controller>,
    ) -> Result<Recording<'a>> {
        let Some(tape) = tape else { return Ok(Recording(None)) };
        let (steps, sizes) = (tape.n_steps()?, tape.sizes);
        if let Some(current) = &simulator.current {
            tape.keep(current.clone());
        }
        if let Some(control) = controller.and_then(|controller| controller.control.as_ref()) {
            tape.keep(control.clone());
        }
        if steps == 0 {
            let info = simulator.info()?;
            tape.sizes = Sizes {
                n_nodes: info.n_nodes,
                dims: info.dims,
                n_bases: info.n_bases,
                n_signals: info.n_signals,
                n_cells: simulator.n_cells(),
                ..Sizes::default()
            };
        }
        tape.sizes.table_rows = simulator.table_rows;
        if let Some(controller) = controller {
            tape.sizes.n_parameters = Some(controller.n_parameters()?);
        }
        Ok(Recording(Some((tape, steps, sizes))))
    }

    fn keep(&mut self, closures: Keep) {
        if !self.keeps.iter().any(|kept| Arc::ptr_eq(kept, &closures)) {
            self.keeps.push(closures);
        }
    }

    /// Empties the tape for another rollout.
    pub fn clear(&mut self) -> Result<()> {
        // SAFETY: the handle lives.
        check(unsafe { sys::dqa_tape_clear(self.get()) })?;
        self.keeps.clear();
        self.sizes = Sizes::default();
        Ok(())
    }

    /// Steps recorded so far.
    pub fn n_steps(&self) -> Result<usize> {
        let mut n = 0;
        // SAFETY: the handle lives.
        check(unsafe { sys::dqa_tape_n_steps(self.get(), &mut n) })?;
        Ok(n as usize)
    }

    /// State after `step` steps. States that a memory budget made the tape drop are computed again: cheapest in order.
    pub fn state(&self, step: usize) -> Result<State> {
        let n = self.sizes.n_nodes * self.sizes.dims;
        let mut state = State { q: vec![0.0; n], v: vec![0.0; n] };
        self.state_into(step, Some(&mut state.q), Some(&mut state.v))?;
        Ok(state)
    }

    /// The same into arrays of the caller's, each `[n_nodes][dims]`; None: not wanted.
    pub fn state_into(&self, step: usize, q: Option<&mut [f64]>, v: Option<&mut [f64]>) -> Result<()> {
        let ((q, nq), (v, nv)) = (wanted(q), wanted(v));
        // SAFETY: the arrays have as many elements as they say.
        check(unsafe { sys::dqa_tape_get_state(self.get(), index(step), q, nq, v, nv) })
    }

    /// Actuation `[n_signals]` used in step `step`.
    pub fn actuation(&self, step: usize) -> Result<Vec<f64>> {
        let mut actuation = vec![0.0; self.sizes.n_signals];
        let (out, n) = (actuation.as_mut_ptr(), count(&actuation));
        // SAFETY: the array has as many elements as it says.
        check(unsafe { sys::dqa_tape_get_actuation(self.get(), index(step), out, n) })?;
        Ok(actuation)
    }

    /// Velocity of the water `[dims]` (m/s) during step `step`.
    pub fn current(&self, step: usize) -> Result<Vec<f64>> {
        let mut current = vec![0.0; self.sizes.dims];
        let (out, n) = (current.as_mut_ptr(), count(&current));
        // SAFETY: the array has as many elements as it says.
        check(unsafe { sys::dqa_tape_get_current(self.get(), index(step), out, n) })?;
        Ok(current)
    }

    /// Vertices `[n_vertices][dims]` of the surface after `step` steps; the elements are those of
    /// [`Simulator::surface`] for the same design, n_vertices that of [`Simulator::surface_size`].
    pub fn surface(&self, step: usize, n_vertices: usize) -> Result<Vec<f64>> {
        let too_many = || Error::argument(format!("n_vertices is {n_vertices}, expected that of the tape's design"));
        let mut vertices = Vec::new();
        let n = n_vertices.checked_mul(self.sizes.dims.max(2)).ok_or_else(too_many)?;
        vertices.try_reserve_exact(n).map_err(|_| too_many())?;
        vertices.resize(n, 0.0);
        // SAFETY: the array has as many elements as it says.
        check(unsafe { sys::dqa_tape_get_surface(self.get(), index(step), vertices.as_mut_ptr(), count(&vertices)) })?;
        Ok(vertices)
    }

    /// Memory, iterations and residuals.
    pub fn statistics(&self) -> Result<TapeStatistics> {
        // SAFETY: the handle lives; the library writes `size` bytes.
        TapeStatistics::ask(|out, size| unsafe { sys::dqa_tape_stats(self.get(), out, size) })
    }

    /// (loss, each unweighted term `[n_terms]`) of the recorded rollout.
    pub fn objective(&self, terms: &[ObjectiveTerm]) -> Result<(f64, Vec<f64>)> {
        let (raw, mut loss, mut each) = (raw_terms(terms), 0.0, vec![0.0; terms.len()]);
        // SAFETY: there are as many terms as it says, and as many numbers for them.
        check(unsafe { sys::dqa_tape_objective(self.get(), start(&raw), count(&raw), &mut loss, each.as_mut_ptr()) })?;
        Ok((loss, each))
    }

    /// Gradients of a loss with respect to each of `wrt`: a whole backward sweep.
    pub fn gradient<const N: usize>(&self, terms: &[ObjectiveTerm], wrt: [Wrt; N]) -> Result<[Vec<f64>; N]> {
        let mut adjoint = Adjoint::new(self)?;
        adjoint.seed_objective(terms)?;
        adjoint.backward(0)?;
        let mut gradients = [const { Vec::new() }; N];
        for (gradient, which) in gradients.iter_mut().zip(wrt) {
            *gradient = adjoint.gradient(which)?;
        }
        Ok(gradients)
    }
}

impl fmt::Debug for Tape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Tape").field(&self.statistics()).finish()
    }
}

/// A tape (None: not recorded) for the time of a call, with its steps and sizes before: what recorded nothing changes
/// nothing.
pub(crate) struct Recording<'a>(Option<(&'a mut Tape, usize, Sizes)>);

impl Recording<'_> {
    pub(crate) fn get(&self) -> *mut sys::dqa_tape {
        self.0.as_ref().map_or(ptr::null_mut(), |recording| recording.0.get())
    }
}

impl Drop for Recording<'_> {
    fn drop(&mut self) {
        if let Some((tape, steps, sizes)) = &mut self.0 {
            if tape.n_steps() == Ok(*steps) {
                tape.sizes = *sizes;
            }
        }
    }
}

/// A cursor over a finished tape that walks back from its last step. Seeds add up.
///
/// It borrows the tape, to which nothing may be added meanwhile:
///
/// ```compile_fail,E0502
/// # use diffaqua::*;
/// # fn record(tape: &mut Tape) -> Result<()> {
/// let mut adjoint = Adjoint::new(tape)?;
/// tape.clear()?;
/// adjoint.backward(0)
/// # }
/// ```
pub struct Adjoint<'tape> {
    handle: Handle<sys::dqa_adjoint>,
    tape: &'tape Tape,
}

// SAFETY: distinct objects may be used concurrently, and one by one thread at a time; the tape may be shared.
unsafe impl Send for Adjoint<'_> {}

impl<'tape> Adjoint<'tape> {
    /// A cursor after the last step. [`Status::State`] if a controller without pullback closed a loop through the
    /// sensors.
    pub fn new(tape: &'tape Tape) -> Result<Self> {
        // SAFETY: the tape lives as long as the cursor.
        let handle = Handle::create(sys::dqa_adjoint_free, |out| unsafe { sys::dqa_adjoint_create(tape.get(), out) })?;
        Ok(Adjoint { handle, tape })
    }

    /// Adds `bar` `[n_nodes][dims]` to the seed of a quantity of the state after `step` steps, which the sweep must not
    /// have passed.
    pub fn seed(&mut self, step: usize, quantity: Seed, bar: &[f64]) -> Result<()> {
        let (step, quantity, n) = (index(step), quantity as i32, count(bar));
        // SAFETY: the array has as many elements as it says.
        check(unsafe { sys::dqa_adjoint_seed(self.handle.get(), step, quantity, start(bar), n) })
    }

    /// Adds the seeds of a loss, its dependence on the design included. Only before the sweep has begun.
    pub fn seed_objective(&mut self, terms: &[ObjectiveTerm]) -> Result<()> {
        let raw = raw_terms(terms);
        // SAFETY: there are as many terms as it says.
        check(unsafe { sys::dqa_adjoint_seed_objective(self.handle.get(), start(&raw), count(&raw)) })
    }

    /// Runs the sweep back to the state after `to_step` steps (0: all the way). Goes on where it was stopped.
    /// [`Status::NotConverged`](crate::Status::NotConverged) where a linear solve stops above its tolerance.
    pub fn backward(&mut self, to_step: usize) -> Result<()> {
        self.backward_with(to_step, |_, _| ())
    }

    /// The same with a report of (done, total).
    pub fn backward_with<A: Answer>(&mut self, to_step: usize, progress: impl FnMut(usize, usize) -> A) -> Result<()> {
        // SAFETY: the progress lives for the call.
        callback::with_progress(progress, |report, data| unsafe {
            sys::dqa_adjoint_backward(self.handle.get(), index(to_step), report, data)
        })
    }

    /// A gradient, in the shape that [`Wrt`] gives. All but actuation and current need the whole sweep.
    pub fn gradient(&self, wrt: Wrt) -> Result<Vec<f64>> {
        let mut gradient = vec![0.0; self.size(wrt)?];
        self.gradient_into(wrt, &mut gradient)?;
        Ok(gradient)
    }

    /// The same into an array of the caller's.
    pub fn gradient_into(&self, wrt: Wrt, gradient: &mut [f64]) -> Result<()> {
        let (out, n) = (gradient.as_mut_ptr(), count(gradient));
        // SAFETY: the array has as many elements as it says.
        check(unsafe { sys::dqa_adjoint_get(self.handle.get(), wrt as i32, out, n) })
    }

    fn size(&self, wrt: Wrt) -> Result<usize> {
        let sizes = &self.tape.sizes;
        let no_controller =
            || Error::new(Status::State, "no controller drove this tape: its steps have Wrt::Actuation");
        Ok(match wrt {
            Wrt::Weights => sizes.n_bases,
            Wrt::Control => sizes.n_parameters.ok_or_else(no_controller)?,
            Wrt::Actuation => self.tape.n_steps()? * sizes.n_signals,
            Wrt::InitialPosition | Wrt::InitialVelocity => sizes.n_nodes * sizes.dims,
            Wrt::Water => sizes.dims + 9,
            Wrt::Current => self.tape.n_steps()? * sizes.dims,
            Wrt::CurrentTable => sizes.table_rows * sizes.dims,
            Wrt::YoungsModulus | Wrt::MuscleStiffness => sizes.n_cells,
            Wrt::Material => 4,
            Wrt::Lame => 2,
        })
    }
}

impl fmt::Debug for Adjoint<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Adjoint").field(self.tape).finish()
    }
}
