#!/bin/sh
# SPDX-License-Identifier: MIT
# Builds codesign and runs it with the arguments given; see `examples/run.sh --help`. Results go to ./codesign-out
# unless --out names another folder. The packages that the build needs are installed first where they are missing.
set -eu
root=$(CDPATH= cd -- "$(dirname -- "$0")/.." && pwd)

# The build talks on stderr and only as much as it must: stdout belongs to codesign.
"$root/tests/setup.sh" >&2
log=$(mktemp)
trap 'rm -f "$log"' EXIT
quietly() {
    if ! (cd "$root" && "$@") >"$log" 2>&1; then
        cat "$log" >&2
        echo "run.sh: this failed: $*" >&2
        exit 1
    fi
}
quietly cmake --preset default
quietly cmake --build "$root/build/default" --target codesign -j "$(getconf _NPROCESSORS_ONLN)"
rm -f "$log"
trap - EXIT

program=$root/build/default/examples/codesign
# exec: Ctrl-C then reaches codesign alone, and its exit code is ours.
exec "$program" "$@"
