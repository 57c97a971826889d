// SPDX-License-Identifier: MIT
//! Velocity of the water over time, as a table or a closure.
use std::{ffi::c_void, ops::ControlFlow, ptr, sync::Arc};

use crate::{
    Answer, Result, Simulator, callback,
    error::check,
    handle::{count, start},
    sys,
};

type Velocity = dyn Fn(f64, &mut [f64]) -> ControlFlow<()> + Send + Sync;
type Pullback = dyn Fn(f64, &[f64]) -> ControlFlow<()> + Send + Sync;

/// Closures of a current. The simulator and every tape with steps of it share them.
pub(crate) struct Current {
    dims: i64,
    velocity: Box<Velocity>,
    pullback: Option<Box<Pullback>>,
}

unsafe extern "C" fn velocity(time: f64, current: *mut f64, data: *mut c_void) -> i32 {
    // SAFETY: `data` is the Current that the simulator or the tape of the step keeps; current has dims elements.
    callback::contained(|| unsafe {
        let shared = &*data.cast::<Current>();
        (shared.velocity)(time, callback::view_mut(current, shared.dims))
    })
}

unsafe extern "C" fn pullback(time: f64, current_bar: *const f64, data: *mut c_void) -> i32 {
    // SAFETY: as for the velocity.
    callback::contained(|| unsafe {
        let shared = &*data.cast::<Current>();
        match &shared.pullback {
            Some(pullback) => pullback(time, callback::view(current_bar, shared.dims)),
            None => ControlFlow::Continue(()),
        }
    })
}

impl Simulator {
    /// Velocity of the water (m/s), linear between velocities `[n_times][dims]` at times `[n_times]` (s, increasing),
    /// constant before and after, for the steps from here on. No times: back to the option `current`.
    pub fn set_current_table(&mut self, times: &[f64], velocities: &[f64]) -> Result<()> {
        let (n_times, n) = (count(times), count(velocities));
        // SAFETY: the arrays have as many elements as they say.
        check(unsafe {
            sys::dqa_simulator_set_current_table(self.get(), start(times), n_times, start(velocities), n)
        })?;
        (self.current, self.table_rows) = (None, times.len().max(1));
        Ok(())
    }

    /// Velocity of the water from a closure that is asked once a step: `velocity(time, current)` writes `[dims]` (m/s)
    /// into an array of zeros.
    pub fn set_current<F, A>(&mut self, velocity: F) -> Result<()>
    where
        F: Fn(f64, &mut [f64]) -> A + Send + Sync + 'static,
        A: Answer,
    {
        self.share(Box::new(move |time, current| velocity(time, current).flow()), None)
    }

    /// The same with a pullback for parameters of the caller's own: during a backward sweep `pullback(time,
    /// current_bar)` gets `[dims]` = dL/d(current) of every step, last step first.
    pub fn set_current_with_pullback<F, A, P, B>(&mut self, velocity: F, pullback: P) -> Result<()>
    where
        F: Fn(f64, &mut [f64]) -> A + Send + Sync + 'static,
        A: Answer,
        P: Fn(f64, &[f64]) -> B + Send + Sync + 'static,
        B: Answer,
    {
        let pullback = move |time: f64, current_bar: &[f64]| pullback(time, current_bar).flow();
        self.share(Box::new(move |time, current| velocity(time, current).flow()), Some(Box::new(pullback)))
    }

    /// Back to the option `current`.
    pub fn reset_current(&mut self) -> Result<()> {
        // SAFETY: NULL is allowed.
        check(unsafe { sys::dqa_simulator_set_current_callback(self.get(), None, None, ptr::null_mut()) })?;
        (self.current, self.table_rows) = (None, 1);
        Ok(())
    }

    fn share(&mut self, ask: Box<Velocity>, pull: Option<Box<Pullback>>) -> Result<()> {
        let back: sys::dqa_current_pullback = if pull.is_some() { Some(pullback) } else { None };
        let shared = Arc::new(Current { dims: self.info()?.dims as i64, velocity: ask, pullback: pull });
        let data = Arc::as_ptr(&shared).cast_mut().cast();
        // SAFETY: `shared` is kept by this simulator and by every tape that records steps of it.
        check(unsafe { sys::dqa_simulator_set_current_callback(self.get(), Some(velocity), back, data) })?;
        (self.current, self.table_rows) = (Some(shared), 1);
        Ok(())
    }
}
