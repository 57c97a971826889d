#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes diffaqua.cdef: the declarations of capi/diffaqua.h without preprocessor and comments, for foreign-function
interfaces that read C themselves (cffi, LuaJIT). Constants become enumerators.

    generate_cdef.py            writes the file beside this script
    generate_cdef.py --check    fails where that file is not what the header says
"""
import os
import re
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
HEADER = os.path.join(HERE, "..", "capi", "diffaqua.h")
CDEF = os.path.join(HERE, "diffaqua.cdef")
# What C calls a macro but no program needs at run time.
NOT_CONSTANTS = {"DIFFAQUA_H", "DQA_API"}


def cdef(header):
    """The declarations of the header's text. Raises ValueError for what a plain reader could not make sense of."""
    source = re.sub(r"/\*.*?\*/", " ", header, flags=re.S)
    source = re.sub(r"^#ifdef __cplusplus$.*?^#endif$", "", source, flags=re.M | re.S)
    constants = []
    for name, value in re.findall(r"^[ \t]*#[ \t]*define[ \t]+(\w+)[ \t]*(.*?)[ \t]*$", source, flags=re.M):
        if name in NOT_CONSTANTS:
            continue
        number = re.fullmatch(r"\(?(-?\d+)\)?", value)
        if not number:
            raise ValueError(f"the constant {name} is {value!r}, not a whole number")
        constants.append(f"    {name} = {number.group(1)},")
    body = re.sub(r"^[ \t]*#.*$", "", source, flags=re.M)
    body = re.sub(r"\bDQA_API\b\s*", "", body)
    body = "\n".join(" ".join(line.split()) for line in body.splitlines())
    lines = []
    for statement in re.findall(r"[^;{}]*\{.*?\}[^;]*;|[^;]+;", body, flags=re.S):
        statement = statement.strip()
        inside = re.fullmatch(r"(.*?)\{(.*)\}(.*)", statement, flags=re.S)
        if inside:
            fields = [" ".join(field.split()) for field in inside.group(2).split(";") if field.strip()]
            lines.append(f"{inside.group(1).strip()} {{")
            lines += [f"    {field};" for field in fields]
            lines.append(f"}} {inside.group(3).strip()}")
        else:
            lines.append(" ".join(statement.split()))
    top = "/* Made by generate_cdef.py from capi/diffaqua.h, where everything is explained. */"
    return "\n".join([top, "enum {", *constants, "};", *lines, ""])


def main():
    with open(HEADER, encoding="utf-8") as file:
        wanted = cdef(file.read())
    if sys.argv[1:] == ["--check"]:
        with open(CDEF, encoding="utf-8") as file:
            if file.read() != wanted:
                sys.exit(f"{os.path.basename(CDEF)} is not what the header says: run bindings/generate_cdef.py")
        print(f"{os.path.basename(CDEF)} is current: {wanted.count('(')} functions and types of functions")
    elif len(sys.argv) > 1:
        sys.exit(__doc__.strip())
    else:
        with open(CDEF, "w", encoding="utf-8") as file:
            file.write(wanted)


if __name__ == "__main__":
    main()
