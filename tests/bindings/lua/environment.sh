#!/bin/sh
# Runs a Lua test with the module of the sources, in a scratch folder of the build.
#   environment.sh TEST [ARGUMENTS]...
set -eu
scratch=$DQA_BUILD/tests/scratch/$(basename "$1" .lua)_lua
rm -rf "$scratch"
mkdir -p "$scratch"
cd "$scratch"
sources=$DQA_ROOT/bindings/lua tests=$DQA_ROOT/tests/bindings/lua
LUA_PATH="$sources/?.lua;$sources/?/init.lua;$tests/?.lua" TMPDIR=$scratch exec luajit "$@"
