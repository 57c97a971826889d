// SPDX-License-Identifier: MIT
//! What the library tells, as plain structs.
use crate::{ActuatorKind, ControllerKind, Result, Side, sys};

/// A value from a field of the header's structs.
pub(crate) trait FromRaw<T>: Sized {
    fn from_raw(raw: T) -> Result<Self>;
}

macro_rules! as_it_is {
    ($($type:ty),*) => {$(
        impl FromRaw<$type> for $type {
            fn from_raw(raw: $type) -> Result<Self> {
                Ok(raw)
            }
        }
    )*};
}
as_it_is!(i32, f64, [f64; 3], [f64; 9]);

impl FromRaw<i32> for usize {
    fn from_raw(raw: i32) -> Result<Self> {
        Ok(usize::try_from(raw).unwrap_or(0))
    }
}
impl FromRaw<i64> for usize {
    fn from_raw(raw: i64) -> Result<Self> {
        Ok(usize::try_from(raw).unwrap_or(0))
    }
}
impl FromRaw<i32> for bool {
    fn from_raw(raw: i32) -> Result<Self> {
        Ok(raw != 0)
    }
}

macro_rules! told {
    ($($(#[$doc:meta])* $name:ident = $raw:ident { $($(#[$field_doc:meta])* $field:ident: $type:ty,)* })*) => {$(
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq)]
        #[non_exhaustive]
        pub struct $name {
            $($(#[$field_doc])* pub $field: $type,)*
        }

        impl $name {
            /// From the call that fills the struct, given that and its size.
            pub(crate) fn ask(fill: impl FnOnce(*mut sys::$raw, u64) -> sys::dqa_status) -> Result<Self> {
                // SAFETY: the struct is plain numbers.
                let raw = unsafe { crate::handle::filled(fill) }?;
                Ok($name { $($field: FromRaw::from_raw(raw.$field)?,)* })
            }
        }
    )*};
}

told! {
    /// Sizes of a shape space.
    ShapeSpaceInfo = dqa_shape_space_info {
        /// 2 or 3.
        dims: usize,
        /// Cells along x.
        cells_x: usize,
        /// Cells along y.
        cells_y: usize,
        /// Cells along z; 1 in two dimensions.
        cells_z: usize,
        /// Base shapes added so far.
        n_bases: usize,
        /// Actuation signals that a simulator of this space takes per step; 0 before it is built.
        n_signals: usize,
        /// Whether it is built.
        is_built: bool,
        /// cells_x * cells_y * cells_z.
        n_cells: usize,
        /// m; 0 before it is built when it is automatic.
        cell_size: f64,
    }

    /// What one actuation signal drives.
    SignalInfo = dqa_signal_info {
        /// Number of the actuators that it drives, in [0, 15].
        category: i32,
        /// Of the actuators.
        kind: ActuatorKind,
        /// Of fins, from 0 below; 0 for caudal.
        layer: usize,
        /// Of fins, the band in [0, 4) from back inside to ahead outside; 0 for caudal.
        group: usize,
    }

    /// Sizes, totals and the clock of a simulator; what needs a design is 0 without one.
    SimulatorInfo = dqa_simulator_info {
        /// 2 or 3.
        dims: usize,
        /// Length of the weights.
        n_bases: usize,
        /// Actuation signals a step.
        n_signals: usize,
        /// Length of the sensor vector.
        n_sensors: usize,
        /// Whether weights were set.
        has_design: bool,
        /// Of the active cells; state arrays have n_nodes * dims elements.
        n_nodes: usize,
        /// Simulated cells.
        n_active_cells: usize,
        /// Cells whose density exceeds 1/2.
        n_body_cells: usize,
        /// Faces of the diffuse surface.
        n_faces: usize,
        /// Cells with at least one fibre.
        n_muscle_cells: usize,
        /// Of the preconditioner's Cholesky factors.
        factor_entries: usize,
        /// Taken since the design was set or the state was last set.
        steps: usize,
        /// Total since the design was set.
        newton_iterations: usize,
        /// Total of conjugate gradients (factorisations with [`Method::NewtonDirect`](crate::Method::NewtonDirect)).
        linear_iterations: usize,
        /// Of the backward sweeps of all its tapes.
        adjoint_iterations: usize,
        /// s: steps * time_step.
        time: f64,
        /// kg.
        total_mass: f64,
        /// m^3: sum of occupancy times cell volume.
        volume: f64,
        /// m.
        cell_size: f64,
        /// Relative force residual of the last step.
        last_residual: f64,
        /// Wall time of the last design, barycentre included.
        setup_seconds: f64,
        /// Its barycentre alone.
        barycenter_seconds: f64,
    }

    /// An actuator of the present design, as the interpolation made it of those of the bases.
    ActuatorInfo = dqa_actuator_info {
        /// In [0, 15].
        category: i32,
        /// Caudal or fins.
        kind: ActuatorKind,
        /// Of a fin.
        side: Side,
        /// Of fins; 1 for caudal.
        layers: usize,
        /// Of the category.
        n_signals: usize,
        /// Of the category: its index among those of the space.
        first_signal: usize,
        /// m.
        mean: [f64; 3],
        /// m^2, `[3][3]`.
        covariance: [f64; 9],
        /// m: distances of the box's faces from the mean.
        half: [f64; 3],
        /// `[3][3]`, a row per axis: unit normals of the faces.
        normal: [f64; 9],
        /// `[3][3]`, a row per axis: unit vectors along the edges.
        edge: [f64; 9],
        /// Sum of the weights of the bases that have the actuator.
        share: f64,
        /// Factor of its muscles' stiffness: fades smoothly from 1 to 0 as share goes from 5 % to 0.
        strength: f64,
    }

    /// Kind and sizes of a controller.
    ControllerInfo = dqa_controller_info {
        /// How it was made.
        kind: ControllerKind,
        /// Length of the actuation it writes.
        n_signals: usize,
        /// Length of the sensor vector it reads; 0: none.
        n_sensors: usize,
        /// Whether its derivative is known.
        has_pullback: bool,
        /// Length of theta.
        n_parameters: usize,
    }

    /// Memory, iterations and residuals of a tape.
    TapeStatistics = dqa_tape_statistics {
        /// Recorded.
        steps: usize,
        /// Held by recorded states and actuations.
        bytes: usize,
        /// Of the recorded steps.
        newton_iterations: usize,
        /// Of the recorded steps.
        linear_iterations: usize,
        /// Of all backward sweeps so far.
        adjoint_iterations: usize,
        /// Largest relative force residual of the recorded steps.
        worst_residual: f64,
        /// Largest relative residual of the adjoint's linear solves.
        worst_adjoint_residual: f64,
        /// States held by the tape: steps + 1 while all of them are.
        checkpoints: usize,
        /// Steps computed again by backward sweeps and reads so far.
        recomputed_steps: usize,
        /// Recorded steps in which the method of the options failed and another one found the answer.
        rescued_steps: usize,
        /// Recorded steps that met negative curvature on their way: another equilibrium may exist.
        indefinite_steps: usize,
    }

    /// What [`Simulator::check_gradient`](crate::Simulator::check_gradient) found.
    GradientReport = dqa_gradient_check_report {
        /// Whether the weights stand at the simplex's edge and differences were one-sided.
        one_sided: bool,
        /// Directional derivative by the adjoint.
        adjoint: f64,
        /// The same by the best step of the five-point ladder.
        finite_difference: f64,
        /// |adjoint - finite_difference| / |finite_difference|.
        relative_error: f64,
        /// Of |L(x + e d) - L(x) - e dL.d| over e: 2 for a correct gradient.
        taylor_slope: f64,
        /// 2-norm of the gradient.
        gradient_norm: f64,
        /// The step of the best difference.
        step: f64,
    }

    /// Sizes and progress of a search.
    CmaEsInfo = dqa_cma_es_info {
        /// Whether candidates wait for their values.
        asked: bool,
        /// Unknowns.
        n: usize,
        /// Candidates a generation.
        population: usize,
        /// Finished ones.
        generation: usize,
        /// Values told.
        evaluations: usize,
        /// Step size, in units of the scales.
        sigma: f64,
        /// Largest standard deviation of an unknown, in units of its scale: small when converged.
        widest: f64,
        /// Longest over shortest axis of the distribution: above 1e7 it is no longer well defined.
        axis_ratio: f64,
    }
}
