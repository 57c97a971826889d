// SPDX-License-Identifier: MIT
//! A plane scene so small that a rollout takes milliseconds.
#![allow(dead_code)] // every test uses some of it
use std::{f64::consts::PI, path::PathBuf};

use diffaqua::*;

pub const TIME_STEP: f64 = 0.03125;

/// A fish from above.
pub fn outline(width: f64) -> Vec<[f64; 2]> {
    let half = (0..32).map(|i| {
        let s = (f64::from(i) + 0.5) / 32.0;
        [0.5 - s, 0.02 + width * (PI * s.powf(0.75)).sin() + (0.25 * (s - 0.75)).max(0.0)]
    });
    half.clone().chain(half.rev().map(|[x, y]| [x, -y])).collect()
}

pub fn bases(options: &ShapeSpaceOptions) -> ShapeSpaceBuilder {
    let mut bases = ShapeSpaceBuilder::new(&options.clone().dims(2).cells_x(20).cells_y(8).sigma(0.75)).unwrap();
    assert_eq!(bases.add_polygon("slim", &outline(0.0625)).unwrap(), 0);
    assert_eq!(bases.add_polygon("stout", &outline(0.125)).unwrap(), 1);
    bases
}

pub fn space() -> ShapeSpace {
    bases(&ShapeSpaceOptions::new()).build().unwrap()
}

/// Tight solves: finite differences see their noise.
pub fn settings() -> SimulatorOptions {
    let soft = SimulatorOptions::new().time_step(TIME_STEP).young_modulus(2e5).muscle_stiffness(1e6);
    soft.tolerance(1e-12).adjoint_tolerance(1e-12)
}

pub fn swimmer(options: &SimulatorOptions) -> Simulator {
    let mut simulator = Simulator::new(&space(), options).unwrap();
    simulator.set_weights(&[0.5, 0.5]).unwrap();
    simulator
}

pub fn travel() -> [ObjectiveTerm; 1] {
    [ObjectiveTerm::new(Objective::Travel)]
}

/// A folder of the test's own, gone with it.
pub struct Scratch(pub PathBuf);

impl Scratch {
    pub fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("diffaqua-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Scratch(path)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
