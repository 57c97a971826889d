// SPDX-License-Identifier: MIT
//! The library's messages.
use std::{
    ffi::{c_char, c_void},
    panic::{self, AssertUnwindSafe},
    ptr,
    sync::{Arc, Mutex, PoisonError, RwLock},
};

use crate::{LogLevel, Result, callback, error::check, handle, info::FromRaw, sys};

type Handler = dyn Fn(LogLevel, &str) + Send + Sync;

// One for the process, as in the library. A message that is under way keeps the handler that it goes to.
static HANDLER: RwLock<Option<Arc<Handler>>> = RwLock::new(None);
static SETTING: Mutex<()> = Mutex::new(());

unsafe extern "C" fn pass_on(level: i32, message: *const c_char, _data: *mut c_void) {
    let call = || {
        let handler = HANDLER.read().unwrap_or_else(PoisonError::into_inner).clone();
        if let (Some(handler), Ok(level)) = (handler, LogLevel::from_raw(level)) {
            // SAFETY: a C string that lives for this call.
            handler(level, &unsafe { handle::text(message) });
        }
    };
    // A message may come from any thread and stops nothing: the panic hook has told what there is to tell.
    if let Err(payload) = panic::catch_unwind(AssertUnwindSafe(call)) {
        callback::discard(payload);
    }
}

/// Gives messages of `level` and graver ones to `handler`, from any thread, for the whole process; the handler before
/// it gets no more. It may call the library. A panic in it is reported by the panic hook and otherwise ignored. Texts
/// are for people and may change.
pub fn set_log_handler(level: LogLevel, handler: impl Fn(LogLevel, &str) + Send + Sync + 'static) -> Result<()> {
    let turn = SETTING.lock().unwrap_or_else(PoisonError::into_inner);
    let before = HANDLER.write().unwrap_or_else(PoisonError::into_inner).replace(Arc::new(handler));
    // SAFETY: pass_on lives as long as the process and needs no data.
    let done = check(unsafe { sys::dqa_set_log_handler(Some(pass_on), level as i32, ptr::null_mut()) });
    drop(turn);
    drop(before); // outside of the locks: it is the caller's code
    done
}

/// Silences the library, which is how it starts.
pub fn remove_log_handler() -> Result<()> {
    let turn = SETTING.lock().unwrap_or_else(PoisonError::into_inner);
    // SAFETY: NULL is allowed.
    let done = check(unsafe { sys::dqa_set_log_handler(None, 0, ptr::null_mut()) });
    let before = HANDLER.write().unwrap_or_else(PoisonError::into_inner).take();
    drop(turn);
    drop(before);
    done
}
