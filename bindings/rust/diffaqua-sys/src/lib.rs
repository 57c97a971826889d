// SPDX-License-Identifier: MIT
//! Declarations of libdiffaqua's C interface, as bindgen reads them from `diffaqua.h`. That header explains every
//! function, field and constant: shapes, units, ownership, errors, threads. The crate `diffaqua` is the safe way to use
//! them.
#![no_std]
#![allow(non_camel_case_types, missing_docs)]

include!("bindings.rs");
