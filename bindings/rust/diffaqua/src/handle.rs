// SPDX-License-Identifier: MIT
//! Objects of the library as values that are freed when dropped, and how strings, paths and slices go in and out.
use std::{
    ffi::{CStr, CString, c_char},
    mem::MaybeUninit,
    path::Path,
    ptr::{self, NonNull},
};

use crate::{Error, Result, Status, abi_version, error::check, sys};

/// Owns one handle of the library.
pub(crate) struct Handle<T> {
    pointer: NonNull<T>,
    free: unsafe extern "C" fn(*mut T),
}

impl<T> Handle<T> {
    /// `create` writes a handle that `free` frees.
    pub(crate) fn create(
        free: unsafe extern "C" fn(*mut T),
        create: impl FnOnce(*mut *mut T) -> sys::dqa_status,
    ) -> Result<Self> {
        let loaded = abi_version();
        if loaded != sys::DQA_ABI_VERSION {
            let message =
                format!("the loaded library has ABI {loaded}, this crate was made for {}", sys::DQA_ABI_VERSION);
            return Err(Error::new(Status::Unsupported, message));
        }
        let mut pointer = ptr::null_mut();
        check(create(&mut pointer))?;
        let pointer = NonNull::new(pointer).expect("creators that succeed write a handle");
        Ok(Handle { pointer, free })
    }

    pub(crate) fn get(&self) -> *mut T {
        self.pointer.as_ptr()
    }
}

impl<T> Drop for Handle<T> {
    fn drop(&mut self) {
        // SAFETY: the handle came from its creator and nobody else frees it.
        unsafe { (self.free)(self.pointer.as_ptr()) }
    }
}

/// Reads a struct that the library fills: `fill` gets the struct and its size.
///
/// # Safety
/// All bits zero must be a value of `T`.
pub(crate) unsafe fn filled<T>(fill: impl FnOnce(*mut T, u64) -> sys::dqa_status) -> Result<T> {
    let mut out = MaybeUninit::<T>::zeroed();
    check(fill(out.as_mut_ptr(), size_of::<T>() as u64))?;
    // SAFETY: zeros are a value, says the caller, and the library wrote fields of it.
    Ok(unsafe { out.assume_init() })
}

/// A copy of a C string; file names in messages may be of any encoding.
///
/// # Safety
/// `pointer` is a C string.
pub(crate) unsafe fn text(pointer: *const c_char) -> String {
    // SAFETY: as the caller says.
    unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned()
}

/// # Safety
/// `pointer` is a static C string.
pub(crate) unsafe fn static_text(pointer: *const c_char) -> &'static str {
    // SAFETY: as the caller says.
    unsafe { CStr::from_ptr(pointer) }.to_str().unwrap_or("")
}

/// A name as the library takes it.
pub(crate) fn c_name(what: &str, name: &str) -> Result<CString> {
    CString::new(name).map_err(|_| Error::argument(format!("{what}: expected text without NUL, got {name:?}")))
}

/// A path as the library takes it.
pub(crate) fn c_path(path: &Path) -> Result<CString> {
    #[cfg(unix)]
    let bytes = std::os::unix::ffi::OsStrExt::as_bytes(path.as_os_str()).to_vec();
    #[cfg(not(unix))]
    let bytes = path.to_string_lossy().into_owned().into_bytes();
    CString::new(bytes).map_err(|_| Error::argument(format!("path: expected one without NUL, got {path:?}")))
}

/// Start of a slice; NULL when it is empty.
pub(crate) fn start<T>(values: &[T]) -> *const T {
    if values.is_empty() { ptr::null() } else { values.as_ptr() }
}

/// Start of a slice or NULL, and its length; None: not wanted.
pub(crate) fn wanted<T>(values: Option<&mut [T]>) -> (*mut T, i64) {
    values.map_or((ptr::null_mut(), 0), |values| (values.as_mut_ptr(), count(values)))
}

/// Start of a slice or NULL, and its length; None: a default of the library's.
pub(crate) fn given<T>(values: Option<&[T]>) -> (*const T, i64) {
    values.map_or((ptr::null(), 0), |values| (values.as_ptr(), count(values)))
}

/// Length of a slice as the library counts: slices have at most isize::MAX bytes.
pub(crate) fn count<T>(values: &[T]) -> i64 {
    values.len() as i64
}

/// An index or number as the library takes it. What does not fit becomes a number that every check refuses.
pub(crate) fn index<T: TryFrom<usize> + Bounded>(value: usize) -> T {
    T::try_from(value).unwrap_or(T::MOST)
}

/// The largest number of a type.
pub(crate) trait Bounded {
    const MOST: Self;
}
impl Bounded for i32 {
    const MOST: i32 = i32::MAX;
}
impl Bounded for i64 {
    const MOST: i64 = i64::MAX;
}
