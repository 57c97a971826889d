// SPDX-License-Identifier: MIT
//! The constants of the header as enumerations.
use crate::{Error, Result, Status, info::FromRaw, options::IntoRaw, sys};

macro_rules! constants {
    ($($(#[$doc:meta])* $name:ident { $($(#[$entry_doc:meta])* $entry:ident = $value:expr,)* })*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[non_exhaustive]
        #[repr(i32)]
        pub enum $name {
            $($(#[$entry_doc])* $entry = $value,)*
        }

        impl IntoRaw<i32> for $name {
            fn into_raw(self) -> i32 {
                self as i32
            }
        }

        impl FromRaw<i32> for $name {
            fn from_raw(raw: i32) -> Result<Self> {
                [$($name::$entry),*].into_iter().find(|entry| *entry as i32 == raw).ok_or_else(|| {
                    Error::new(
                        Status::Unsupported,
                        format!("{}: the library says {raw}, which this version does not know", stringify!($name)),
                    )
                })
            }
        }
    )*};
}

constants! {
    /// What the density is divided by.
    Peak {
        /// sum p^65 / sum p^64: differentiable.
        Smooth = sys::DQA_PEAK_SMOOTH,
        /// max p, as the paper; its derivative is that of one cell and fails finite differences.
        Paper = sys::DQA_PEAK_PAPER,
    }

    /// Which way meshes stand.
    Up {
        /// The lateral axis is the one across which the mesh mirrors best; ties keep +z up.
        Auto = sys::DQA_UP_AUTO,
        /// As it is: x heading, z up.
        Z = sys::DQA_UP_Z,
        /// y up: turned by 90 degrees about x.
        Y = sys::DQA_UP_Y,
    }

    /// How actuators are interpolated between the bases.
    Interpolation {
        /// Mean, eigenvalues and Euler angles are linear in the weights, as in the paper.
        Linear = sys::DQA_INTERPOLATION_LINEAR,
        /// Mean linear, covariance the Bures-Wasserstein barycentre.
        Bures = sys::DQA_INTERPOLATION_BURES,
    }

    /// Kinds of actuator.
    ActuatorKind {
        /// Antagonistic pair split at the plane y = 0, fibres along x: one signal.
        Caudal = sys::DQA_ACTUATOR_CAUDAL,
        /// A left and a right fin that share 4 signals per layer.
        Fins = sys::DQA_ACTUATOR_FINS,
    }

    /// Sides of an actuator.
    Side {
        /// Caudal; or fins of which the left one is described and the right one mirrors it at y = 0.
        Both = sys::DQA_SIDE_BOTH,
        /// The fin at y > 0 alone.
        Left = sys::DQA_SIDE_LEFT,
        /// The fin at y < 0 alone.
        Right = sys::DQA_SIDE_RIGHT,
    }

    /// How the equations of a step are solved.
    Method {
        /// Newton, conjugate gradients with the scene's preconditioner.
        NewtonPcg = sys::DQA_METHOD_NEWTON_PCG,
        /// Newton with a sparse factorisation of the exact Hessian: the oracle.
        NewtonDirect = sys::DQA_METHOD_NEWTON_DIRECT,
        /// L-BFGS on the projective-dynamics factor, as the paper.
        Projective = sys::DQA_METHOD_PROJECTIVE,
    }

    /// Preconditioner of conjugate gradients: speed only.
    Preconditioner {
        /// Diagonal blocks and a multigrid cycle, turned with the body.
        Multilevel = sys::DQA_PRECONDITIONER_MULTILEVEL,
        /// The projective-dynamics factor.
        Factor = sys::DQA_PRECONDITIONER_FACTOR,
    }

    /// Precision of the preconditioner alone.
    Precision {
        /// 24 bits: half the memory traffic.
        Single = sys::DQA_PRECISION_SINGLE,
        /// 53 bits.
        Double = sys::DQA_PRECISION_DOUBLE,
    }

    /// Instructions of the kernels: speed only.
    InstructionSet {
        /// The widest that the processor has.
        Automatic = 0,
        /// What every processor of the architecture has.
        Baseline = 1,
        /// AVX2.
        Avx2 = 2,
        /// AVX-512.
        Avx512 = 3,
    }

    /// Integration in time.
    Integrator {
        /// First order, strongly damped, as the paper.
        ImplicitEuler = sys::DQA_INTEGRATOR_IMPLICIT_EULER,
        /// Second order at the same cost.
        Bdf2 = sys::DQA_INTEGRATOR_BDF2,
    }

    /// Elastic energy densities.
    Material {
        /// mu |F - R|^2, as the paper.
        Corotated = sys::DQA_MATERIAL_COROTATED,
        /// mu |F - R|^2 + lambda/2 (tr(R^T F) - 3)^2.
        CorotatedVolume = sys::DQA_MATERIAL_COROTATED_VOLUME,
        /// Stable neo-Hookean with the same small-strain moduli.
        NeoHookean = sys::DQA_MATERIAL_NEO_HOOKEAN,
    }

    /// Points a cell at which elastic energies are integrated.
    Quadrature {
        /// 2^dims Gauss points, as the paper.
        Full = sys::DQA_QUADRATURE_FULL,
        /// One point, with hourglass control.
        Reduced = sys::DQA_QUADRATURE_REDUCED,
    }

    /// The water's forces.
    Water {
        /// None: the body moves in empty space.
        None = sys::DQA_WATER_NONE,
        /// Inside the implicit step.
        Implicit = sys::DQA_WATER_IMPLICIT,
        /// Explicit, for comparison.
        Explicit = sys::DQA_WATER_EXPLICIT,
    }

    /// Which faces of the surface the water acts on.
    Faces {
        /// All, as the paper's equations say.
        Both = sys::DQA_FACES_BOTH,
        /// Those that move into the water, for comparison.
        Windward = sys::DQA_FACES_WINDWARD,
    }

    /// Kinds of controller.
    ControllerKind {
        /// [`Controller::sinusoid`](crate::Controller::sinusoid).
        Sinusoid = sys::DQA_CONTROLLER_SINUSOID,
        /// [`Controller::perceptron`](crate::Controller::perceptron).
        Mlp = sys::DQA_CONTROLLER_MLP,
        /// [`Controller::callback`](crate::Controller::callback).
        Callback = sys::DQA_CONTROLLER_CALLBACK,
    }

    /// Terms of a loss; the header has their formulas.
    Objective {
        /// Minus the distance travelled (m).
        Travel = sys::DQA_OBJECTIVE_TRAVEL,
        /// Distance of the centre sensor from a point, less gamma times how far the head lies ahead of the tail (m).
        PositionKeeping = sys::DQA_OBJECTIVE_POSITION_KEEPING,
        /// Minus the sum over the steps of |P_t| / (1 + |P_t| + |P_d|), thrust and drag times velocity. Needs water.
        Efficiency = sys::DQA_OBJECTIVE_EFFICIENCY,
        /// Time step times the sum of actuation^2 (s).
        Effort = sys::DQA_OBJECTIVE_EFFORT,
        /// Distance of the centre sensor from a point that moves along a polyline, summed over the steps (m).
        Path = sys::DQA_OBJECTIVE_PATH,
    }

    /// What [`Adjoint::seed`](crate::Adjoint::seed) adds to.
    Seed {
        /// dL/dq of the state after a step.
        Position = sys::DQA_SEED_POSITION,
        /// dL/dv of the state after a step.
        Velocity = sys::DQA_SEED_VELOCITY,
    }

    /// What a gradient is taken with respect to, and its shape.
    Wrt {
        /// `[n_bases]`, mean-free.
        Weights = sys::DQA_WRT_WEIGHTS,
        /// `[n_parameters]` of the controller of the rollout.
        Control = sys::DQA_WRT_CONTROL,
        /// `[n_steps][n_signals]`, of numbers added to each actuation: a closed loop reacts.
        Actuation = sys::DQA_WRT_ACTUATION,
        /// `[n_nodes][dims]`.
        InitialPosition = sys::DQA_WRT_INITIAL_POSITION,
        /// `[n_nodes][dims]`.
        InitialVelocity = sys::DQA_WRT_INITIAL_VELOCITY,
        /// `[dims + 9]`: a uniform velocity added to the current of every step `[dims]`, the water's density, drag
        /// coefficients `[4]`, thrust coefficients `[4]`; zero without water.
        Water = sys::DQA_WRT_WATER,
        /// `[n_steps][dims]`: the current of each step.
        Current = sys::DQA_WRT_CURRENT,
        /// `[n_times][dims]`: velocities of the table of currents; one row without a table.
        CurrentTable = sys::DQA_WRT_CURRENT_TABLE,
        /// `[n_cells]` of the full box: Young's modulus of each cell (1/Pa).
        YoungsModulus = sys::DQA_WRT_YOUNGS_MODULUS,
        /// `[n_cells]` of the full box: the muscle stiffness of each cell (1/Pa).
        MuscleStiffness = sys::DQA_WRT_MUSCLE_STIFFNESS,
        /// `[4]`: Young's modulus and muscle stiffness of all cells together, Poisson's ratio, density.
        Material = sys::DQA_WRT_MATERIAL,
        /// `[2]`: mu and lambda of all cells together, each with the other held (1/Pa).
        Lame = sys::DQA_WRT_LAME,
    }

    /// Levels of the library's messages, the gravest first.
    LogLevel {
        /// A call is about to fail for a reason that its message does not hold.
        Error = sys::DQA_LOG_ERROR,
        /// The result is right, but not the way or the input that one would expect.
        Warning = sys::DQA_LOG_WARNING,
        /// About one message a call.
        Info = sys::DQA_LOG_INFO,
        /// About one message a step or solve.
        Debug = sys::DQA_LOG_DEBUG,
    }
}
