#!/bin/sh
# Runs a test of a language whose interpreter may be missing: 77 (skipped), with a message, where it is.
#   run_if_there.sh PROGRAM COMMAND [ARGUMENTS]...
set -eu
program=$1
shift
if ! command -v "$program" >/dev/null 2>&1; then
    echo "skipped: there is no $program here; tests/setup.sh installs it"
    exit 77
fi
exec "$@"
