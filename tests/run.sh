#!/bin/sh
# Builds everything and runs every test: first what the sanitizers can see in the quick ones, then the whole suite of the
# optimised build, whose ctest summary is the last thing printed. Stops at the first run that fails.
#   run.sh [--full]     --full runs what takes long besides: the line coverage of the quick tests against its goals
#                       (tests/coverage.sh), 30 s of each fuzzing harness (tests/fuzz/run.sh), and tests labelled full
#   DQA_TEST_DATA   folder of mesh files that some tests read (they skip without it); default ../shared/data if there
#   DQA_TEST_JOBS   parallel jobs of build and tests; default: the number of processors
#   DQA_TEST_ASAN   0 leaves the sanitizer run out
#   DQA_TEST_INSTALL    1 lets the test of the Debian packages install them on this machine for a moment, as root;
#                       default: 1 where the variable CI is set, as services that test on machines of their own do
set -eu
cd "$(dirname "$0")/.."
repo=$(pwd)

full=
case "$#:${1:-}" in
    0:) ;;
    1:--full) full=--full ;;
    *) echo "usage: tests/run.sh [--full]" >&2; exit 2 ;;
esac

./tests/setup.sh $full

if [ -z "${DQA_TEST_DATA:-}" ] && [ -d "$repo/../shared/data" ]; then
    DQA_TEST_DATA=$(cd "$repo/../shared/data" && pwd)
fi
if [ -n "${DQA_TEST_DATA:-}" ]; then
    export DQA_TEST_DATA
else
    echo "run: DQA_TEST_DATA is not set: tests that read mesh files will skip"
fi

export DQA_TEST_INSTALL="${DQA_TEST_INSTALL:-${CI:+1}}"

jobs=${DQA_TEST_JOBS:-$(nproc)}
# Tests run side by side: threads of BLAS beneath them would only get in each other's way.
export OPENBLAS_NUM_THREADS=1
launcher=
if command -v ccache >/dev/null 2>&1; then
    launcher="-DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache"
fi

build() {
    echo "run: building preset $1"
    # shellcheck disable=SC2086  # two options or none
    cmake --preset "$1" $launcher
    cmake --build --preset "$1" --parallel "$jobs"
}

build default
if [ "${DQA_TEST_ASAN:-1}" != 0 ]; then
    build asan
    echo "run: tests under the address and undefined-behaviour sanitizers"
    ctest --preset asan --parallel "$jobs"
fi
if [ -n "$full" ]; then
    build coverage
    ./tests/coverage.sh
    ./tests/fuzz/run.sh 30
fi
echo "run: all tests"
if [ -n "$full" ]; then
    ctest --preset default --parallel "$jobs"
else
    ctest --preset default --parallel "$jobs" --label-exclude '^full$'
fi
