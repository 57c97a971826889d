// SPDX-License-Identifier: MIT
//! The library that was linked is the one that the declarations are of.
use std::ffi::CStr;

use diffaqua_sys::*;

#[test]
fn library_is_that_of_the_header() {
    // SAFETY: they take nothing, and the string is static.
    let (abi, version) = unsafe { (dqa_abi_version(), CStr::from_ptr(dqa_version())) };
    assert_eq!(abi, DQA_ABI_VERSION);
    let header = format!("{DQA_VERSION_MAJOR}.{DQA_VERSION_MINOR}.{DQA_VERSION_PATCH}");
    assert_eq!((version.to_str(), env!("CARGO_PKG_VERSION")), (Ok(header.as_str()), header.as_str()));
}

#[test]
fn options_are_as_large_as_the_library_thinks() {
    let mut options = std::mem::MaybeUninit::<dqa_simulator_options>::zeroed();
    let size = size_of::<dqa_simulator_options>();
    // SAFETY: the library writes `size` bytes; zeros are a value of the struct.
    let options = unsafe {
        assert_eq!(dqa_simulator_options_init(options.as_mut_ptr(), size as u64), DQA_SUCCESS);
        options.assume_init()
    };
    assert_eq!(options.struct_size as usize, size);
    assert_eq!((options.time_step, options.quadrature), (1.0 / 30.0, DQA_QUADRATURE_REDUCED));
}
