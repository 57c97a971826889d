#!/bin/sh
# Runs a test of the Octave package, with its sources and the gateway of this build, in a scratch folder.
#   environment.sh TEST      a function of this folder
set -eu
scratch=$DQA_BUILD/tests/scratch/$1_octave
gateway=$DQA_BUILD/tests/octave
rm -rf "$scratch"
mkdir -p "$scratch" "$gateway"
cd "$scratch"
export TMPDIR="$scratch" DQA_GATEWAY="$gateway"
exec octave-cli --norc --no-history --no-window-system \
    --path "$DQA_ROOT/bindings/octave:$gateway:$DQA_ROOT/tests/bindings/octave" --eval "$1"
