// SPDX-License-Identifier: MIT
//! Options as builders over the structs of the header, which the library fills with its defaults.
use crate::{
    ActuatorKind, CancelToken, Faces, InstructionSet, Integrator, Interpolation, Material, Method, Peak, Precision,
    Preconditioner, Quadrature, Side, Up, Water, Wrt, handle::index, sys,
};

/// A value as a field of the header's structs has it. Numbers that do not fit become ones that the library refuses.
pub(crate) trait IntoRaw<T> {
    fn into_raw(self) -> T;
}

macro_rules! as_it_is {
    ($($type:ty),*) => {$(
        impl IntoRaw<$type> for $type {
            fn into_raw(self) -> $type {
                self
            }
        }
    )*};
}
as_it_is!(i32, u64, f64, [f64; 3], [f64; 4]);

impl IntoRaw<i32> for usize {
    fn into_raw(self) -> i32 {
        index(self)
    }
}
impl IntoRaw<i64> for usize {
    fn into_raw(self) -> i64 {
        index(self)
    }
}
impl IntoRaw<i32> for bool {
    fn into_raw(self) -> i32 {
        i32::from(self)
    }
}

macro_rules! options {
    ($($(#[$doc:meta])* $name:ident = $raw:ident by $init:ident $(, $cancel:ident)? {
        $($(#[$field_doc:meta])* $field:ident: $type:ty,)*
    })*) => {$(
        $(#[$doc])*
        #[derive(Clone, Debug)]
        pub struct $name {
            raw: sys::$raw,
            $($cancel: Option<CancelToken>,)?
        }

        // SAFETY: pointers inside `raw` are NULL; `raw()` fills them in for the time of a call.
        unsafe impl Send for $name {}
        // SAFETY: as above.
        unsafe impl Sync for $name {}

        impl $name {
            /// The library's defaults.
            pub fn new() -> Self {
                // SAFETY: the struct is plain numbers and pointers, and the library writes size_of bytes of it.
                let raw = unsafe { crate::handle::filled(|out, size| sys::$init(out, size)) };
                $name {
                    raw: raw.expect("the library fills a struct of the size that the header gives"),
                    $($cancel: None,)?
                }
            }

            $($(#[$field_doc])*
            #[must_use]
            pub fn $field(mut self, value: $type) -> Self {
                self.raw.$field = value.into_raw();
                self
            })*

            $(/// Stops the calls of the object when it is set.
            #[must_use]
            pub fn $cancel(mut self, token: &CancelToken) -> Self {
                self.$cancel = Some(token.clone());
                self
            })?

            /// The struct as it stands, for reading; its pointers are NULL.
            pub fn as_raw(&self) -> &sys::$raw {
                &self.raw
            }

            /// The struct for a call, valid while `self` lives.
            #[allow(unused_mut)]
            pub(crate) fn raw(&self) -> sys::$raw {
                let mut raw = self.raw;
                $(raw.$cancel = CancelToken::pointer(self.$cancel.as_ref());)?
                raw
            }
        }

        impl Default for $name {
            fn default() -> Self {
                Self::new()
            }
        }
    )*};
}

options! {
    /// Box, meshes, interpolation: of [`ShapeSpaceBuilder::new`](crate::ShapeSpaceBuilder::new).
    ShapeSpaceOptions = dqa_shape_space_options by dqa_shape_space_options_init, cancel {
        /// 3 (default), or 2: the plane x heading, y lateral, in plane strain.
        dims: usize,
        /// Number of cells along x, in [8, 512]; default 60.
        cells_x: usize,
        /// Number of cells along y, in [8, 512]; default 16.
        cells_y: usize,
        /// Number of cells along z, in [8, 512]; default 26. Counts as 1 in two dimensions.
        cells_z: usize,
        /// Empty cells kept ahead of and behind every mesh, >= 1; default 2.
        margin: usize,
        /// Empty cells kept beside, above and below it; default 0.
        margin_across: usize,
        /// Which way the meshes added later stand.
        up: Up,
        /// In [1, 16]; default 8. Without effect: covered fractions are exact, however thin a part is.
        subsamples: usize,
        /// What the density is divided by.
        peak: Peak,
        /// Of the barycentre; default 5000.
        max_iterations: usize,
        /// >= 1; results do not depend on it; default 1.
        threads: usize,
        /// m: length of the longest base; sets the cell size; default 1.
        body_length: f64,
        /// m: overrides body_length when > 0; default 0.
        cell_size: f64,
        /// Width of the Gaussian kernel, in cells, in [0.2, 16]; default 0.4.
        sigma: f64,
        /// Marginal error (1-norm) at which the barycentre stops; default 1e-9.
        tolerance: f64,
        /// Of actuators between the bases.
        interpolation: Interpolation,
        /// Whether bases without any actuator also get fins where their geometry has them; default false.
        automatic_fins: bool,
        /// Finer cells along the edge of a cell, between which mass moves, in [1, 4]; default 1.
        refinement: usize,
    }

    /// A muscle region as a Gaussian: the box around the half-peak ellipsoid.
    ActuatorOptions = dqa_actuator_options by dqa_actuator_options_init {
        /// In [0, 15]; default 0. Actuators of the same category are interpolated between the bases.
        category: i32,
        /// Caudal by default.
        kind: ActuatorKind,
        /// m, in the box's frame (origin at the box's centre).
        mean: [f64; 3],
        /// m^2, > 0: eigenvalues of the covariance along the actuator's own axes.
        variance: [f64; 3],
        /// rad: the covariance is R^T diag(variance) R with R = Rx(e0) Ry(e1) Rz(e2), whose rows are the axes.
        euler: [f64; 3],
        /// Of fins; caudal ones have [`Side::Both`], the default.
        side: Side,
        /// Of fins, in [1, 4]; default 4.
        layers: usize,
    }

    /// Material, water, time integration and solver of a scene: of [`Simulator::new`](crate::Simulator::new).
    SimulatorOptions = dqa_simulator_options by dqa_simulator_options_init, cancel {
        /// >= 1; the bits of every result are the same for any number; default 1.
        threads: usize,
        /// How the equations of a step are solved.
        method: Method,
        /// The water's forces.
        water: Water,
        /// Newton iterations per step; default 50.
        max_newton: usize,
        /// Conjugate-gradient iterations per linear solve, or L-BFGS iterations per step; default 2000.
        max_linear: usize,
        /// Speed only.
        instruction_set: InstructionSet,
        /// Implicit Euler by default.
        integrator: Integrator,
        /// Corotated by default, the paper's.
        material: Material,
        /// Whether no node moves along z; default false; of no effect in two dimensions.
        planar: bool,
        /// Speed only.
        preconditioner: Preconditioner,
        /// s, > 0; default 1/30.
        time_step: f64,
        /// Pa, > 0: of the solid; default 5e6.
        young_modulus: f64,
        /// In [0, 0.5); default 0.45.
        poisson_ratio: f64,
        /// kg/m^3, > 0; default 1000.
        density: f64,
        /// Pa, >= 0; default 2e6.
        muscle_stiffness: f64,
        /// c in (0, 1): a signal u commands the rest ratios 1 - c u and 1 + c u; default 0.2.
        contraction: f64,
        /// In [0, 0.5): cells whose density exceeds it are simulated; default 0.02.
        threshold: f64,
        /// Least occupancy of a simulated cell, in [1e-12, 0.1]; default 1e-10.
        occupancy_floor: f64,
        /// Relative force residual at which a step stops; default 1e-6.
        tolerance: f64,
        /// Relative residual of the adjoint's linear solves; default 0: `tolerance`, and less in rollouts of more
        /// than 100 steps.
        adjoint_tolerance: f64,
        /// kg/m^3, > 0; default 1000.
        water_density: f64,
        /// m/s: velocity of the water; in two dimensions the last is 0; default 0.
        current: [f64; 3],
        /// Cubic Bezier ordinates of the drag coefficient over |Phi|/(pi/2).
        drag_coefficients: [f64; 4],
        /// Cubic Bezier ordinates of the thrust coefficient over Phi/pi + 1/2.
        thrust_coefficients: [f64; 4],
        /// m/s, > 0: |v| becomes sqrt(v^2 + eps^2); default 1e-2.
        speed_smoothing: f64,
        /// rad, in (0, 0.5]: rounds the cone of the coefficients at head-on flow; default 0.02.
        angle_smoothing: f64,
        /// > 0: rounds the weight of faces; default 1e-2.
        surface_smoothing: f64,
        /// Which faces the water acts on.
        water_faces: Faces,
        /// Of the preconditioner alone; single by default.
        linear_precision: Precision,
        /// One point a cell by default.
        quadrature: Quadrature,
        /// Products with the Hessian that a step may take, >= 1; default 200000.
        max_products: usize,
    }

    /// Of [`Controller::perceptron`](crate::Controller::perceptron).
    PerceptronOptions = dqa_mlp_options by dqa_mlp_options_init {
        /// Outputs, in [1, 4096]; default 1.
        n_signals: usize,
        /// Of the simulator, 2 or 3; default 3.
        dims: usize,
        /// Whether it also sees the time within a period; default true.
        temporal_encoding: bool,
        /// Period of the temporal encoding in steps, >= 1; default 25.
        period_steps: usize,
        /// Of the initial weights; default 1.
        seed: u64,
        /// Factor on the initial weights, >= 0; default 1.
        scale: f64,
    }

    /// Of [`Controller::callback`](crate::Controller::callback).
    CallbackOptions = dqa_callback_controller_options by dqa_callback_controller_options_init {
        /// In [1, 4096]; default 1.
        n_signals: usize,
        /// 0 (default): reads none, the loop is open; otherwise 5 dims, i.e. 15 or 10.
        n_sensors: usize,
        /// s, > 0: only for the `time` of the callbacks; default 1/30.
        time_step: f64,
    }

    /// Of [`Tape::with_options`](crate::Tape::with_options).
    TapeOptions = dqa_tape_options by dqa_tape_options_init {
        /// Budget for recorded inputs and states; 0: unlimited (default). What does not fit is computed again when it
        /// is asked for, to the same bits.
        memory_bytes: usize,
    }

    /// Of [`Simulator::check_gradient`](crate::Simulator::check_gradient).
    GradientCheckOptions = dqa_gradient_check_options by dqa_gradient_check_options_init {
        /// Which gradient; the weights by default.
        with_respect_to: Wrt,
        /// Length of the rollout; default 10.
        n_steps: usize,
        /// Of the random direction; default 1.
        seed: u64,
        /// Largest finite-difference step relative to the quantity's scale; 0 (default): automatic.
        step: f64,
    }

    /// Of [`CmaEs::new`](crate::CmaEs::new).
    CmaEsOptions = dqa_cma_es_options by dqa_cma_es_options_init {
        /// Candidates a generation, >= 2; 0 (default): 4 + floor(3 ln n).
        population: usize,
        /// Of the normal numbers; default 1.
        seed: u64,
        /// > 0: first standard deviation, in units of the scales; default 0.3.
        sigma: f64,
    }
}

impl PerceptronOptions {
    /// Neurons of each hidden layer, at most five of them; default 64, 64.
    #[must_use]
    pub fn hidden(mut self, neurons: &[usize]) -> Self {
        self.raw.n_hidden = neurons.len().into_raw(); // more than there is room for is refused by the library
        for (layer, &n) in self.raw.hidden.iter_mut().zip(neurons) {
            *layer = n.into_raw();
        }
        self
    }
}

impl ActuatorOptions {
    /// For the library to write to.
    pub(crate) fn as_raw_mut(&mut self) -> &mut sys::dqa_actuator_options {
        &mut self.raw
    }
}
