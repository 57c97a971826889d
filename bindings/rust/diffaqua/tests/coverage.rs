// SPDX-License-Identifier: MIT
//! The safe crate reaches all of the C interface: every function, constant and field of `bindings/diffaqua.cdef` is
//! used by it, or listed here with a reason.
use std::{collections::BTreeSet, fs, path::Path};

/// What the crate leaves out, and why.
const LEFT_OUT: &[(&str, &str)] = &[
    ("DQA_VERSION_MAJOR", "of the header alone; callers have it as sys::DQA_VERSION_MAJOR"),
    ("DQA_VERSION_MINOR", "as above"),
    ("DQA_VERSION_PATCH", "as above"),
];
/// Fields that mean nothing to a caller.
const HIDDEN: [&str; 3] = ["struct_size", "flags", "padding"];
/// Fields that code sets, beside those of the macro.
const BY_HAND: [&str; 5] = ["n_hidden", "hidden", "evaluate", "pullback", "user_data"];

fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Identifiers of a text: runs of letters, digits and underscores.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').filter(|word| !word.is_empty())
}

/// The sources without comments: what is only talked about is not used.
fn sources() -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut text = String::new();
    for entry in fs::read_dir(folder).unwrap() {
        for line in fs::read_to_string(entry.unwrap().path()).unwrap().lines() {
            text.push_str(line.split("//").next().unwrap());
            text.push('\n');
        }
    }
    text
}

/// Names that the interface declares: functions and constants.
fn declared(cdef: &str) -> BTreeSet<&str> {
    let functions = cdef.lines().filter(|line| line.ends_with(");") && !line.starts_with("typedef"));
    let functions = functions.filter_map(|line| words(line.split('(').next()?).last());
    let constants = cdef.lines().filter(|line| line.starts_with("    DQA_")).filter_map(|line| words(line).next());
    functions.chain(constants).collect()
}

#[test]
fn every_function_and_constant_is_reached() {
    let (cdef, sources) = (read("../../diffaqua.cdef"), sources());
    let (declared, used): (BTreeSet<_>, BTreeSet<_>) = (declared(&cdef), words(&sources).collect());
    assert!(declared.len() > 150 && declared.contains("dqa_cma_es_load") && declared.contains("DQA_WRT_LAME"));
    let left_out: BTreeSet<&str> = LEFT_OUT.iter().map(|entry| entry.0).collect();
    let missing: Vec<_> = declared.difference(&used).filter(|name| !left_out.contains(*name)).collect();
    assert!(missing.is_empty(), "the crate does not reach {missing:?}");
    let stale: Vec<_> = left_out.iter().filter(|name| used.contains(*name) || !declared.contains(*name)).collect();
    assert!(stale.is_empty(), "no longer left out: {stale:?}");
}

#[test]
fn every_field_is_reached() {
    let (cdef, sources) = (read("../../diffaqua.cdef"), sources());
    let used: BTreeSet<&str> = words(&sources).collect();
    let mut structs = 0;
    for block in cdef.split("typedef struct ").skip(1).filter(|block| block.lines().next().unwrap().ends_with('{')) {
        let (name, rest) = block.split_once(" {").unwrap();
        let fields = rest.split('}').next().unwrap().lines().filter_map(|line| {
            let declaration = line.split(['[', ';']).next()?;
            words(declaration).last()
        });
        // Most are made by a macro, `Name = struct { fields }`; the others name their fields in code.
        let made =
            sources.split_once(&format!("= {name} ")).map(|(_, section)| section.split("\n    }").next().unwrap());
        let here: BTreeSet<&str> = made.into_iter().flat_map(words).collect();
        for field in fields.filter(|field| !HIDDEN.contains(field)) {
            let by_hand = made.is_none() || BY_HAND.contains(&field);
            assert!(
                here.contains(field) || by_hand && used.contains(field),
                "{name}: the crate does not reach {field}"
            );
        }
        structs += 1;
    }
    assert!(structs >= 17, "{structs}");
}
