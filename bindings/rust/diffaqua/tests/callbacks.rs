// SPDX-License-Identifier: MIT
//! Closures of every kind but the log's: what they say is used, stops and panics come out where the call returns, the
//! objects stay usable, and closures live as long as what needs them and no longer.
mod scene;

use std::{
    any::Any,
    ops::ControlFlow,
    panic::{AssertUnwindSafe, catch_unwind},
    sync::{
        Arc, Mutex,
        atomic::{AtomicUsize, Ordering},
    },
};

use diffaqua::*;
use scene::*;

/// Runs `call`, which must panic with a value of type T.
fn panic_of<T: Any>(call: impl FnOnce()) -> T {
    let payload = catch_unwind(AssertUnwindSafe(call)).expect_err("expected a panic");
    *payload.downcast().expect("a panic of another kind")
}

/// A value that no message of the standard library has.
#[derive(Debug, PartialEq)]
struct Raised(&'static str);

fn raise(what: &'static str) {
    std::panic::panic_any(Raised(what))
}

fn sine() -> Controller {
    let mut sine = Controller::sinusoid(1, TIME_STEP).unwrap();
    sine.set_parameters(&[0.75, 12.0, 0.25]).unwrap();
    sine
}

/// theta = (a, omega); the same actuation as a sinusoid of phase 0.
fn evaluate(input: ControlInput<'_>, actuation: &mut [f64]) {
    actuation[0] = input.theta[0] * (input.theta[1] * input.time).sin();
}

fn pullback(input: ControlInput<'_>, bar: &[f64], theta_bar: &mut [f64], sensors_bar: &mut [f64]) {
    let angle = input.theta[1] * input.time;
    theta_bar[0] = bar[0] * angle.sin();
    theta_bar[1] = bar[0] * input.theta[0] * input.time * angle.cos();
    assert!(input.sensors.is_empty() && sensors_bar.is_empty());
}

#[test]
fn progress_is_told_stops_and_panics() {
    let mut last = (0, 0);
    let space = bases(&ShapeSpaceOptions::new())
        .build_with(|done, total| {
            assert!(done <= total);
            last = (done, total);
        })
        .unwrap();
    assert!(last.1 > 0 && last.0 == last.1, "{last:?}");

    let stopped = bases(&ShapeSpaceOptions::new()).build_with(|_, _| ControlFlow::Break(())).unwrap_err();
    assert_eq!(stopped.error.status(), Status::Cancelled);
    assert_eq!(stopped.builder.build().unwrap().info().unwrap(), space.info().unwrap());
    assert_eq!(
        panic_of::<Raised>(|| drop(bases(&ShapeSpaceOptions::new()).build_with(|_, _| raise("build")))),
        Raised("build")
    );

    let mut simulator = Simulator::new(&space, &settings()).unwrap();
    let stopped = simulator.set_weights_with(&[0.5, 0.5], |_, _| ControlFlow::Break(())).unwrap_err();
    assert_eq!(stopped.status(), Status::Cancelled);
    let panic = panic_of::<Raised>(|| drop(simulator.set_weights_with(&[0.5, 0.5], |_, _| raise("weights"))));
    assert_eq!(panic, Raised("weights"));
    assert!(!simulator.info().unwrap().has_design);
    simulator.set_weights(&[0.5, 0.5]).unwrap();

    let (sine, mut tape) = (sine(), Tape::new(&simulator).unwrap());
    let after = |steps: usize| {
        move |done: usize, _: usize| {
            if done >= steps {
                raise("rollout")
            }
        }
    };
    let panic = panic_of::<Raised>(|| drop(simulator.rollout_with(&sine, 10, Some(&mut tape), after(4))));
    assert_eq!(panic, Raised("rollout"));
    assert_eq!((tape.n_steps().unwrap(), simulator.info().unwrap().steps), (4, 4));
    let flow = |done, _| if done == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let stopped = simulator.rollout_with(&sine, 10, Some(&mut tape), flow).unwrap_err();
    assert_eq!((stopped.status(), tape.n_steps().unwrap()), (Status::Cancelled, 6));
    simulator.rollout(&sine, 4, Some(&mut tape)).unwrap();

    let expected = tape.gradient(&travel(), [Wrt::Weights, Wrt::Control]).unwrap();
    let mut adjoint = Adjoint::new(&tape).unwrap();
    adjoint.seed_objective(&travel()).unwrap();
    assert_eq!(panic_of::<Raised>(|| drop(adjoint.backward_with(0, |_, _| raise("sweep")))), Raised("sweep"));
    adjoint.backward_with(5, |_, _| ControlFlow::Continue(())).unwrap();
    adjoint.backward(0).unwrap(); // it went on, to the same bits
    assert_eq!([adjoint.gradient(Wrt::Weights).unwrap(), adjoint.gradient(Wrt::Control).unwrap()], expected);
}

#[test]
fn control_closures_are_a_controller() {
    let mut simulator = swimmer(&settings());
    let mut sine = Controller::sinusoid(1, TIME_STEP).unwrap();
    sine.set_parameters(&[0.75, 12.0, 0.0]).unwrap();
    let options = CallbackOptions::new().n_signals(1).time_step(TIME_STEP);
    let own = Controller::callback_with_pullback(&options, &[0.75, 12.0], evaluate, pullback).unwrap();
    let info = own.info().unwrap();
    assert_eq!((info.kind, info.n_parameters, info.has_pullback), (ControllerKind::Callback, 2, true));
    let run = |controller: &Controller, simulator: &mut Simulator| {
        simulator.set_state(None, None).unwrap();
        let mut tape = Tape::new(simulator).unwrap();
        simulator.rollout(controller, 12, Some(&mut tape)).unwrap();
        tape.gradient(&travel(), [Wrt::Weights, Wrt::Control]).unwrap()
    };
    let (theirs, ours) = (run(&sine, &mut simulator), run(&own, &mut simulator));
    for (a, b) in theirs[0].iter().zip(&ours[0]).chain(theirs[1].iter().zip(&ours[1])) {
        assert!((a - b).abs() <= 1e-12 * a.abs(), "{theirs:?} {ours:?}");
    }
    let report = GradientCheckOptions::new().with_respect_to(Wrt::Control).n_steps(6);
    let report = simulator.check_gradient(Some(&own), &travel(), &report).unwrap();
    assert!(report.relative_error < 1e-6 && (report.taylor_slope - 2.0).abs() < 0.1, "{report:?}");

    // What it says is checked by the library, and a loop that is closed without a derivative has no adjoint.
    let wild = Controller::callback(&options, &[], |_, actuation| actuation[0] = 2.0).unwrap();
    assert_eq!(simulator.rollout(&wild, 1, None).unwrap_err().status(), Status::Argument);
    let reader = |input: ControlInput<'_>, actuation: &mut [f64]| actuation[0] = input.sensors[0].tanh();
    let closed = Controller::callback(&options.clone().n_sensors(10), &[], reader).unwrap();
    let mut tape = Tape::new(&simulator).unwrap();
    simulator.rollout(&closed, 3, Some(&mut tape)).unwrap();
    assert_eq!(Adjoint::new(&tape).unwrap_err().status(), Status::State);
    assert_eq!(own.save(std::env::temp_dir().join("diffaqua-none")).unwrap_err().status(), Status::Unsupported);
}

#[test]
fn control_closures_stop_and_panic() {
    let mut simulator = swimmer(&settings());
    let options = CallbackOptions::new();
    let stop = |input: ControlInput<'_>, actuation: &mut [f64]| {
        actuation[0] = 0.5;
        if input.step == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let stop = Controller::callback(&options, &[], stop).unwrap();
    let mut tape = Tape::new(&simulator).unwrap();
    let error = simulator.rollout(&stop, 5, Some(&mut tape)).unwrap_err();
    assert_eq!((error.status(), tape.n_steps().unwrap()), (Status::Cancelled, 2));

    let bad = Controller::callback(&options, &[], |_, _| raise("evaluate")).unwrap();
    assert_eq!(panic_of::<Raised>(|| drop(simulator.rollout(&bad, 5, None))), Raised("evaluate"));
    assert_eq!(panic_of::<Raised>(|| drop(bad.evaluate(0, &[]))), Raised("evaluate"));

    let back = |_: ControlInput<'_>, _: &[f64], _: &mut [f64], _: &mut [f64]| raise("pullback");
    let bad = Controller::callback_with_pullback(&options, &[0.5, 12.0], evaluate, back).unwrap();
    let mut tape = Tape::new(&simulator).unwrap();
    simulator.rollout(&bad, 3, Some(&mut tape)).unwrap();
    assert_eq!(panic_of::<Raised>(|| drop(tape.gradient(&travel(), [Wrt::Control]))), Raised("pullback"));

    // A panic that a closure's own call of the library let through, two levels down.
    let inner = Mutex::new(Controller::callback(&options, &[], |_, _| raise("deep")).unwrap());
    let outer = move |_: ControlInput<'_>, actuation: &mut [f64]| {
        actuation.copy_from_slice(&inner.lock().unwrap().evaluate(0, &[]).unwrap());
    };
    let outer = Controller::callback(&options, &[], outer).unwrap();
    assert_eq!(panic_of::<Raised>(|| drop(simulator.rollout(&outer, 1, None))), Raised("deep"));
    simulator.step(&[0.5], None).unwrap();
}

#[test]
fn currents_are_asked_and_told() {
    let mut simulator = swimmer(&settings());
    let drift = |time: f64, current: &mut [f64]| {
        assert_eq!(current, [0.0, 0.0]);
        current[0] = -0.25 * time;
    };
    let sum = Arc::new(Mutex::new(0.0));
    let kept = Arc::clone(&sum);
    let back = move |time: f64, bar: &[f64]| *kept.lock().unwrap() += -time * bar[0];
    simulator.set_current_with_pullback(drift, back).unwrap();
    let (sine, mut tape) = (sine(), Tape::new(&simulator).unwrap());
    simulator.rollout(&sine, 8, Some(&mut tape)).unwrap();
    assert_eq!(tape.current(4).unwrap(), [-0.25 * 4.0 * TIME_STEP, 0.0]);
    let [by_current] = tape.gradient(&travel(), [Wrt::Current]).unwrap();
    let expected: f64 = (0..8).map(|i| -(i as f64) * TIME_STEP * by_current[2 * i]).sum();
    assert!((*sum.lock().unwrap() - expected).abs() <= 1e-14 * expected.abs() && expected != 0.0);

    simulator.set_current(|_, _| raise("current")).unwrap();
    assert_eq!(panic_of::<Raised>(|| drop(simulator.step(&[0.0], None))), Raised("current"));
    simulator.set_current(|_, _| ControlFlow::Break(())).unwrap();
    assert_eq!(simulator.step(&[0.0], None).unwrap_err().status(), Status::Cancelled);
    simulator.set_current_with_pullback(|_, _| (), |_, _| raise("told")).unwrap();
    simulator.set_state(None, None).unwrap();
    tape.clear().unwrap();
    simulator.step(&[0.5], Some(&mut tape)).unwrap();
    assert_eq!(panic_of::<Raised>(|| drop(tape.gradient(&travel(), [Wrt::Weights]))), Raised("told"));
    simulator.reset_current().unwrap();
    simulator.step(&[0.5], None).unwrap();
}

#[test]
fn closures_live_as_long_as_their_tapes() {
    struct Alive(Arc<AtomicUsize>);
    impl Alive {
        fn new(count: &Arc<AtomicUsize>) -> Self {
            count.fetch_add(1, Ordering::SeqCst);
            Alive(Arc::clone(count))
        }
        fn look(&self) {
            assert!(self.0.load(Ordering::SeqCst) > 0);
        }
    }
    impl Drop for Alive {
        fn drop(&mut self) {
            self.0.fetch_sub(1, Ordering::SeqCst);
        }
    }
    let (of_current, of_control) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicUsize::new(0)));
    let alive = || (of_current.load(Ordering::SeqCst), of_control.load(Ordering::SeqCst));
    let mut simulator = swimmer(&settings());
    let (a, b) = (Alive::new(&of_current), Alive::new(&of_current));
    simulator.set_current_with_pullback(move |_, _| a.look(), move |_, _| b.look()).unwrap();
    let (c, d) = (Alive::new(&of_control), Alive::new(&of_control));
    let ask = move |input: ControlInput<'_>, actuation: &mut [f64]| {
        c.look();
        evaluate(input, actuation);
    };
    let back = move |input: ControlInput<'_>, bar: &[f64], theta_bar: &mut [f64], sensors_bar: &mut [f64]| {
        d.look();
        pullback(input, bar, theta_bar, sensors_bar);
    };
    let options = CallbackOptions::new().time_step(TIME_STEP);
    let own = Controller::callback_with_pullback(&options, &[0.75, 12.0], ask, back).unwrap();
    let mut tape = Tape::new(&simulator).unwrap();
    simulator.rollout(&own, 4, Some(&mut tape)).unwrap();
    let expected = tape.gradient(&travel(), [Wrt::Weights, Wrt::Control]).unwrap();
    drop(own);
    simulator.reset_current().unwrap();
    drop(simulator);
    assert_eq!(alive(), (2, 2));
    assert_eq!(tape.gradient(&travel(), [Wrt::Weights, Wrt::Control]).unwrap(), expected);
    tape.clear().unwrap();
    assert_eq!(alive(), (0, 0));
}
