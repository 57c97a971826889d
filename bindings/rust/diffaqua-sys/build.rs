// SPDX-License-Identifier: MIT
//! Finds the shared library: where DIFFAQUA_LIBRARY says (the path of a libdiffaqua.so, as of a build tree), else where
//! pkg-config knows it.
use std::{env, path::Path};

/// Versions whose interface is that of src/bindings.rs: below 1.0 a new minor one may change it.
const VERSIONS: std::ops::Range<&str> = "0.1.0".."0.2.0";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=DIFFAQUA_LIBRARY");
    if env::var_os("DOCS_RS").is_some() {
        return; // documentation links nothing
    }
    let found = match env::var("DIFFAQUA_LIBRARY") {
        Ok(path) => from_path(&path),
        Err(_) => match pkg_config::Config::new().range_version(VERSIONS).probe("diffaqua") {
            Ok(_) => Ok(()),
            Err(error) => Err(format!(
                "libdiffaqua, from {} to below {}, was not found. Set PKG_CONFIG_PATH to the folder of its \
                 diffaqua.pc, or DIFFAQUA_LIBRARY to the path of libdiffaqua.so.\n{error}",
                VERSIONS.start, VERSIONS.end
            )),
        },
    };
    if let Err(message) = found {
        eprintln!("{message}");
        std::process::exit(1);
    }
}

fn from_path(path: &str) -> Result<(), String> {
    let library = Path::new(path);
    let name = library.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    if !name.starts_with("libdiffaqua.so") || !library.is_file() {
        return Err(format!("DIFFAQUA_LIBRARY: expected the path of an existing libdiffaqua.so, got {path:?}"));
    }
    let folder = library.parent().unwrap_or(Path::new("."));
    // The linker takes libdiffaqua.so; a full version such as libdiffaqua.so.0.1.0 lies beside it.
    println!("cargo::rustc-link-search=native={}", folder.display());
    println!("cargo::rustc-link-lib=dylib=diffaqua");
    println!("cargo::rerun-if-changed={path}");
    Ok(())
}
