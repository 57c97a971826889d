// SPDX-License-Identifier: MIT
//! Co-design of soft underwater swimmers: shapes, bodies, water and controllers, with gradients. A safe and thin layer
//! over libdiffaqua's C interface, whose header `diffaqua.h` explains every quantity.
//!
//! ```
//! # fn main() -> diffaqua::Result<()> {
//! use diffaqua::*;
//! let slim: Vec<[f64; 2]> = (0..24).map(|i| f64::from(i) * 0.2618).map(|t| [t.cos(), 0.2 * t.sin()]).collect();
//! let stout: Vec<[f64; 2]> = slim.iter().map(|corner| [corner[0], 1.6 * corner[1]]).collect();
//! let options = ShapeSpaceOptions::new().dims(2).cells_x(20).cells_y(8).sigma(0.75);
//! let mut bases = ShapeSpaceBuilder::new(&options)?;
//! bases.add_polygon("slim", &slim)?;
//! bases.add_polygon("stout", &stout)?;
//! let mut simulator = Simulator::new(&bases.build()?, &SimulatorOptions::new().young_modulus(2e5))?;
//! simulator.set_weights(&[0.5, 0.5])?; // a design: density, cells, muscles
//! let mut tape = Tape::new(&simulator)?;
//! let sine = Controller::sinusoid(simulator.info()?.n_signals, 1.0 / 30.0)?;
//! simulator.rollout(&sine, 5, Some(&mut tape))?;
//! let [weights, control] = tape.gradient(&[ObjectiveTerm::new(Objective::Travel)], [Wrt::Weights, Wrt::Control])?;
//! assert_eq!((weights.len(), control.len()), (2, 3));
//! # Ok(())
//! # }
//! ```
//!
//! - **Arrays** are flat and row-major; the shape stands in the documentation, `[n_nodes][dims]`, and is checked.
//! - **Units** are SI: metres, seconds, kilograms, newtons, pascals.
//! - **Errors** are [`Error`]s with a [`Status`] and the library's message. Any call fails with [`Status::Argument`] for
//!   an array of the wrong length or a number out of its range, and with [`Status::State`] for what an object cannot do
//!   yet or any more; other failures stand at the calls.
//! - **Objects** are freed when dropped, in any order: what is made from one keeps what it needs of it. An [`Adjoint`]
//!   borrows its [`Tape`], since nothing may be recorded while one walks over it.
//! - **Threads.** All objects may move between threads. A [`ShapeSpace`], a [`Tape`] and a [`CancelToken`] may be
//!   shared.
//! - **Callbacks** are closures that return `()` or [`ControlFlow`](std::ops::ControlFlow): `Break(())` stops the call
//!   with [`Status::Cancelled`]. A panic in one stops the call as well, never crosses the library, and goes on where
//!   the call returns; the objects stay usable.

mod callback;
mod cancel;
mod cma_es;
mod constants;
mod controller;
mod error;
mod geometry;
mod handle;
mod info;
mod log;
mod objective;
mod optimize;
mod options;
mod shape_space;
mod simulator;
mod tape;
mod water;

pub use callback::Answer;
pub use cancel::CancelToken;
pub use cma_es::CmaEs;
pub use constants::*;
pub use controller::{ControlInput, Controller};
pub use diffaqua_sys as sys;
pub use error::{Error, Result, Status};
pub use geometry::{Mesh, Muscles, Surface};
pub use info::*;
pub use log::{remove_log_handler, set_log_handler};
pub use objective::ObjectiveTerm;
pub use optimize::{adam_step, project_simplex};
pub use options::*;
pub use shape_space::{ShapeSpace, ShapeSpaceBuilder, Unbuilt};
pub use simulator::{Simulator, State};
pub use tape::{Adjoint, Tape};

/// Version of the loaded library, "major.minor.patch".
pub fn version() -> &'static str {
    // SAFETY: a static string, as the header says.
    unsafe { handle::static_text(sys::dqa_version()) }
}

/// Generation of the loaded library's interface; this crate was made for [`sys::DQA_ABI_VERSION`].
pub fn abi_version() -> i32 {
    // SAFETY: takes nothing.
    unsafe { sys::dqa_abi_version() }
}

/// What the loaded library can do, separated by spaces, e.g. "stl obj ply cholmod umfpack openmp avx2 avx512".
pub fn features() -> &'static str {
    // SAFETY: a static string, as the header says.
    unsafe { handle::static_text(sys::dqa_features()) }
}

/// The lines of the README are compiled and run as they stand there.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;
