// SPDX-License-Identifier: MIT
//! The test vectors of `tests/bindings/vectors`: to the last bit of what the C program wrote in this run (DQA_VECTORS),
//! and to 1e-12 of the committed ones.
use std::{env, fs};

use diffaqua::*;
use serde_json::Value;

/// Largest difference relative to the largest number of an array: 0 is "to the last bit".
struct Vectors {
    root: Value,
    tolerance: f64,
}

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(values) => values.iter().map(|number| number.as_f64().unwrap()).collect(),
        number => vec![number.as_f64().unwrap()],
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn whole(value: &Value) -> usize {
    assert_eq!(number(value).fract(), 0.0);
    number(value) as usize
}

impl Vectors {
    fn same(&self, found: &[f64], entry: &Value, name: &str) {
        let expected = numbers(&entry[name]);
        assert_eq!(found.len(), expected.len(), "{name}");
        let scale = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (i, (f, e)) in found.iter().zip(&expected).enumerate() {
            let good = if self.tolerance == 0.0 { f == e } else { (f - e).abs() <= self.tolerance * scale };
            assert!(good, "{name}[{i}]: {f:e}, expected {e:e}");
        }
    }
}

/// Sets options by their names in the file.
macro_rules! set {
    ($options:expr, $entry:expr, { $($field:ident: $convert:expr),* $(,)? }) => {{
        let mut options = $options;
        for (name, value) in $entry["options"].as_object().unwrap() {
            options = match name.as_str() {
                $(stringify!($field) => options.$field($convert(value)),)*
                other => panic!("unknown option {other}"),
            };
        }
        options
    }};
}

fn space(entry: &Value) -> ShapeSpace {
    let options = set!(ShapeSpaceOptions::new(), entry, {
        dims: whole, cells_x: whole, cells_y: whole, cells_z: whole, sigma: number, tolerance: number,
    });
    let mut bases = ShapeSpaceBuilder::new(&options).unwrap();
    for base in entry["polygons"].as_array().into_iter().flatten() {
        let corners: Vec<[f64; 2]> = numbers(&base["corners"]).chunks(2).map(|c| [c[0], c[1]]).collect();
        bases.add_polygon(base["name"].as_str().unwrap(), &corners).unwrap();
    }
    for base in entry["meshes"].as_array().into_iter().flatten() {
        let vertices: Vec<[f64; 3]> = numbers(&base["vertices"]).chunks(3).map(|c| [c[0], c[1], c[2]]).collect();
        let triangles: Vec<[i32; 3]> =
            numbers(&base["triangles"]).chunks(3).map(|c| [c[0] as i32, c[1] as i32, c[2] as i32]).collect();
        bases.add_mesh(base["name"].as_str().unwrap(), &vertices, &triangles).unwrap();
    }
    bases.build().unwrap()
}

fn settings(entry: &Value) -> SimulatorOptions {
    let instructions = |value: &Value| [InstructionSet::Automatic, InstructionSet::Baseline][whole(value)];
    let material = |value: &Value| [Material::Corotated, Material::CorotatedVolume, Material::NeoHookean][whole(value)];
    set!(SimulatorOptions::new(), entry, {
        instruction_set: instructions, material: material, time_step: number, young_modulus: number,
        poisson_ratio: number, muscle_stiffness: number, tolerance: number, adjoint_tolerance: number,
        linear_precision: |value| [Precision::Single, Precision::Double][whole(value)],
    })
}

fn controller(described: &Value, time_step: f64, vectors: &Vectors) -> Controller {
    if described["kind"] == "sinusoid" {
        let mut sine = Controller::sinusoid(1, time_step).unwrap();
        sine.set_parameters(&numbers(&described["theta"])).unwrap();
        return sine;
    }
    let mut described = described.clone();
    let layers = described["options"].as_object_mut().unwrap().remove("n_hidden"); // `hidden` says it
    assert_eq!(layers.as_ref().map(whole), Some(1));
    let options = set!(PerceptronOptions::new(), described, {
        n_signals: whole, dims: whole, seed: |value| whole(value) as u64, scale: number,
        hidden: |value| Vec::leak(vec![whole(value)]) as &[usize],
    });
    let perceptron = Controller::perceptron(&options).unwrap();
    vectors.same(&perceptron.parameters().unwrap(), &described, "theta");
    perceptron
}

fn helpers(vectors: &Vectors) {
    let entry = &vectors.root["project_simplex"];
    let mut x = numbers(&entry["x"]);
    project_simplex(&mut x).unwrap();
    vectors.same(&x, entry, "result");
    let entry = &vectors.root["adam_step"];
    let read = |name: &str| numbers(&entry[name]);
    let (mut x, mut first, mut second) = (read("x"), read("first_moment"), read("second_moment"));
    let iteration = whole(&entry["iteration"]);
    adam_step(&mut x, &read("gradient"), &read("rates"), &mut first, &mut second, iteration).unwrap();
    vectors.same(&x, entry, "x_after");
    vectors.same(&first, entry, "first_moment_after");
    vectors.same(&second, entry, "second_moment_after");
}

fn rollout(vectors: &Vectors, entry: &Value, spaces: &[ShapeSpace]) {
    let mut simulator = Simulator::new(&spaces[whole(&entry["space"])], &settings(entry)).unwrap();
    simulator.set_weights(&numbers(&entry["weights"])).unwrap();
    let controller = controller(&entry["controller"], number(&entry["options"]["time_step"]), vectors);
    let term = |term: &Value| {
        let kind = [Objective::Travel, Objective::Effort][usize::from(whole(&term["kind"]) == 3)];
        ObjectiveTerm::new(kind).weight(number(&term["weight"]))
    };
    let terms: Vec<ObjectiveTerm> = entry["terms"].as_array().unwrap().iter().map(term).collect();
    let mut tape = Tape::new(&simulator).unwrap();
    simulator.rollout(&controller, whole(&entry["n_steps"]), Some(&mut tape)).unwrap();
    let (loss, per_term) = tape.objective(&terms).unwrap();
    let state = simulator.state().unwrap();
    vectors.same(&[loss], entry, "loss");
    vectors.same(&per_term, entry, "per_term");
    vectors.same(&state.q, entry, "q");
    vectors.same(&state.v, entry, "v");
    vectors.same(&simulator.sensors().unwrap(), entry, "sensors");
    vectors.same(&simulator.forces().unwrap(), entry, "forces");
    let names = ["weights", "control", "actuation", "initial_position", "material"];
    let wrt = [Wrt::Weights, Wrt::Control, Wrt::Actuation, Wrt::InitialPosition, Wrt::Material];
    for (name, gradient) in names.iter().zip(tape.gradient(&terms, wrt).unwrap()) {
        vectors.same(&gradient, entry, &format!("gradient_{name}"));
    }
}

fn optimisation(vectors: &Vectors, spaces: &[ShapeSpace]) {
    let entry = &vectors.root["optimisation"];
    let mut simulator = Simulator::new(&spaces[whole(&entry["space"])], &settings(entry)).unwrap();
    let mut sine = Controller::sinusoid(1, number(&entry["options"]["time_step"])).unwrap();
    let mut tape = Tape::new(&simulator).unwrap();
    let (travel, n) = ([ObjectiveTerm::new(Objective::Travel)], whole(&entry["n_bases"]));
    let (mut x, rates) = (numbers(&entry["x"]), numbers(&entry["rates"]));
    let (mut first, mut second) = (vec![0.0; x.len()], vec![0.0; x.len()]);
    let (mut losses, mut points) = (Vec::new(), Vec::new());
    for iteration in 1..=whole(&entry["iterations"]) {
        tape.clear().unwrap();
        simulator.set_weights(&x[..n]).unwrap();
        sine.set_parameters(&x[n..]).unwrap();
        simulator.rollout(&sine, whole(&entry["n_steps"]), Some(&mut tape)).unwrap();
        losses.push(tape.objective(&travel).unwrap().0);
        let gradient = tape.gradient(&travel, [Wrt::Weights, Wrt::Control]).unwrap().concat();
        adam_step(&mut x, &gradient, &rates, &mut first, &mut second, iteration).unwrap();
        project_simplex(&mut x[..n]).unwrap();
        x[n] = x[n].clamp(0.0, 1.0);
        points.extend_from_slice(&x);
    }
    vectors.same(&losses, entry, "losses");
    vectors.same(&points, entry, "x_after");
    assert!(losses[losses.len() - 1] < 2.0 * losses[0]);
}

fn errors(vectors: &Vectors, spaces: &[ShapeSpace]) {
    let options = settings(&vectors.root["optimisation"]);
    let mut simulator = Simulator::new(&spaces[0], &options).unwrap();
    for entry in vectors.root["errors"].as_array().unwrap() {
        let argument = numbers(&entry["argument"]);
        let error = if entry["call"] == "step" {
            simulator.set_weights(&[0.5, 0.5]).unwrap();
            simulator.step(&argument, None).unwrap_err()
        } else {
            simulator.set_weights(&argument).unwrap_err()
        };
        assert_eq!(f64::from(error.status().code()), number(&entry["status"]));
        assert_eq!(error.status().name(), entry["name"].as_str().unwrap());
        assert_eq!(error.message(), entry["message"].as_str().unwrap());
    }
}

fn all(vectors: &Vectors) {
    helpers(vectors);
    let entries = vectors.root["spaces"].as_array().unwrap();
    let spaces: Vec<ShapeSpace> = entries.iter().map(space).collect();
    for (space, entry) in spaces.iter().zip(entries) {
        let weights = numbers(&entry["weights"]);
        vectors.same(&space.density(&weights).unwrap(), entry, "density");
        vectors.same(&space.pullback(&weights, &numbers(&entry["density_bar"])).unwrap(), entry, "weights_bar");
    }
    for entry in vectors.root["rollouts"].as_array().unwrap() {
        rollout(vectors, entry, &spaces);
    }
    optimisation(vectors, &spaces);
    errors(vectors, &spaces);
}

fn read(path: &str, tolerance: f64) -> Vectors {
    Vectors { root: serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap(), tolerance }
}

#[test]
fn of_this_run_to_the_last_bit() {
    match env::var("DQA_VECTORS") {
        Ok(path) => all(&read(&path, 0.0)),
        Err(_) => eprintln!("skipped: DQA_VECTORS does not name what write_vectors wrote"),
    }
}

#[test]
fn committed_to_rounding() {
    let mut vectors = read(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../tests/bindings/vectors/vectors.json"), 1e-12);
    all(&vectors);
    // The comparison must be able to fail.
    vectors.root["project_simplex"]["result"][0] =
        Value::from(number(&vectors.root["project_simplex"]["result"][0]) + 1e-9);
    assert!(std::panic::catch_unwind(|| helpers(&vectors)).is_err());
}
