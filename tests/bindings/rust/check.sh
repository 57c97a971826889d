#!/bin/sh
# SPDX-License-Identifier: MIT
# The Rust crates of bindings/rust against the library of this build. What cargo fetches and builds stays in a folder.
#   check.sh <folder> crates <built libdiffaqua.so> <vectors> <built diffaqua.pc>
#            format, lints, documentation, tests (the vectors among them), the example; how the library is found
#   check.sh <folder> bindings
#            the committed declarations are what bindgen makes of the header
# Both may run at once.
# 77 where cargo, its registry or libclang is absent.
set -eu
crates=$(cd "$(dirname "$0")/../../../bindings/rust" && pwd)
folder=$1 what=$2
skip() {
    echo "skipped: $1"
    exit 77
}

cargo --version 2>/dev/null || skip "cargo is not there"
mkdir -p "$folder/home" "$folder/tmp"
folder=$(cd "$folder" && pwd)
# The registry that the user's settings name, but a cache of our own.
settings="${CARGO_HOME:-${HOME:-/nonexistent}/.cargo}/config.toml"
if [ -f "$settings" ]; then ln -sf "$settings" "$folder/home/config.toml"; fi
export CARGO_HOME="$folder/home" CARGO_TARGET_DIR="$folder/$what" CARGO_TERM_COLOR=never TMPDIR="$folder/tmp"
export CARGO_INCREMENTAL=0 CARGO_PROFILE_DEV_DEBUG=0 OPENBLAS_NUM_THREADS=1
unset RUSTFLAGS RUSTDOCFLAGS CARGO_ENCODED_RUSTFLAGS RUST_BACKTRACE DIFFAQUA_LIBRARY
cd "$crates"

host=$(rustc -vV | sed -n 's/^host: //p')
if ! cargo fetch --locked --offline --target "$host" >/dev/null 2>&1; then
    if ! cargo fetch --locked --target "$host" >"$folder/fetch_$what.log" 2>&1; then
        cat "$folder/fetch_$what.log"
        if grep -qiE 'download|resolve host|connect|timed out|network|unreachable|spurious' "$folder/fetch_$what.log"; then
            skip "the crate registry cannot be reached"
        fi
        exit 1
    fi
fi
export CARGO_NET_OFFLINE=true

crates() {
    library=$1 vectors=$2 pc=$3
    if cargo fmt --version >/dev/null 2>&1; then
        for package in diffaqua-sys diffaqua diffaqua-bindgen; do cargo fmt --check -p "$package"; done
    else
        echo "not checked: rustfmt is not there"
    fi
    export DIFFAQUA_LIBRARY="$library" DQA_VECTORS="$vectors"
    if cargo clippy --version >/dev/null 2>&1; then
        cargo clippy -q --locked --all-targets -- -D warnings
    else
        echo "not checked: clippy is not there"
    fi
    RUSTDOCFLAGS='-D warnings' cargo doc -q --locked --no-deps
    LD_LIBRARY_PATH="$(dirname "$library")${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}" cargo test --locked

    # Without the variable the library is the one that pkg-config knows; without that the message says what to do.
    unset DIFFAQUA_LIBRARY
    export CARGO_TARGET_DIR="$folder/installed" PKG_CONFIG_PATH="$folder/none"
    if cargo build -q --locked -p diffaqua-sys >"$folder/build.log" 2>&1; then
        echo "a library was found where none is known: is one installed in the system?"
    else
        grep -q 'Set PKG_CONFIG_PATH .* or DIFFAQUA_LIBRARY' "$folder/build.log"
    fi
    mkdir -p "$folder/pkgconfig" # as it is installed, but for the folder of the library; abi/install tests the rest
    sed "s|^libdir=.*|libdir=$(dirname "$library")|" "$pc" >"$folder/pkgconfig/diffaqua.pc"
    PKG_CONFIG_PATH="$folder/pkgconfig" LD_LIBRARY_PATH=$(dirname "$library") cargo test -q --locked -p diffaqua-sys
}

bindings() {
    # bindgen says so itself where it finds no libclang; this only saves building it.
    if [ -z "${LIBCLANG_PATH:-}" ] && ! command -v llvm-config >/dev/null 2>&1 &&
        ! find /usr/lib /usr/lib64 /usr/local/lib -maxdepth 4 -name 'libclang*.so*' 2>/dev/null | grep -q .; then
        skip "libclang is not there"
    fi
    cargo build -q --locked -p diffaqua-bindgen
    if ! "$CARGO_TARGET_DIR/debug/diffaqua-bindgen" --check >"$folder/bindgen.log" 2>&1; then
        cat "$folder/bindgen.log"
        if grep -q 'Unable to find libclang' "$folder/bindgen.log"; then skip "libclang is not there"; fi
        exit 1
    fi
    cat "$folder/bindgen.log"
}

shift 2
$what "$@"
