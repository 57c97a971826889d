#!/bin/sh
# Installs the Debian packages that the library, its tests and its tools need. Needs no root when all are there.
#   setup.sh [--full]   --full: also what tests/run.sh --full needs
set -eu

# package              purpose
packages=$(sed 's/#.*//' <<'LIST'
g++                    # C99 and C++20 compiler
cmake                  # build system, 3.25 or later
ninja-build            # the generator of the presets
pkg-config             # the install test finds the library through it, as callers do
python3                # the ABI and layering checks
abigail-tools          # the ABI against the dump that was frozen
libeigen3-dev          # small matrices, sparse fall-back solvers
libsuitesparse-dev     # CHOLMOD and UMFPACK: sparse factorisations
libopenblas-dev        # BLAS under CHOLMOD
libcmocka-dev          # test framework
gcovr                  # line coverage
gnuplot-nox            # the pictures of codesign
libjs-three            # draws the swimmers in the reports of the example programs
chromium               # opens the reports of the example programs
python3-vtk9           # reads their frames
python3-venv           # environments of the tests of the Python package
python3-torch          # diffaqua.torch; the registry's own is many times as large
luajit                 # tests of the Lua module
octave                 # tests of the Octave package
octave-dev             # compiles its gateway
libosmesa6             # pictures of diffaqua.viz without a screen
dpkg-dev               # dependencies of the Debian packages, read from the binaries
lintian                # their faults
doxygen                # the reference of the header
ccache                 # makes the second build short
LIST
)
# libFuzzer, for tests/fuzz
[ "${1:-}" != --full ] || packages="$packages clang libclang-rt-14-dev"

missing=
for package in $packages; do
    status=$(dpkg-query -W -f '${Status}' "$package" 2>/dev/null || true)
    case $status in
        "install ok installed") ;;
        *) missing="$missing $package" ;;
    esac
done

if [ -z "$missing" ]; then
    echo "setup: all system packages are there"
    exit 0
fi

echo "setup: installing$missing"
if [ "$(id -u)" -eq 0 ]; then
    as_root=
elif command -v sudo >/dev/null 2>&1; then
    as_root=sudo
else
    echo "setup: error: neither root nor sudo; install as root: apt-get install$missing" >&2
    exit 1
fi
if ! command -v apt-get >/dev/null 2>&1; then
    echo "setup: error: no apt-get here; install by hand what corresponds to:$missing" >&2
    exit 1
fi
$as_root apt-get update -q
# shellcheck disable=SC2086  # the list is meant to be split
$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $missing
