#!/bin/sh
# Builds everything and runs every test: first what the sanitizers can see in the quick ones, with their line coverage
# against its goals (tests/coverage.sh; one build serves both), then the whole suite of the optimised build, whose ctest summary
# is the last thing printed. Stops at the first run that fails.
#   DQA_TEST_DATA   folder of mesh files that some tests read (they skip without it); default ../shared/data if there
#   DQA_TEST_JOBS   parallel jobs of build and tests; default: the number of processors
#   DQA_TEST_ASAN   0 leaves the sanitizer run and the coverage out
#   DQA_TEST_INSTALL    1 lets the test of the Debian packages install them on this machine for a moment, as root;
#                       default: 1 where the variable CI is set, as services that test on machines of their own do
#   DQA_TEST_COVERAGE   0 leaves the coverage out
set -eu
cd "$(dirname "$0")/.."
repo=$(pwd)

./tests/setup.sh

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
    find build/asan -name '*.gcda' -delete
    ctest --preset asan --parallel "$jobs"
    if [ "${DQA_TEST_COVERAGE:-1}" != 0 ]; then
        ./tests/coverage.sh
    fi
fi
echo "run: all tests"
ctest --preset default --parallel "$jobs"
