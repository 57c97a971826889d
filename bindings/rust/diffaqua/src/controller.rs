// SPDX-License-Identifier: MIT
//! Parameters theta and the map (sensors, step) -> actuation of that step, each signal in [-1, 1].
use std::{ffi::c_void, fmt, ops::ControlFlow, path::Path, sync::Arc};

use crate::{
    Answer, CallbackOptions, ControllerInfo, PerceptronOptions, Result, callback,
    error::check,
    handle::{Handle, c_path, count, index, start},
    sys,
};

/// What a controller of closures is asked for.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct ControlInput<'a> {
    /// Number of the step.
    pub step: usize,
    /// s: step * time_step.
    pub time: f64,
    /// `[n_sensors]`, as of [`Simulator::sensors`](crate::Simulator::sensors) at the start of the step.
    pub sensors: &'a [f64],
    /// `[n_parameters]`.
    pub theta: &'a [f64],
}

type Evaluate = dyn Fn(ControlInput<'_>, &mut [f64]) -> ControlFlow<()> + Send + Sync;
type Pullback = dyn Fn(ControlInput<'_>, &[f64], &mut [f64], &mut [f64]) -> ControlFlow<()> + Send + Sync;

/// Closures of a controller. It and every tape that it drove share them.
pub(crate) struct Control {
    evaluate: Box<Evaluate>,
    pullback: Option<Box<Pullback>>,
}

unsafe extern "C" fn evaluate(
    step: i64,
    time: f64,
    sensors: *const f64,
    n_sensors: i64,
    theta: *const f64,
    n_parameters: i64,
    actuation: *mut f64,
    n_signals: i64,
    data: *mut c_void,
) -> i32 {
    // SAFETY: `data` is the Control that controller or tape keep; the arrays have as many elements as they say.
    callback::contained(|| unsafe {
        let (sensors, theta) = (callback::view(sensors, n_sensors), callback::view(theta, n_parameters));
        let input = ControlInput { step: step as usize, time, sensors, theta };
        ((*data.cast::<Control>()).evaluate)(input, callback::view_mut(actuation, n_signals))
    })
}

unsafe extern "C" fn pullback(
    step: i64,
    time: f64,
    sensors: *const f64,
    n_sensors: i64,
    theta: *const f64,
    n_parameters: i64,
    actuation_bar: *const f64,
    n_signals: i64,
    theta_bar: *mut f64,
    sensors_bar: *mut f64,
    data: *mut c_void,
) -> i32 {
    // SAFETY: as above.
    callback::contained(|| unsafe {
        let (sensors, theta) = (callback::view(sensors, n_sensors), callback::view(theta, n_parameters));
        let input = ControlInput { step: step as usize, time, sensors, theta };
        let bars = (callback::view_mut(theta_bar, n_parameters), callback::view_mut(sensors_bar, n_sensors));
        match &(*data.cast::<Control>()).pullback {
            Some(pullback) => pullback(input, callback::view(actuation_bar, n_signals), bars.0, bars.1),
            None => ControlFlow::Continue(()),
        }
    })
}

/// A sinusoid, a perceptron, or closures of the caller's.
pub struct Controller {
    // Freed before what its callbacks need.
    handle: Handle<sys::dqa_controller>,
    pub(crate) control: Option<Arc<Control>>,
}

// SAFETY: distinct objects may be used concurrently, and one by one thread at a time; the closures are Send and Sync.
unsafe impl Send for Controller {}

impl Controller {
    pub(crate) fn get(&self) -> *mut sys::dqa_controller {
        self.handle.get()
    }

    fn create(create: impl FnOnce(*mut *mut sys::dqa_controller) -> sys::dqa_status) -> Result<Self> {
        Handle::create(sys::dqa_controller_free, create).map(|handle| Controller { handle, control: None })
    }

    /// Open loop: a sin(omega t + phi) per signal; theta `[n_signals][3]` = (a in [0, 1], omega in rad/s, phi in rad).
    /// Initially a = 1, omega = pi / (6 time_step), phi = 0.
    pub fn sinusoid(n_signals: usize, time_step: f64) -> Result<Self> {
        // SAFETY: `out` is where the handle goes.
        Self::create(|out| unsafe { sys::dqa_controller_create_sinusoid(index(n_signals), time_step, out) })
    }

    /// Closed loop: a multilayer perceptron with tanh after every layer, whose initial weights come from a seed. It
    /// sees the sensors and, unless switched off, the time within a period. Theta: for each layer weights
    /// `[outputs][inputs]`, then biases `[outputs]`.
    pub fn perceptron(options: &PerceptronOptions) -> Result<Self> {
        // SAFETY: the struct lives for the call.
        Self::create(|out| unsafe { sys::dqa_controller_create_mlp(&options.raw(), out) })
    }

    /// A controller of the caller's own, with initial parameters theta: `evaluate(input, actuation)` writes
    /// all of `[n_signals]`, each in [-1, 1]. It must depend on its input alone. Without pullback an open loop still
    /// gives every gradient but [`Wrt::Control`](crate::Wrt::Control); an adjoint of a closed one is refused.
    pub fn callback<F, A>(options: &CallbackOptions, theta: &[f64], evaluate: F) -> Result<Self>
    where
        F: Fn(ControlInput<'_>, &mut [f64]) -> A + Send + Sync + 'static,
        A: Answer,
    {
        let evaluate = move |input: ControlInput<'_>, actuation: &mut [f64]| evaluate(input, actuation).flow();
        Self::share(options, theta, Control { evaluate: Box::new(evaluate), pullback: None })
    }

    /// The same with its derivative: `pullback(input, actuation_bar [n_signals], theta_bar [n_parameters], sensors_bar
    /// [n_sensors])` writes the transposed derivatives times actuation_bar into arrays of zeros.
    pub fn callback_with_pullback<F, A, P, B>(
        options: &CallbackOptions,
        theta: &[f64],
        evaluate: F,
        pullback: P,
    ) -> Result<Self>
    where
        F: Fn(ControlInput<'_>, &mut [f64]) -> A + Send + Sync + 'static,
        A: Answer,
        P: Fn(ControlInput<'_>, &[f64], &mut [f64], &mut [f64]) -> B + Send + Sync + 'static,
        B: Answer,
    {
        let evaluate = move |input: ControlInput<'_>, actuation: &mut [f64]| evaluate(input, actuation).flow();
        let pullback = move |input: ControlInput<'_>, bar: &[f64], theta_bar: &mut [f64], sensors_bar: &mut [f64]| {
            pullback(input, bar, theta_bar, sensors_bar).flow()
        };
        let control = Control { evaluate: Box::new(evaluate), pullback: Some(Box::new(pullback)) };
        Self::share(options, theta, control)
    }

    fn share(options: &CallbackOptions, theta: &[f64], control: Control) -> Result<Self> {
        let mut raw = options.raw();
        raw.evaluate = Some(evaluate);
        raw.pullback = if control.pullback.is_some() { Some(pullback) } else { None };
        let control = Arc::new(control);
        raw.user_data = Arc::as_ptr(&control).cast_mut().cast();
        // SAFETY: `control` is kept by this controller and by every tape that it drives.
        let mut made =
            Self::create(|out| unsafe { sys::dqa_controller_create_callback(&raw, start(theta), count(theta), out) })?;
        made.control = Some(control);
        Ok(made)
    }

    /// Kind and sizes.
    pub fn info(&self) -> Result<ControllerInfo> {
        // SAFETY: the handle lives; the library writes `size` bytes.
        ControllerInfo::ask(|out, size| unsafe { sys::dqa_controller_get_info(self.get(), out, size) })
    }

    /// Length of theta.
    pub fn n_parameters(&self) -> Result<usize> {
        let mut n = 0;
        // SAFETY: the handle lives.
        check(unsafe { sys::dqa_controller_n_parameters(self.get(), &mut n) })?;
        Ok(n as usize)
    }

    /// Theta `[n_parameters]`.
    pub fn parameters(&self) -> Result<Vec<f64>> {
        let mut theta = vec![0.0; self.n_parameters()?];
        // SAFETY: the array has as many elements as it says.
        check(unsafe { sys::dqa_controller_get_parameters(self.get(), theta.as_mut_ptr(), count(&theta)) })?;
        Ok(theta)
    }

    /// Replaces theta `[n_parameters]`. Tapes that it drove keep theirs.
    pub fn set_parameters(&mut self, theta: &[f64]) -> Result<()> {
        // SAFETY: the array has as many elements as it says.
        check(unsafe { sys::dqa_controller_set_parameters(self.get(), start(theta), count(theta)) })
    }

    /// Actuation `[n_signals]` at a step, e.g. for the caller's own loop over
    /// [`Simulator::step`](crate::Simulator::step). Sensors `[n_sensors]`; none for a controller that reads none.
    pub fn evaluate(&self, step: usize, sensors: &[f64]) -> Result<Vec<f64>> {
        let mut actuation = vec![0.0; self.info()?.n_signals];
        let (n_sensors, out, n) = (count(sensors), actuation.as_mut_ptr(), count(&actuation));
        // SAFETY: the arrays have as many elements as they say.
        check(unsafe { sys::dqa_controller_evaluate(self.get(), index(step), start(sensors), n_sensors, out, n) })?;
        Ok(actuation)
    }

    /// Writes settings and parameters to a file, whole or not at all ([`Status::Io`](crate::Status::Io)). Closures
    /// cannot be saved ([`Status::Unsupported`](crate::Status::Unsupported)).
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        let path = c_path(path.as_ref())?;
        // SAFETY: a C string that lives for the call.
        check(unsafe { sys::dqa_controller_save(self.get(), path.as_ptr()) })
    }

    /// The controller of a file that [`save`](Self::save) wrote; [`Status::File`](crate::Status::File) for any other.
    pub fn load(path: impl AsRef<Path>) -> Result<Self> {
        let path = c_path(path.as_ref())?;
        // SAFETY: a C string that lives for the call.
        Self::create(|out| unsafe { sys::dqa_controller_load(path.as_ptr(), out) })
    }
}

impl fmt::Debug for Controller {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Controller").field(&self.info()).finish()
    }
}
