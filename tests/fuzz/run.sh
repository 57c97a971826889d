#!/bin/sh
# Builds the fuzzing harnesses with clang's libFuzzer, address and undefined-behaviour sanitizers, and runs each for a
# while from its seeds. Stops at the first input that crashes, hangs (10 s) or takes more than 2 GiB; it is left in the
# folder that is printed.
#   run.sh [SECONDS]   of each harness; default 30
set -eu
cd "$(dirname "$0")/../.."
seconds=${1:-30}
work=build/fuzz
mkdir -p "$work"
compiler=${CXX_FUZZ:-clang++}
command -v "$compiler" >/dev/null 2>&1 || { echo "fuzz: $compiler is not there (Debian: clang and libclang-rt-14-dev)" >&2; exit 77; }

flags="-std=c++20 -O1 -g -fno-omit-frame-pointer -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=undefined"
sources="src/shape/stl_reader.cpp src/shape/obj_reader.cpp src/shape/ply_reader.cpp src/shape/mesh_polygon.cpp
    src/shape/mesh_file.cpp src/shape/mesh.cpp src/grid/error.cpp src/grid/log.cpp"
# shellcheck disable=SC2086  # lists of words
"$compiler" $flags -Isrc tests/fuzz/fuzz_mesh.cpp $sources -o "$work/fuzz_mesh"

mkdir -p "$work/mesh"
"$work/fuzz_mesh" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -max_len=4096 -print_final_stats=1 \
    -artifact_prefix="$work/" "$work/mesh" tests/fuzz/seeds/mesh
