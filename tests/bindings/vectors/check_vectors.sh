#!/bin/sh
# Writes the test vectors twice, which must give the same bytes, and compares them with the committed ones.
#   check_vectors.sh <python> <write_vectors> <file to write> <committed file>
set -eu
python=$1 writer=$2 written=$3 committed=$4
OPENBLAS_NUM_THREADS=1
export OPENBLAS_NUM_THREADS
"$writer" "$written"
"$writer" "$written.again"
cmp "$written" "$written.again"
rm "$written.again"
"$python" -B "$(dirname "$0")/compare_vectors.py" "$written" "$committed"
# The comparison must be able to fail: one number off by a relative 1e-9.
sed 's/"n_steps": 24,/"n_steps": 24.00000003,/' "$written" >"$written.off"
if "$python" -B "$(dirname "$0")/compare_vectors.py" "$written.off" "$committed"; then
    echo "a number that is off was not noticed" >&2
    exit 1
fi
rm "$written.off"
