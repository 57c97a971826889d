# SPDX-License-Identifier: MIT
"""Dependencies between the rooms run downward only: reads every #include "..." of src/ and capi/.

    capi -> {optimize, tape} -> motion -> {body, water, control} -> {linalg, shape} -> grid

A room uses itself and the floors below it, never a neighbour on its own floor; optimize uses grid only.
"""
import os
import re
import sys
import tempfile

GROUND = {"grid"}
LOWER = GROUND | {"linalg", "shape"}
MIDDLE = LOWER | {"body", "water", "control"}
MAY_USE = {
    "grid": set(),
    "linalg": GROUND,
    "shape": GROUND,
    "body": LOWER,
    "water": LOWER,
    "control": LOWER,
    "motion": MIDDLE,
    "tape": MIDDLE | {"motion"},
    "optimize": GROUND,
    "capi": MIDDLE | {"motion", "tape", "optimize"},
}
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*"([^"]+)"', flags=re.M)
SUFFIXES = (".c", ".cc", ".cpp", ".h", ".hpp", ".inl", ".ipp")


def check_file(path, shown, room):
    with open(path, encoding="utf-8") as file:
        includes = INCLUDE.findall(file.read())
    for include in includes:
        head, slash, _ = include.partition("/")
        if not slash:
            # A neighbour in the same folder; the public header belongs to capi/ alone.
            if not os.path.exists(os.path.join(os.path.dirname(path), include)):
                yield f'{shown}: "{include}" is not in this room; write "room/{include}"'
        elif head not in MAY_USE or head == "capi":
            yield f'{shown}: "{include}" does not start with a room of src/'
        elif head != room and head not in MAY_USE[room]:
            yield f'{shown}: {room} may not use {head} ("{include}")'


def check(root):
    rooms = {"capi": os.path.join(root, "capi")}
    source = os.path.join(root, "src")
    for entry in sorted(os.listdir(source)):
        if entry in MAY_USE and entry != "capi":
            rooms[entry] = os.path.join(source, entry)
        else:
            yield f"src/{entry}: not a room that this check knows"
    for room, folder in rooms.items():
        for directory, _, names in os.walk(folder):
            for name in sorted(names):
                if name.endswith(SUFFIXES):
                    path = os.path.join(directory, name)
                    yield from check_file(path, os.path.relpath(path, root), room)


def self_test():
    """One wrong include of each kind is found, and right ones are not."""
    cases = [("src/grid/a.hpp", "linalg/b.hpp", True), ("src/body/a.hpp", "water/b.hpp", True),
             ("src/linalg/a.hpp", "shape/b.hpp", True), ("src/optimize/a.hpp", "linalg/b.hpp", True),
             ("src/motion/a.hpp", "tape/b.hpp", True), ("src/tape/a.hpp", "optimize/b.hpp", True),
             ("src/motion/a.hpp", "../body/b.hpp", True), ("src/tape/a.hpp", "diffaqua.h", True),
             ("src/body/a.hpp", "capi/diffaqua.h", True), ("src/body/a.hpp", "nowhere/b.hpp", True),
             ("src/odd/a.hpp", "odd/a.hpp", True),
             ("capi/a.cpp", "tape/b.hpp", False), ("capi/a.cpp", "diffaqua.h", False),
             ("src/motion/a.hpp", "water/b.hpp", False), ("src/body/a.hpp", "body/b.hpp", False)]
    for path, include, wrong in cases:
        with tempfile.TemporaryDirectory() as root:
            for folder in ("capi", "src", os.path.dirname(path)):
                os.makedirs(os.path.join(root, folder), exist_ok=True)
            open(os.path.join(root, "capi/diffaqua.h"), "w", encoding="utf-8").close()
            with open(os.path.join(root, path), "w", encoding="utf-8") as file:
                file.write(f'#include <vector>\n  #  include "{include}"\n')
            if bool(list(check(root))) != wrong:
                yield f'{path} with "{include}" was {"accepted" if wrong else "refused"}'


if __name__ == "__main__":
    problems = list(self_test() if sys.argv[1] == "--self-test" else check(sys.argv[1]))
    print("\n".join(problems) or "includes run downward only")
    sys.exit(1 if problems else 0)
