// SPDX-License-Identifier: MIT
//! swim — a swimmer between two meshes, and the sine that bends it, optimised together for the distance travelled.
//!
//!   swim [ITERATIONS [MESH MESH]]     default 10, with examples/shapes/tuna.stl and eel_vertical.stl
//!
//! Meshes become a shape space; each iteration makes a design from weights on the simplex, records a rollout, sweeps
//! back through it, and steps weights and sine by Adam. A terminal sees the progress of the slow calls.
use std::{
    env,
    io::{self, IsTerminal, Write},
    process::ExitCode,
};

use diffaqua::*;

const STEPS: usize = 20;

fn progress(what: &'static str) -> impl FnMut(usize, usize) {
    let mut screen = io::stderr();
    move |done, total| {
        if screen.is_terminal() {
            let _ = write!(screen, "\r{what} {:3} %\r", 100 * done / total.max(1));
            let _ = screen.flush();
        }
    }
}

fn swim(iterations: usize, meshes: &[String]) -> Result<()> {
    let options = ShapeSpaceOptions::new().cells_x(32).cells_y(10).cells_z(14).sigma(0.7);
    let mut bases = ShapeSpaceBuilder::new(&options)?;
    for mesh in meshes {
        bases.add_mesh_file(mesh)?;
    }
    let space = bases.build_with(progress("shapes"))?;
    let n_bases = space.info()?.n_bases;

    let settings = SimulatorOptions::new().young_modulus(1e6);
    let time_step = settings.as_raw().time_step;
    let mut simulator = Simulator::new(&space, &settings)?;
    let mut sine = Controller::sinusoid(space.info()?.n_signals, time_step)?;
    let mut tape = Tape::new(&simulator)?;
    let travel = [ObjectiveTerm::new(Objective::Travel)];

    // x: weights of the bases, then amplitude, frequency and phase of the sine.
    let mut x = vec![1.0 / n_bases as f64; n_bases];
    x.extend([0.8, 15.0, 0.0]);
    let mut rates = vec![0.05; n_bases];
    rates.extend([0.05, 0.5, 0.1]);
    let (mut first, mut second) = (vec![0.0; x.len()], vec![0.0; x.len()]);
    for iteration in 1..=iterations {
        let (weights, theta) = x.split_at_mut(n_bases);
        simulator.set_weights_with(weights, progress("design"))?;
        sine.set_parameters(theta)?;
        tape.clear()?;
        simulator.rollout_with(&sine, STEPS, Some(&mut tape), progress("rollout"))?;
        let (loss, _) = tape.objective(&travel)?;
        let shares: Vec<String> = weights.iter().map(|share| format!("{:.0} %", 100.0 * share)).collect();
        println!(
            "{iteration:3}: travels {:7.3} mm with {}, amplitude {:.2}, {:.1} rad/s",
            -1e3 * loss,
            shares.join(", "),
            theta[0],
            theta[1]
        );

        let gradient = tape.gradient(&travel, [Wrt::Weights, Wrt::Control])?.concat();
        adam_step(&mut x, &gradient, &rates, &mut first, &mut second, iteration)?;
        let (weights, theta) = x.split_at_mut(n_bases);
        project_simplex(weights)?;
        theta[0] = theta[0].clamp(0.0, 1.0);
    }
    Ok(())
}

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let shapes = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../examples/shapes/");
    let (iterations, meshes) = match &arguments[..] {
        [] => (Ok(10), ["tuna", "eel_vertical"].map(|name| format!("{shapes}{name}.stl"))),
        [n] => (n.parse(), ["tuna", "eel_vertical"].map(|name| format!("{shapes}{name}.stl"))),
        [n, one, other] => (n.parse(), [one.clone(), other.clone()]),
        _ => ("".parse::<usize>(), Default::default()),
    };
    let Ok(iterations) = iterations else {
        eprintln!("usage: swim [ITERATIONS [MESH MESH]]");
        return ExitCode::from(2);
    };
    match swim(iterations, &meshes) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("swim: {}: {error}", error.status());
            ExitCode::FAILURE
        }
    }
}
