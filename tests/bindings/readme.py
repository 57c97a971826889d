#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The lines of README.md in one language work when pasted: run in the root of the repository, they print the loss of a
swimmer and its gradient by the weights, which has no mean.

    readme.py LANGUAGE ROOT LIBRARY FOLDER     FOLDER keeps what has to be compiled
77 where the README has no lines in the language, or what runs them is absent. C and Python have tests of their own.
"""
import math
import os
import re
import shutil
import subprocess
import sys

NUMBER = re.compile(r"-?\d+\.\d+(?:e[-+]?\d+)?|-?\d+e[-+]?\d+")


def skip(why):
    print("skipped:", why)
    sys.exit(77)


def need(program):
    found = shutil.which(program)
    if not found:
        skip(f"there is no {program} here")
    return found


def run(command, **environment):
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT, timeout=800,
                          env={**os.environ, "OPENBLAS_NUM_THREADS": "1", **environment})
    if done.returncode != 0:
        sys.exit(f"{command[0]} ends with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done.stdout


def write(name, text):
    path = os.path.join(FOLDER, name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return path


def lua(lines):
    return run([need("luajit"), write("pasted.lua", lines)], DIFFAQUA_LIBRARY=LIBRARY,
               LUA_PATH="{0}/bindings/lua/?.lua;{0}/bindings/lua/?/init.lua;;".format(ROOT))


def octave(lines):
    program = need("octave-cli")
    need("mkoctfile")
    make = (f"addpath ('{ROOT}/bindings/octave'); "
            f"diffaqua_make ({{'{ROOT}/capi', '{os.path.dirname(LIBRARY)}'}}, '{FOLDER}');")
    run([program, "--no-gui", "--norc", "--eval", make])
    return run([program, "--no-gui", "--norc", "--path", f"{ROOT}/bindings/octave", "--path", FOLDER,
                write("pasted.m", lines)])


def rust(lines):
    cargo = need("cargo")
    write("Cargo.toml", '[package]\nname = "pasted"\nversion = "0.0.0"\nedition = "2021"\n[workspace]\n[dependencies]\n'
          f'diffaqua = {{ path = "{ROOT}/bindings/rust/diffaqua" }}\n')
    write("src/main.rs", lines)
    # What the test of the crates has fetched serves here too.
    home = os.path.join(os.path.dirname(FOLDER), "rust", "home")
    environment = {"DIFFAQUA_LIBRARY": LIBRARY, "LD_LIBRARY_PATH": os.path.dirname(LIBRARY)}
    if os.path.isdir(home):
        environment["CARGO_HOME"] = home
    manifest = os.path.join(FOLDER, "Cargo.toml")
    offline = subprocess.run([cargo, "fetch", "--offline", "--manifest-path", manifest], capture_output=True,
                             env={**os.environ, **environment}, check=False).returncode == 0
    if not offline and subprocess.run([cargo, "fetch", "--manifest-path", manifest], capture_output=True,
                                      env={**os.environ, **environment}, check=False).returncode != 0:
        skip("the crate registry cannot be reached")
    return run([cargo, "run", "-q", "--manifest-path", manifest], **environment)


def main():
    with open(os.path.join(ROOT, "README.md"), encoding="utf-8") as file:
        pasted = re.findall(rf"^```{MARKS.get(LANGUAGE, LANGUAGE)}\n(.*?)^```$", file.read(), re.MULTILINE | re.DOTALL)
    if not pasted:
        skip(f"README.md has no lines in {LANGUAGE}")
    if len(pasted) > 1:
        sys.exit(f"{len(pasted)} programs in {LANGUAGE}, one is enough")
    os.makedirs(FOLDER, exist_ok=True)
    printed = RUNNERS[LANGUAGE](pasted[0])
    print(printed)
    loss, *gradient = [float(number) for number in NUMBER.findall(printed)][:3]
    if not (math.isfinite(loss) and loss != 0.0 and len(gradient) == 2):
        sys.exit("a loss and a gradient by two weights were expected")
    if gradient[0] == 0.0 or not math.isclose(gradient[0], -gradient[1], rel_tol=1e-4):  # as they are printed
        sys.exit(f"the gradient by the weights is {gradient}, and should be without mean and not nothing")


MARKS = {"octave": "matlab"}  # what a page calls the language
RUNNERS = {"lua": lua, "octave": octave, "rust": rust}

if __name__ == "__main__":
    if len(sys.argv) != 5 or sys.argv[1] not in RUNNERS:
        sys.exit(__doc__.strip())
    LANGUAGE, ROOT, LIBRARY, FOLDER = sys.argv[1], *map(os.path.abspath, sys.argv[2:])
    main()
