// SPDX-License-Identifier: MIT
//! Stopping calls from another thread.
use std::{fmt, ptr, sync::Arc};

use crate::{Result, handle::Handle, sys};

/// Stops the calls of all objects that were made with it in their options: they fail with
/// [`Status::Cancelled`](crate::Status::Cancelled) and stay usable. Clones are the same token.
#[derive(Clone)]
pub struct CancelToken(Arc<Token>);

struct Token(Handle<sys::dqa_cancel_token>);

// SAFETY: it may be set and reset from any thread, and the last clone frees it.
unsafe impl Send for Token {}
// SAFETY: as above.
unsafe impl Sync for Token {}

impl CancelToken {
    /// A new token that is not set.
    pub fn new() -> Result<Self> {
        // SAFETY: `out` is where the handle goes.
        Handle::create(sys::dqa_cancel_token_free, |out| unsafe { sys::dqa_cancel_token_create(out) })
            .map(|handle| CancelToken(Arc::new(Token(handle))))
    }

    /// Asks every call that watches the token to stop. From any thread, also from a signal handler.
    pub fn set(&self) {
        // SAFETY: the handle lives. It fails for NULL alone.
        unsafe { sys::dqa_cancel_token_set(self.0.0.get()) };
    }

    /// Lets the calls that watch the token run again. From any thread.
    pub fn reset(&self) {
        // SAFETY: as for set.
        unsafe { sys::dqa_cancel_token_reset(self.0.0.get()) };
    }

    /// NULL for none. Valid while the token lives; objects keep what they need of it.
    pub(crate) fn pointer(token: Option<&Self>) -> *mut sys::dqa_cancel_token {
        token.map_or(ptr::null_mut(), |token| token.0.0.get())
    }
}

impl fmt::Debug for CancelToken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("CancelToken")
    }
}
