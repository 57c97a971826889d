// SPDX-License-Identifier: MIT
//! Objects: what they tell and refuse, what they save, that they go in any order and between threads.
mod scene;

use std::thread;

use diffaqua::*;
use scene::*;

fn refused<T: std::fmt::Debug>(result: Result<T>, status: Status, said: &str) {
    let error = result.unwrap_err();
    assert_eq!(error.status(), status, "{error}");
    assert!(error.message().contains(said), "{error}");
}

#[test]
fn library_tells_its_version() {
    assert_eq!(abi_version(), sys::DQA_ABI_VERSION);
    let header = [sys::DQA_VERSION_MAJOR, sys::DQA_VERSION_MINOR, sys::DQA_VERSION_PATCH].map(|n| n.to_string());
    assert_eq!(version(), header.join("."));
    assert_eq!(version(), env!("CARGO_PKG_VERSION"));
    assert!(features().split(' ').count() > 0);
    for code in -11..0 {
        let status = Status::from_code(code);
        assert!(status.code() == code && status.name().starts_with("DQA_") && !status.text().is_empty());
        assert!(!matches!(status, Status::Other(_)), "{code}");
    }
    assert_eq!((Status::from_code(-99), Status::Other(-99).name()), (Status::Other(-99), "unknown status"));
}

#[test]
fn wrong_arguments_are_refused() {
    let wide = ShapeSpaceOptions::new().cells_x(usize::MAX);
    refused(ShapeSpaceBuilder::new(&wide), Status::Argument, "cells_x");
    let mut open = bases(&ShapeSpaceOptions::new());
    refused(open.add_polygon("a\0b", &outline(0.1)), Status::Argument, "name");
    refused(open.add_polygon("empty", &[]), Status::Argument, "corners");
    refused(open.add_image("short", &[0.5; 7], 2, 4), Status::Argument, "pixels");
    refused(open.add_image("huge", &[0.5; 7], usize::MAX, 2), Status::Argument, "pixels");
    refused(open.add_mesh_file("no/such/file.stl"), Status::Io, "file.stl");
    refused(open.add_actuator(0, &ActuatorOptions::new()), Status::State, "cell_size");
    assert_eq!((open.info().unwrap().n_bases, open.base_name(1), open.base_name(7)), (2, "stout".into(), "".into()));

    let empty = ShapeSpaceBuilder::new(&ShapeSpaceOptions::new()).unwrap().build();
    let unbuilt = empty.unwrap_err();
    assert_eq!(unbuilt.to_string(), unbuilt.error.message());
    assert_eq!(Error::from(unbuilt).status(), Status::State);

    let space = space();
    refused(space.density(&[]), Status::Argument, "weights");
    refused(space.density_into(&[0.5, 0.5], &mut [0.0; 3]), Status::Argument, "density");
    refused(space.pullback(&[0.5, 0.5], &[1.0]), Status::Argument, "density_bar");
    refused(space.signal(1), Status::Argument, "signal");
    refused(space.base(usize::MAX), Status::Argument, "base");
    refused(Simulator::new(&space, &SimulatorOptions::new().time_step(0.0)), Status::Argument, "time_step");

    let mut simulator = Simulator::new(&space, &settings()).unwrap();
    refused(simulator.state(), Status::State, "");
    refused(simulator.set_material(Some(&[1.0]), None), Status::Argument, "young_modulus");
    refused(simulator.set_weights(&[1.0]), Status::Argument, "weights");
    simulator.set_weights(&[0.5, 0.5]).unwrap();
    refused(simulator.step(&[0.5, 0.5], None), Status::Argument, "actuation");
    refused(simulator.set_state(Some(&[0.0]), None), Status::Argument, "q");
    refused(simulator.set_current_table(&[0.0, 1.0], &[0.0; 3]), Status::Argument, "");
    refused(simulator.suggest_threshold(&[0.5, 0.5], 2.0), Status::Argument, "tolerance");
    refused(simulator.actuator(7, Side::Both), Status::State, "");

    let tape = Tape::new(&simulator).unwrap();
    refused(tape.state(0), Status::State, "");
    refused(tape.surface(0, usize::MAX), Status::Argument, "n_vertices");
    refused(Adjoint::new(&tape), Status::State, "");
    let mut other = Tape::new(&swimmer(&settings())).unwrap();
    refused(simulator.step(&[0.5], Some(&mut other)), Status::Argument, "tape");

    let deep = PerceptronOptions::new().hidden(&[4; 6]);
    refused(Controller::perceptron(&deep), Status::Argument, "n_hidden");
    let short = adam_step(&mut [0.0; 2], &[0.0; 2], &[0.1], &mut [0.0; 2], &mut [0.0; 2], 1);
    refused(short, Status::Argument, "rates");
    refused(project_simplex(&mut []), Status::Argument, "");
    refused(CmaEs::new(&CmaEsOptions::new(), &[0.0; 2], Some(&[1.0])), Status::Argument, "scales");
}

#[test]
fn options_reach_the_library() {
    let options = settings().water(Water::None).threads(2).planar(true).current([0.0; 3]);
    let raw = options.as_raw();
    assert_eq!((raw.water, raw.threads, raw.planar, raw.time_step), (sys::DQA_WATER_NONE, 2, 1, TIME_STEP));
    let wet = swimmer(&settings());
    assert!(wet.info().unwrap().n_faces > 0);
    let mut dry = swimmer(&settings().water(Water::None));
    dry.step(&[1.0], None).unwrap();
    assert_eq!(dry.forces().unwrap(), [0.0; 8]);
    let neurons = PerceptronOptions::new().dims(2).hidden(&[3, 2]).temporal_encoding(false);
    // Layers of 10 -> 3 -> 2 -> 1 with biases.
    assert_eq!(Controller::perceptron(&neurons).unwrap().n_parameters().unwrap(), 33 + 8 + 3);
}

#[test]
fn geometry_is_consistent() {
    let mut simulator = swimmer(&settings());
    let (info, mesh, muscles) = (simulator.info().unwrap(), simulator.mesh().unwrap(), simulator.muscles().unwrap());
    assert_eq!(simulator.weights().unwrap(), [0.5, 0.5]);
    assert_eq!(mesh.cell_nodes.len(), 4 * info.n_active_cells);
    assert!(mesh.cell_nodes.iter().all(|&node| (node as usize) < info.n_nodes));
    let volume: f64 = mesh.occupancy.iter().sum::<f64>() * info.cell_size.powi(3);
    assert!((volume - info.volume).abs() < 1e-12 * volume);
    assert!(!muscles.cells.is_empty() && muscles.signs.iter().all(|sign| sign.abs() == 1));
    assert_eq!(muscles.directions.len(), 2 * muscles.stiffness.len());
    let (actuator, surface) = (simulator.actuator(0, Side::Both).unwrap(), simulator.surface().unwrap());
    assert_eq!((actuator.kind, actuator.share), (ActuatorKind::Caudal, 1.0));
    assert_eq!((surface.vertices.len() / 2, surface.elements.len() / 2), simulator.surface_size().unwrap());

    let nodes = simulator.node_box_index().unwrap();
    simulator.set_fixed_nodes(&nodes[..4]).unwrap();
    simulator.step(&[1.0], None).unwrap();
    let before = simulator.state().unwrap();
    simulator.set_state(None, None).unwrap();
    let rest = simulator.state().unwrap();
    assert!(rest.q[..8] == before.q[..8] && rest.q != before.q);
    simulator.set_fixed_nodes(&[]).unwrap();
    simulator.set_material(Some(&[3e5; 20 * 8]), None).unwrap();
    let (threshold, estimate) = simulator.suggest_threshold(&[0.5, 0.5], 0.05).unwrap();
    assert!((0.0..0.5).contains(&threshold) && (0.0..=0.05).contains(&estimate));
}

#[test]
fn bases_and_actuators_are_given() {
    let box_of_cells = ShapeSpaceOptions::new().dims(2).cells_x(24).cells_y(12).sigma(0.75);
    let mut bases = ShapeSpaceBuilder::new(&box_of_cells.clone().cell_size(0.05)).unwrap();
    let pixels: Vec<f64> = (0..12 * 24).map(|i| if (36..252).contains(&i) && i % 24 > 2 { 1.0 } else { 0.0 }).collect();
    assert_eq!(bases.add_image("image", &pixels, 12, 24).unwrap(), 0);
    let cells: Vec<f64> = (0..24 * 12)
        .map(|i| if (4..20).contains(&(i / 12)) && (3..9).contains(&(i % 12)) { 1.0 } else { 0.0 })
        .collect();
    assert_eq!(bases.add_density("cells", &cells).unwrap(), 1);
    let tail = ActuatorOptions::new().mean([-0.2, 0.0, 0.0]).variance([0.02, 0.01, 0.01]);
    let fins = ActuatorOptions::new().category(1).kind(ActuatorKind::Fins).layers(1).mean([0.1, 0.1, 0.0]);
    for base in 0..2 {
        bases.add_actuator(base, &tail).unwrap();
        bases.add_actuator(base, &fins.clone().variance([0.01, 0.01, 0.005])).unwrap();
    }
    refused(bases.add_actuator(0, &tail), Status::State, "actuator");
    assert_eq!(bases.actuator(1, 0, Side::Both).unwrap().as_raw().mean, [-0.2, 0.0, 0.0]);
    let space = bases.build().unwrap();
    assert_eq!(space.info().unwrap().n_signals, 5);
    let (first, last) = (space.signal(0).unwrap(), space.signal(4).unwrap());
    assert_eq!((first.kind, first.category), (ActuatorKind::Caudal, 0));
    assert_eq!((last.kind, last.category, last.layer, last.group), (ActuatorKind::Fins, 1, 0, 3));
    let right = space.actuator(0, 1, Side::Right).unwrap();
    assert_eq!((right.as_raw().mean[1], right.as_raw().side), (-0.1, sys::DQA_SIDE_RIGHT));
    let mut simulator = Simulator::new(&space, &settings()).unwrap();
    simulator.set_weights(&[0.75, 0.25]).unwrap();
    simulator.step(&[0.5, -0.5, 0.25, 0.0, 1.0], None).unwrap();
    let state = simulator.state().unwrap();
    let backwards: Vec<f64> = state.v.iter().map(|v| -v).collect();
    simulator.set_state(Some(&state.q), Some(&backwards)).unwrap();
    assert_eq!(simulator.state().unwrap(), State { q: state.q, v: backwards });
    assert_eq!(simulator.actuator(1, Side::Left).unwrap().kind, ActuatorKind::Fins);
}

#[test]
fn a_call_that_records_nothing_changes_no_tape() {
    let (mut simulator, mut other) = (swimmer(&settings()), swimmer(&settings()));
    let (sine, perceptron) = (
        Controller::sinusoid(1, TIME_STEP).unwrap(),
        Controller::perceptron(&PerceptronOptions::new().dims(2)).unwrap(),
    );
    let mut tape = Tape::new(&simulator).unwrap();
    simulator.rollout(&sine, 3, Some(&mut tape)).unwrap();
    let expected = tape.gradient(&travel(), [Wrt::Control]).unwrap();
    refused(other.rollout(&perceptron, 3, Some(&mut tape)), Status::Argument, "tape");
    assert_eq!(tape.gradient(&travel(), [Wrt::Control]).unwrap(), expected);
}

#[test]
fn what_is_saved_comes_back() {
    let folder = Scratch::new("objects");
    let file = |name: &str| folder.0.join(name);
    let space = space();
    space.save(file("space.dqa")).unwrap();
    let loaded = ShapeSpace::load(file("space.dqa")).unwrap();
    assert_eq!(loaded.density(&[0.25, 0.75]).unwrap(), space.density(&[0.25, 0.75]).unwrap());
    assert_eq!((loaded.base_name(0), loaded.info().unwrap()), ("slim".into(), space.info().unwrap()));
    assert_eq!(loaded.base(1).unwrap(), space.base(1).unwrap());
    assert_eq!(loaded.signal(0).unwrap().kind, ActuatorKind::Caudal);
    let given = space.actuator(0, 0, Side::Both).unwrap();
    assert_eq!(given.as_raw().mean, loaded.actuator(0, 0, Side::Both).unwrap().as_raw().mean);

    let perceptron = Controller::perceptron(&PerceptronOptions::new().dims(2).seed(3)).unwrap();
    perceptron.save(file("controller.dqa")).unwrap();
    let loaded = Controller::load(file("controller.dqa")).unwrap();
    assert_eq!(loaded.evaluate(3, &[0.1; 10]).unwrap(), perceptron.evaluate(3, &[0.1; 10]).unwrap());
    refused(ShapeSpace::load(file("controller.dqa")), Status::File, "");

    let value = |x: &[f64]| (x[0] - 0.5).powi(2) + 10.0 * (x[1] + 1.0).powi(2);
    let mut search = CmaEs::new(&CmaEsOptions::new().seed(7), &[0.0; 2], Some(&[1.0, 0.5])).unwrap();
    refused(search.best(), Status::State, "");
    for _ in 0..60 {
        let values: Vec<f64> = search.ask().unwrap().chunks(2).map(value).collect();
        search.tell(&values).unwrap();
    }
    search.save(file("search.dqa")).unwrap();
    let mut loaded = CmaEs::load(file("search.dqa")).unwrap();
    assert_eq!(loaded.ask().unwrap(), search.ask().unwrap());
    let ((x, best), mean) = (search.best().unwrap(), search.mean().unwrap());
    assert!(best < 1e-8 && best == value(&x) && value(&mean) < 1e-8, "{best}");
    assert_eq!((search.info().unwrap().generation, search.info().unwrap().asked), (60, true));
}

#[test]
fn objects_go_in_any_order() {
    let space = space();
    let mut simulator = Simulator::new(&space, &settings()).unwrap();
    drop(space);
    simulator.set_weights(&[0.5, 0.5]).unwrap();
    let sine = Controller::sinusoid(1, TIME_STEP).unwrap();
    let mut tape = Tape::with_options(&simulator, &TapeOptions::new().memory_bytes(30_000)).unwrap();
    simulator.rollout(&sine, 20, Some(&mut tape)).unwrap();
    let (last, n_vertices) = (simulator.state().unwrap(), simulator.surface_size().unwrap().0);
    let surface = simulator.surface().unwrap().vertices;
    simulator.set_weights(&[0.25, 0.75]).unwrap(); // another design: the tape keeps its own
    drop((simulator, sine));
    assert_eq!(tape.state(20).unwrap(), last);
    assert_eq!(tape.surface(20, n_vertices).unwrap(), surface);
    assert_eq!(tape.actuation(0).unwrap(), [0.0]);
    let [actuation, water] = tape.gradient(&travel(), [Wrt::Actuation, Wrt::Water]).unwrap();
    assert_eq!((actuation.len(), water.len()), (20, 11));
    let told = tape.statistics().unwrap();
    assert!(told.steps == 20 && told.checkpoints < 21 && told.recomputed_steps > 0, "{told:?}");
}

#[test]
fn losses_of_the_callers_own() {
    // The sum of velocities along x after the last step, seeded by hand; and a path as term.
    let mut simulator = swimmer(&settings());
    let sine = Controller::sinusoid(1, TIME_STEP).unwrap();
    let mut tape = Tape::new(&simulator).unwrap();
    simulator.set_current_table(&[0.0, 0.25], &[0.0, 0.0, -0.125, 0.0]).unwrap();
    simulator.rollout(&sine, 6, Some(&mut tape)).unwrap();
    let n = simulator.info().unwrap().n_nodes;
    let bar: Vec<f64> = (0..2 * n).map(|i| if i % 2 == 0 { 1.0 } else { 0.0 }).collect();
    let mut adjoint = Adjoint::new(&tape).unwrap();
    adjoint.seed(6, Seed::Velocity, &bar).unwrap();
    adjoint.backward(3).unwrap();
    refused(adjoint.seed(5, Seed::Velocity, &bar), Status::State, "");
    refused(adjoint.gradient(Wrt::Weights), Status::State, "");
    adjoint.backward(0).unwrap();
    let by_table = adjoint.gradient(Wrt::CurrentTable).unwrap();
    assert_eq!(by_table.len(), 4);
    let loss = |row: f64, simulator: &mut Simulator| {
        simulator.set_state(None, None).unwrap();
        simulator.set_current_table(&[0.0, 0.25], &[0.0, 0.0, row, 0.0]).unwrap();
        simulator.rollout(&sine, 6, None).unwrap();
        simulator.state().unwrap().v.iter().step_by(2).sum::<f64>()
    };
    let e = 1e-3;
    let five = [-2.0, -1.0, 1.0, 2.0].map(|k| loss(-0.125 + k * e, &mut simulator));
    let difference = (five[0] - 8.0 * five[1] + 8.0 * five[2] - five[3]) / (12.0 * e);
    assert!((by_table[2] - difference).abs() < 1e-6 * difference.abs(), "{} {difference}", by_table[2]);

    let path = ObjectiveTerm::new(Objective::Path).path(&[0.0, 0.0, 0.0, 1.0, 0.5, 0.0]).weight(2.0);
    let terms = [path, ObjectiveTerm::new(Objective::Effort)];
    let (total, each) = tape.objective(&terms).unwrap();
    assert!((total - 2.0 * each[0] - each[1]).abs() < 1e-14 && each[0] > 0.0);
    refused(tape.objective(&[]), Status::Argument, "terms");
    let by_control = tape.gradient(&terms, [Wrt::Control]).unwrap();
    assert_eq!(by_control[0].len(), 3);
}

#[test]
fn every_gradient_has_its_shape() {
    let mut simulator = swimmer(&settings());
    let mut tape = Tape::new(&simulator).unwrap();
    simulator.rollout(&Controller::sinusoid(1, TIME_STEP).unwrap(), 4, Some(&mut tape)).unwrap();
    let (n, dims, cells) = (simulator.info().unwrap().n_nodes, 2, 20 * 8);
    let shapes = [
        (Wrt::Weights, 2),
        (Wrt::Control, 3),
        (Wrt::Actuation, 4),
        (Wrt::InitialPosition, n * dims),
        (Wrt::InitialVelocity, n * dims),
        (Wrt::Water, dims + 9),
        (Wrt::Current, 4 * dims),
        (Wrt::CurrentTable, dims),
        (Wrt::YoungsModulus, cells),
        (Wrt::MuscleStiffness, cells),
        (Wrt::Material, 4),
        (Wrt::Lame, 2),
    ];
    let gradients = tape.gradient(&travel(), shapes.map(|shape| shape.0)).unwrap();
    for (gradient, (wrt, length)) in gradients.iter().zip(shapes) {
        assert!(gradient.len() == length && gradient.iter().any(|&g| g != 0.0), "{wrt:?}");
    }
    // Steps without a controller have no gradient by its parameters.
    tape.clear().unwrap();
    simulator.step(&[0.5], Some(&mut tape)).unwrap();
    refused(tape.gradient(&travel(), [Wrt::Control]), Status::State, "controller");
    assert_eq!(tape.gradient(&travel(), [Wrt::Actuation]).unwrap()[0].len(), 1);
}

#[test]
fn objects_move_and_are_shared() {
    fn send<T: Send>() {}
    fn share<T: Send + Sync>() {}
    send::<(ShapeSpaceBuilder, Simulator, Controller, CmaEs, Adjoint<'_>)>();
    share::<(ShapeSpace, Tape, CancelToken, SimulatorOptions, ObjectiveTerm, Error)>();

    let space = space();
    let expected = space.density(&[0.5, 0.5]).unwrap();
    let mut simulator = Simulator::new(&space, &settings()).unwrap();
    let mut tape = thread::scope(|scope| {
        let readers: Vec<_> = (0..2).map(|_| scope.spawn(|| space.density(&[0.5, 0.5]).unwrap())).collect();
        let tape = scope.spawn(|| {
            simulator.set_weights(&[0.5, 0.5]).unwrap();
            let budget = TapeOptions::new().memory_bytes(30_000); // both sweeps compute states again
            let mut tape = Tape::with_options(&simulator, &budget).unwrap();
            simulator.rollout(&Controller::sinusoid(1, TIME_STEP).unwrap(), 20, Some(&mut tape)).unwrap();
            assert!(tape.statistics().unwrap().checkpoints < 21);
            tape
        });
        assert!(readers.into_iter().all(|reader| reader.join().unwrap() == expected));
        tape.join().unwrap()
    });
    let gradients = thread::scope(|scope| {
        let sweeps = [0, 1].map(|_| scope.spawn(|| tape.gradient(&travel(), [Wrt::Weights, Wrt::Control]).unwrap()));
        sweeps.map(|sweep| sweep.join().unwrap())
    });
    assert_eq!(gradients[0], gradients[1]);
    tape.clear().unwrap();
}

#[test]
fn tokens_cancel() {
    let token = CancelToken::new().unwrap();
    let builder = bases(&ShapeSpaceOptions::new().cancel(&token));
    token.set();
    let unbuilt = builder.build().unwrap_err();
    assert_eq!(unbuilt.error.status(), Status::Cancelled);
    token.reset();
    let space = unbuilt.builder.build().unwrap();
    let mut simulator = Simulator::new(&space, &settings().cancel(&token)).unwrap();
    simulator.set_weights(&[0.5, 0.5]).unwrap();
    let sine = Controller::sinusoid(1, TIME_STEP).unwrap();
    let other = token.clone();
    drop(token);
    let stop = thread::spawn({
        let token = other.clone();
        move || token.set()
    });
    let error = (0..10_000).find_map(|_| simulator.rollout(&sine, 10, None).err()).expect("a stop");
    stop.join().unwrap();
    assert_eq!(error.status(), Status::Cancelled);
    other.reset();
    simulator.rollout(&sine, 2, None).unwrap();
}
