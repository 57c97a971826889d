#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The library keeps the ABI that was frozen for its SONAME (frozen/*.abi, compared by libabigail's abidiff), and its
header the values of the frozen constants, which no debug information tells.

    check_abidiff.py --library LIB --headers CAPI       checks a library with debug information
    check_abidiff.py --broken COMPILER --headers CAPI   proves the check: changes one thing at a time in the header and
                                                        the version script, compiles each declaration as an empty
                                                        function, and expects just the breaks to be found
"""
import argparse
import glob
import os
import re
import shlex
import subprocess
import sys
import tempfile

import abigail
import header

FROZEN = os.path.join(os.path.dirname(os.path.abspath(__file__)), "frozen")
FREEZE = "tests/abi/freeze.py BUILD"


def moved_constants(old, new):
    """What became of the constants of the header `old` in `new`."""
    before, after = header.constants(old), header.constants(new)
    for name, value in before.items():
        if name not in after:
            yield f"{name} is gone from the header"
        elif after[name] != value:
            yield f"{name} was {value} and is {after[name]}"


def check(library, headers):
    """Lines on what is wrong."""
    with tempfile.TemporaryDirectory(prefix="abi-") as folder:
        now = os.path.join(folder, "now.abi")
        abigail.dump(library, headers, now)
        frozen = os.path.join(FROZEN, abigail.soname(now) + ".abi")
        if not os.path.exists(frozen):
            return [f"{os.path.basename(frozen)} is not there: a new generation of the ABI is frozen by {FREEZE}"]
        problems = [abigail.breaks(frozen, now)]
    for old in sorted(glob.glob(os.path.join(FROZEN, "diffaqua-*.h"))):
        # Headers of another generation may have other values.
        if header.constants(old, versions=True)["DQA_ABI_VERSION"] == int(abigail.soname(frozen).rpartition(".")[2]):
            problems += moved_constants(old, os.path.join(headers, "diffaqua.h"))
    return [problem for problem in problems if problem]


# ---------------------------------------------------------------------------------------------- the proof of the check
# (what changes, a break?, [(file, pattern, replacement)]). Each pattern must occur just once. The unchanged header must
# give the frozen ABI, so that what is found in these small libraries would be found in the real one.
CHANGES = [
    ("nothing", False, []),
    ("a function appended", False,
     [("diffaqua.h", r"(DQA_API dqa_status dqa_project_simplex\()", r"DQA_API int32_t dqa_new(double *x);\n\1"),
      ("diffaqua.map", r"(dqa_project_simplex;)", r"\1 dqa_new;")]),
    ("a field appended", False, [("diffaqua.h", r"(int64_t memory_bytes;)", r"\1 int64_t more;")]),
    ("a padding that got a name", False,
     [("diffaqua.h", r"int32_t padding;( +/\* 0 \*/\n +int64_t n_parameters;)", r"int32_t order;\1")]),
    ("a function removed", True, [("diffaqua.map", r"dqa_project_simplex;", "")]),
    ("a parameter's type", True, [("diffaqua.h", r"(dqa_project_simplex\(double \*x, int)64_t", r"\g<1>32_t")]),
    ("a parameter's type, to one of the same size", True,
     [("diffaqua.h", r"(dqa_project_simplex\(double \*x, )int64_t", r"\1uint64_t")]),
    ("a parameter that is no longer const", True,
     [("diffaqua.h", r"(dqa_adam_step\(double \*x, )const double", r"\1double")]),
    ("a parameter more", True, [("diffaqua.h", r"(dqa_project_simplex\(double \*x, int64_t n)", r"\1, int32_t more")]),
    ("what a function returns", True, [("diffaqua.h", r"(DQA_API )int32_t( dqa_abi_version)", r"\1int64_t\2")]),
    ("a field in the middle", True, [("diffaqua.h", r"(int64_t memory_bytes;)", r"int64_t more; \1")]),
    ("a field's type, to one of the same size", True, [("diffaqua.h", r"int64_t (memory_bytes;)", r"double \1")]),
    ("a field's type, and a field appended", True,
     [("diffaqua.h", r"int64_t (memory_bytes;)", r"double \1 int64_t more;")]),
    ("a field's name", True, [("diffaqua.h", r"\brescued_steps;", "mended_steps;")]),
    ("the length of an array", True, [("diffaqua.h", r"(int32_t hidden)\[5\]", r"\1[6]")]),
    ("two fields swapped", True,
     [("diffaqua.h", r"double (worst_residual;)((?:.|\n)*?)double (worst_adjoint_residual;)", r"double \3\2double \1")]),
    ("a field removed at the end", True, [("diffaqua.h", r"int32_t padding; .*\n(\} dqa_signal_info;)", r"\1")]),
    ("a callback's parameter", True, [("diffaqua.h", r"(\(\*dqa_progress\)\(int)64_t", r"\g<1>32_t")]),
    ("a callback that only a field has, and a field appended", True,
     [("diffaqua.h", r"(\(\*dqa_control_evaluate\)\(int)64_t", r"\g<1>32_t"),
      ("diffaqua.h", r"(void \*user_data;[^;{}]*)(\} dqa_callback_controller_options;)", r"\1 void *more; \2")]),
    ("the value of a constant", True, [("diffaqua.h", r"(#define DQA_SEED_VELOCITY) 1", r"\1 7")]),
    ("a constant removed", True, [("diffaqua.h", r"#define DQA_SEED_VELOCITY 1.*\n", "")]),
    ("the SONAME", True, [("soname", "", "9")]),
]


def build(compiler, headers, folder, edits):
    """A library of the changed header: each function that it declares, doing nothing."""
    suffix = str(header.constants(os.path.join(headers, "diffaqua.h"), versions=True)["DQA_ABI_VERSION"])
    texts = {}
    for name in ("diffaqua.h", "diffaqua.map"):
        with open(os.path.join(headers, name), encoding="utf-8") as file:
            texts[name] = file.read()
    for name, pattern, replacement in edits:
        if name == "soname":
            suffix = replacement
            continue
        texts[name], count = re.subn(pattern, replacement, texts[name])
        if count != 1:
            raise RuntimeError(f"{pattern!r} occurs {count} times in {name}: this check no longer fits the header")
    code = re.sub(r"/\*.*?\*/", "", texts["diffaqua.h"], flags=re.S)
    texts["all.c"] = '#include <stdlib.h>\n#include "diffaqua.h"\n' + "".join(
        declaration + " { abort(); }\n" for declaration in re.findall(r"DQA_API\s+([^;#]*\))\s*;", code))
    for name, text in texts.items():
        with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
            file.write(text)
    library = os.path.join(folder, "liball.so")
    run([compiler, "-std=c99", "-g", "-fPIC", "-shared", "-fvisibility=hidden", "-o", library,
         os.path.join(folder, "all.c"), "-Wl,-soname,libdiffaqua.so." + suffix,
         "-Wl,--version-script=" + os.path.join(folder, "diffaqua.map")])
    return library


def run(command):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{shlex.join(command)}: {done.stdout}{done.stderr}")


def prove(compiler, headers):
    """Lines on what the check missed, or took for a break and is none."""
    for name, is_break, edits in CHANGES:
        with tempfile.TemporaryDirectory(prefix="abi-") as folder:
            found = check(build(compiler, headers, folder, edits), folder)
        print(f"{name}: {'a break' if found else 'none'}")
        if is_break != bool(found):
            yield f"{name}: {'not noticed' if is_break else 'taken for a break: ' + ' '.join(found)}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--headers", required=True)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--library")
    what.add_argument("--broken")
    arguments = parser.parse_args()
    tool = abigail.missing_tool()
    if tool:
        print(f"skipped: no {tool} (Debian: abigail-tools)")
        sys.exit(77)
    if arguments.library:
        problems = check(arguments.library, arguments.headers)
        advice = f"Before a release that may break the ABI, and after a compatible change, freeze it anew: {FREEZE}"
    else:
        problems, advice = list(prove(arguments.broken, arguments.headers)), ""
    print("\n".join([*problems, advice]) if problems else "the ABI is what was frozen")
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
