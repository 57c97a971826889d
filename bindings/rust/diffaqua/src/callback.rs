// SPDX-License-Identifier: MIT
//! Closures that the library calls. A panic never crosses it: it is kept for this thread, the call is asked to stop,
//! and `check` lets the panic go on where the call returns. All callbacks but the log's run on the thread of the call.
use std::{
    any::Any,
    cell::RefCell,
    ffi::c_void,
    mem,
    ops::ControlFlow,
    panic::{self, AssertUnwindSafe},
    slice,
};

use crate::{Result, error::check, sys};

/// What a callback may return: `()` to go on, or a [`ControlFlow`] of which `Break(())` stops the call.
pub trait Answer {
    /// Whether to go on.
    fn flow(self) -> ControlFlow<()>;
}

impl Answer for () {
    fn flow(self) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

impl Answer for ControlFlow<()> {
    fn flow(self) -> ControlFlow<()> {
        self
    }
}

thread_local! {
    static PANIC: RefCell<Option<Box<dyn Any + Send>>> = const { RefCell::new(None) };
}

/// Runs a closure for the library: 0 to go on, 1 to stop.
pub(crate) fn contained(call: impl FnOnce() -> ControlFlow<()>) -> i32 {
    match panic::catch_unwind(AssertUnwindSafe(call)) {
        Ok(ControlFlow::Continue(())) => 0,
        Ok(ControlFlow::Break(())) => 1,
        Err(payload) => {
            let mut payload = Some(payload);
            let _ = PANIC.try_with(|kept| {
                let mut kept = kept.borrow_mut();
                if kept.is_none() {
                    *kept = payload.take(); // the first one counts
                }
            });
            if let Some(later) = payload {
                discard(later);
            }
            1
        }
    }
}

/// Drops what a panic carried, which may panic again.
pub(crate) fn discard(payload: Box<dyn Any + Send>) {
    if let Err(again) = panic::catch_unwind(AssertUnwindSafe(|| drop(payload))) {
        mem::forget(again);
    }
}

/// Goes on with the panic of a callback of the call that just returned.
pub(crate) fn resume() {
    if let Some(payload) = PANIC.try_with(RefCell::take).ok().flatten() {
        panic::resume_unwind(payload);
    }
}

/// # Safety
/// `n` elements are readable at `pointer`, or n is 0.
pub(crate) unsafe fn view<'a>(pointer: *const f64, n: i64) -> &'a [f64] {
    // SAFETY: as the caller says.
    if n <= 0 || pointer.is_null() { &[] } else { unsafe { slice::from_raw_parts(pointer, n as usize) } }
}

/// # Safety
/// `n` elements are writable at `pointer` by nobody else, or n is 0.
pub(crate) unsafe fn view_mut<'a>(pointer: *mut f64, n: i64) -> &'a mut [f64] {
    // SAFETY: as the caller says.
    if n <= 0 || pointer.is_null() { &mut [] } else { unsafe { slice::from_raw_parts_mut(pointer, n as usize) } }
}

/// A call that tells `progress` how far it is: (done, total).
pub(crate) fn with_progress<P, A>(
    mut progress: P,
    call: impl FnOnce(sys::dqa_progress, *mut c_void) -> sys::dqa_status,
) -> Result<()>
where
    P: FnMut(usize, usize) -> A,
    A: Answer,
{
    unsafe extern "C" fn report<P: FnMut(usize, usize) -> A, A: Answer>(
        done: i64,
        total: i64,
        data: *mut c_void,
    ) -> i32 {
        // SAFETY: the closure of with_progress, which waits for the call; one thread calls, one call at a time.
        contained(|| unsafe { &mut *data.cast::<P>() }(done as usize, total as usize).flow())
    }
    check(call(Some(report::<P, A>), (&raw mut progress).cast()))
}
