#!/bin/sh
# Builds the fuzzing harnesses with clang's libFuzzer, address and undefined-behaviour sanitizers, and runs each for a
# while from its seeds and from what earlier runs have found. Stops at the first input that crashes, hangs (20 s) or takes
# more than 3 GiB; it is left in the folder that is printed.
#   run.sh [SECONDS [HARNESS...]]   of each harness (default: all); default 30; 3600 is an hour
set -eu
cd "$(dirname "$0")/../.."
seconds=${1:-30}
[ $# -eq 0 ] || shift
harnesses=${*:-mesh sealed text api}
command -v clang++ >/dev/null 2>&1 || { echo "fuzz: clang++ is not there (tests/setup.sh --full installs it)" >&2; exit 1; }

cmake --preset fuzz >/dev/null
cmake --build --preset fuzz --parallel "${DQA_TEST_JOBS:-$(nproc)}"

export OPENBLAS_NUM_THREADS=1
for name in $harnesses; do
    found=build/fuzz/found/$name
    mkdir -p "$found"
    echo "fuzz: $name for $seconds s; what fails is left in $found-*"
    # What a harness itself prints is of no interest; libFuzzer and the sanitizers are not silenced by this.
    build/fuzz/tests/fuzz_$name -max_total_time="$seconds" -timeout=20 -rss_limit_mb=3072 -max_len=4096 \
        -print_final_stats=1 -close_fd_mask=3 -artifact_prefix="$found-" "$found" "tests/fuzz/seeds/$name"
done
