#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The library keeps the ABI that was frozen for its SONAME (frozen/*.abi, compared by libabigail's abidiff), and its
header the values of the frozen constants, which no debug information tells.

    check_abidiff.py --library LIB --headers CAPI       checks a library with debug information
    check_abidiff.py --broken BUILD --headers CAPI      proves the check: builds copies of the C layer with one change
                                                        each, and expects just the breaks to be found
"""
import argparse
import glob
import json
import os
import re
import shlex
import shutil
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
# (name, a break?, C++ file compiled anew or None, [(file, pattern, replacement)]). Each pattern must occur just once.
NEW_FUNCTION = [("diffaqua.h", r"(DQA_API dqa_status dqa_project_simplex\()", r"DQA_API int32_t dqa_new(double *x);\n\1"),
                ("controller.cpp", r"\Z", 'extern "C" int32_t dqa_new(double* x) { return x != nullptr; }\n'),
                ("diffaqua.map", r"(dqa_project_simplex;)", r"\1 dqa_new;")]
CHANGES = [
    ("nothing", False, "optimize.cpp", []),
    ("a function appended", False, "controller.cpp", NEW_FUNCTION),
    ("a field appended", False, "tape.cpp", [("diffaqua.h", r"(int64_t memory_bytes;)", r"\1 int64_t more;")]),
    ("a padding that got a name", False, "controller.cpp",
     [("diffaqua.h", r"int32_t padding;( +/\* 0 \*/\n +int64_t n_parameters;)", r"int32_t order;\1")]),
    ("a function removed", True, None, [("diffaqua.map", r"dqa_project_simplex;", "")]),
    ("a parameter's type, to one of the same size", True, "controller.cpp",
     [(name, r"(dqa_project_simplex\(double ?\* ?\w+, )int64_t", r"\1uint64_t") for name in ("diffaqua.h", "controller.cpp")]),
    ("a field in the middle", True, "tape.cpp", [("diffaqua.h", r"(int64_t memory_bytes;)", r"int64_t more; \1")]),
    ("a field's type, and a field appended", True, "tape.cpp",
     [("diffaqua.h", r"int64_t (memory_bytes;)", r"double \1 int64_t more;")]),
    ("a field's name", True, "tape.cpp",
     [("diffaqua.h", r"\brescued_steps;", "mended_steps;"), ("tape.cpp", r"\bout\.rescued_steps\b", "out.mended_steps")]),
    ("two fields swapped", True, "tape.cpp",
     [("diffaqua.h", r"double (worst_residual;)((?:.|\n)*?)double (worst_adjoint_residual;)", r"double \3\2double \1")]),
    ("a field removed at the end", True, "shape_space.cpp",
     [("diffaqua.h", r"int32_t padding; .*\n(\} dqa_signal_info;)", r"\1")]),
    ("a callback's parameter", True, "tape.cpp", [("diffaqua.h", r"(\(\*dqa_progress\)\(int)64_t", r"\g<1>32_t")]),
    ("a callback that only a field has, and a field appended", True, "controller.cpp",
     [("diffaqua.h", r"(\(\*dqa_control_evaluate\)\(int)64_t", r"\g<1>32_t"),
      ("diffaqua.h", r"(void \*user_data;[^;{}]*)(\} dqa_callback_controller_options;)", r"\1 void *more; \2")]),
    ("the SONAME", True, None, [("soname", "", "9")]),
]


def build(commands, headers, folder, source, edits):
    """The C layer with `edits`, `source` compiled anew and the rest as it is; not linked to what lies below it."""
    copy = os.path.join(folder, "capi")
    shutil.copytree(headers, copy)
    suffix = "0"
    for name, pattern, replacement in edits:
        if name == "soname":
            suffix = replacement
            continue
        with open(os.path.join(copy, name), encoding="utf-8") as file:
            text, count = re.subn(pattern, replacement, file.read())
        if count != 1:
            raise RuntimeError(f"{pattern!r} occurs {count} times in {name}: this check no longer fits the sources")
        with open(os.path.join(copy, name), "w", encoding="utf-8") as file:
            file.write(text)
    objects = []
    for name, (command, directory, made) in commands.items():
        if name == source:
            made = os.path.join(folder, "changed.o")
            words = [word for word in command if word not in ("-Werror", "-c")]
            at = words.index("-o")
            del words[at:at + 2], words[-1]
            include = os.path.abspath(headers)
            words = [word.replace(include, copy) for word in words]
            # The code behind a changed declaration need not fit it: only the ABI is looked at.
            run(words + ["-O0", "-w", "-fpermissive", "-c", os.path.join(copy, name), "-o", made], directory)
        objects.append(os.path.join(directory, made))
    library = os.path.join(folder, "libbroken.so")
    run([next(iter(commands.values()))[0][0], "-shared", "-o", library, *objects, "-Wl,-soname,libdiffaqua.so." + suffix,
         "-Wl,--version-script=" + os.path.join(copy, "diffaqua.map")], folder)
    return library, copy


def run(command, directory):
    done = subprocess.run(command, cwd=directory, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{shlex.join(command)}: {done.stdout}{done.stderr}")


def prove(build_folder, headers):
    """Lines on what the check missed, or took for a break and is none."""
    with open(os.path.join(build_folder, "compile_commands.json"), encoding="utf-8") as file:
        entries = json.load(file)
    commands = {}
    for entry in entries:
        if os.path.dirname(entry["file"]) == os.path.abspath(headers):
            command = shlex.split(entry["command"])
            if os.path.basename(command[0]) == "ccache":
                del command[0]
            commands[os.path.basename(entry["file"])] = (command, entry["directory"], command[command.index("-o") + 1])
    for name, is_break, source, edits in CHANGES:
        with tempfile.TemporaryDirectory(prefix="abi-") as folder:
            library, copy = build(commands, headers, folder, source, edits)
            found = check(library, copy)
        print(f"{name}: {'a break' if found else 'none'}")
        if is_break != bool(found):
            yield f"{name}: {'not noticed' if is_break else 'taken for a break: ' + ' '.join(found)}"
    with tempfile.TemporaryDirectory(prefix="abi-") as folder:
        old, new = os.path.join(folder, "old.h"), os.path.join(folder, "new.h")
        for path, text in ((old, "#define DQA_A 1\n#define DQA_B (-2)\n#define DQA_C 3\n"),
                           (new, "#define DQA_B (-3)\n#define DQA_C 3 /* three */\n#define DQA_D 4\n")):
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
        if len(list(moved_constants(old, new))) != 2:
            yield "constants: one is gone and one has moved, and this was not noticed"


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
