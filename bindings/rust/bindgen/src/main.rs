// SPDX-License-Identifier: MIT
//! Makes `diffaqua-sys/src/bindings.rs` from `capi/diffaqua.h`. The output is committed, so that users of the crates
//! need no libclang.
//!
//! ```text
//! cargo run -p diffaqua-bindgen              writes the file
//! cargo run -p diffaqua-bindgen -- --check   fails where that file is not what the header says
//! ```
use std::{env, fs, path::Path, process::ExitCode};

const TOP: &str = "// SPDX-License-Identifier: MIT\n\
                   // Made by bindgen from capi/diffaqua.h, where everything is explained: see bindings/rust/bindgen.";

/// The declarations alone: comments stay in the header, so that a change of wording changes nothing here.
fn declarations(header: &str) -> Result<String, bindgen::BindgenError> {
    let made = bindgen::builder()
        .header(header)
        .raw_line(TOP)
        .allowlist_item("(dqa|DQA)_.*")
        .blocklist_item("DQA_API")
        .use_core()
        .ctypes_prefix("core::ffi")
        .default_macro_constant_type(bindgen::MacroTypeVariation::Signed)
        .merge_extern_blocks(true)
        .generate_comments(false)
        .derive_default(false)
        .disable_header_comment()
        .rust_edition(bindgen::RustEdition::Edition2024)
        .rust_target(bindgen::RustTarget::stable(85, 0).expect("a version that bindgen knows"))
        .formatter(bindgen::Formatter::Prettyplease)
        .generate()?;
    Ok(made.to_string())
}

fn main() -> ExitCode {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let header = here.join("../../../capi/diffaqua.h");
    let target = here.join("../diffaqua-sys/src/bindings.rs");
    let arguments: Vec<String> = env::args().skip(1).collect();
    let wanted = match declarations(&header.to_string_lossy()) {
        Ok(text) => text,
        Err(error) => {
            eprintln!("{}: {error}", header.display());
            return ExitCode::FAILURE;
        }
    };
    let done = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => fs::write(&target, &wanted),
        ["--check"] => fs::read_to_string(&target).and_then(|text| {
            if text == wanted {
                println!("bindings.rs is current: {} functions", wanted.matches("pub fn dqa_").count());
                return Ok(());
            }
            Err(std::io::Error::other("not what the header says: run `cargo run -p diffaqua-bindgen`"))
        }),
        _ => Err(std::io::Error::other("usage: diffaqua-bindgen [--check]")),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{}: {error}", target.display());
            ExitCode::FAILURE
        }
    }
}
