// SPDX-License-Identifier: MIT
//! The example runs, finds faster swimmers, and says so.
use std::{env, process::Command};

#[test]
fn swim_gets_faster() {
    // Test programs lie in deps/, examples beside that folder.
    let example = env::current_exe().unwrap().parent().unwrap().with_file_name("examples").join("swim");
    assert!(example.is_file(), "{} is not built: run `cargo test` for all targets", example.display());
    let shapes = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../examples/shapes");
    let run = |arguments: &[&str]| Command::new(&example).args(arguments).output().unwrap();
    let done = run(&["2", &format!("{shapes}/tuna.stl"), &format!("{shapes}/eel_vertical.stl")]);
    let (out, err) = (String::from_utf8_lossy(&done.stdout), String::from_utf8_lossy(&done.stderr));
    assert!(done.status.success(), "{out}{err}");
    let travels: Vec<f64> =
        out.lines().filter_map(|line| line.split_once("travels ")?.1.split_whitespace().next()?.parse().ok()).collect();
    assert_eq!(travels.len(), 2, "{out}");
    assert!(travels[1] > travels[0], "{out}");

    let failed = run(&["2", "no_such_file.stl", "neither.stl"]);
    assert_eq!(failed.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&failed.stderr).contains("no_such_file.stl"));
    assert_eq!(run(&["many"]).status.code(), Some(2));
}
