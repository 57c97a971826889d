#!/bin/sh
# Runs the unit and C API tests of the coverage build (which must stand; run.sh builds it), tells the line coverage of
# each file of capi/ and src/ and which lines no test reaches, and fails below the goals.
#   DQA_TEST_JOBS   parallel jobs; default: the number of processors
set -eu
cd "$(dirname "$0")/.."

# Least line coverage, in percent. The sample program of the reference (capi/reference) is no part of the library.
capi_goal=100
src_goal=90

jobs=${DQA_TEST_JOBS:-$(nproc)}
build=build/coverage
traces=$build/coverage.json

find "$build" -name '*.gcda' -delete
ctest --preset coverage --parallel "$jobs"
gcovr -j "$jobs" --root . --object-directory "$build" --filter 'capi/' --filter 'src/' \
    --exclude 'capi/reference/' --json "$traces"
status=0
for part in capi src; do
    case $part in
        capi) goal=$capi_goal ;;
        src) goal=$src_goal ;;
    esac
    echo "coverage: lines of $part/, at least $goal % wanted"
    gcovr --root . --add-tracefile "$traces" --filter "$part/" \
        --fail-under-line "$goal" || status=1
done
[ "$status" = 0 ] || echo "coverage: below the goal" >&2
exit "$status"
