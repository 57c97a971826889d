// SPDX-License-Identifier: MIT
//! A status of the library as a `Result`.
use std::{error, fmt};

use crate::{callback, handle, sys};

/// What kind of failure it was: `DQA_ERROR_*` and its neighbours of the header.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Status {
    /// An argument is out of its range; the message names it.
    Argument,
    /// The call does not fit the state of the object.
    State,
    /// A file's content is not what was expected.
    File,
    /// A file could not be opened, read or written.
    Io,
    /// A mesh is open, inconsistently oriented, empty or not finite.
    Mesh,
    /// Out of memory.
    Memory,
    /// This build or version cannot do it.
    Unsupported,
    /// An iteration stopped above its tolerance; the message names step, residual and cell.
    NotConverged,
    /// A state became non-finite; the message names the step.
    Diverged,
    /// A callback or cancel token asked to stop; the object is still usable.
    Cancelled,
    /// A defect of the library: please report it.
    Internal,
    /// A code that a later version of the library has.
    Other(i32),
}

const CODES: [(Status, i32); 11] = [
    (Status::Argument, sys::DQA_ERROR_ARGUMENT),
    (Status::State, sys::DQA_ERROR_STATE),
    (Status::File, sys::DQA_ERROR_FILE),
    (Status::Io, sys::DQA_ERROR_IO),
    (Status::Mesh, sys::DQA_ERROR_MESH),
    (Status::Memory, sys::DQA_ERROR_MEMORY),
    (Status::Unsupported, sys::DQA_ERROR_UNSUPPORTED),
    (Status::NotConverged, sys::DQA_NOT_CONVERGED),
    (Status::Diverged, sys::DQA_DIVERGED),
    (Status::Cancelled, sys::DQA_CANCELLED),
    (Status::Internal, sys::DQA_ERROR_INTERNAL),
];

impl Status {
    /// The status of a negative code.
    pub fn from_code(code: i32) -> Self {
        CODES.iter().find(|entry| entry.1 == code).map_or(Status::Other(code), |entry| entry.0)
    }

    /// The code of the header.
    pub fn code(self) -> i32 {
        match self {
            Status::Other(code) => code,
            known => CODES.iter().find(|entry| entry.0 == known).map_or(sys::DQA_ERROR_INTERNAL, |entry| entry.1),
        }
    }

    /// Its name in the header, e.g. "DQA_ERROR_MESH".
    pub fn name(self) -> &'static str {
        // SAFETY: any number is allowed; a static string, as the header says.
        unsafe { handle::static_text(sys::dqa_status_name(self.code())) }
    }

    /// One sentence on what it means.
    pub fn text(self) -> &'static str {
        // SAFETY: as for the name.
        unsafe { handle::static_text(sys::dqa_status_text(self.code())) }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A call that failed: its status, and which argument was wrong, what was expected and what came.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    status: Status,
    message: String,
}

/// What calls of this crate return.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    pub(crate) fn new(status: Status, message: impl Into<String>) -> Self {
        Error { status, message: message.into() }
    }

    pub(crate) fn argument(message: impl Into<String>) -> Self {
        Error::new(Status::Argument, message)
    }

    /// What kind of failure it was.
    pub fn status(&self) -> Status {
        self.status
    }

    /// The library's message.
    pub fn message(&self) -> &str {
        &self.message
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl error::Error for Error {}

/// After every call of the library: goes on with the panic of a callback, or tells what failed.
pub(crate) fn check(status: sys::dqa_status) -> Result<()> {
    callback::resume();
    if status == sys::DQA_SUCCESS {
        return Ok(());
    }
    // SAFETY: never NULL, and valid until this thread's next failing call.
    let message = unsafe { handle::text(sys::dqa_last_error()) };
    Err(Error::new(Status::from_code(status), message))
}

/// The error of an array of the wrong length, where the library takes only one count for several.
pub(crate) fn require_length(name: &str, got: usize, expected: usize, shape: &str) -> Result<()> {
    if got == expected {
        return Ok(());
    }
    Err(Error::argument(format!("{name}: expected {expected} elements, {name} {shape}, got {got}")))
}
