# SPDX-License-Identifier: MIT
"""Every function, struct, struct field, type and macro of the public header has a comment of its own: right before it,
or behind it on the same line (or on the lines that continue that comment)."""
import re
import sys

NEEDS_NONE = {"DIFFAQUA_H"}  # the include guard


def declarations(source):
    """(line number, kind and name, whether documented) of everything public in the text of a header."""
    lines = source.split("\n")
    documented_by = set()  # numbers of lines that follow a comment standing by itself
    comment_at = set()     # numbers of lines with a comment behind code
    code = list(lines)
    inside, alone = False, False
    for number, line in enumerate(lines):
        rest, kept = line, ""
        touched = inside
        while rest:
            if inside:
                before, end, rest = rest.partition("*/")
                inside = not end
                if end and alone and not rest.strip():
                    documented_by.add(number + 1)
            else:
                before, start, rest = rest.partition("/*")
                kept += before
                if start:
                    inside, touched = True, True
                    alone = not kept.strip()
                    if not alone:
                        comment_at.add(number)
        code[number] = kept if not (touched and not kept.strip()) else ""
    struct, number = None, 0
    while number < len(code):
        first, text = number, code[number].strip()
        number += 1
        if not text or text.startswith(('extern "C"', "}")) and struct is None:
            continue
        good = first in documented_by
        if text.startswith("#"):
            found = re.match(r"#\s*define\s+(\w+)", text)
            if found and found.group(1) not in NEEDS_NONE:
                yield first + 1, f"macro {found.group(1)}", good or first in comment_at
            continue
        if struct is None and re.match(r"typedef\s+struct\s+\w+\s*\{$", text):
            struct = re.match(r"typedef\s+struct\s+(\w+)", text).group(1)
            yield first + 1, f"struct {struct}", good
            continue
        if struct is not None and text.startswith("}"):
            struct = None
            continue
        while ";" not in text:
            text += " " + code[number].strip()
            number += 1
        good = good or any(k in comment_at for k in range(first, number))
        if struct is not None:
            if not text.startswith("uint32_t struct_size"):  # explained once, in the conventions
                name = re.search(r"(\w+)\s*(?:\[\w+\])*\s*;", text).group(1)
                yield first + 1, f"field {struct}.{name}", good
        elif "DQA_API" in text:
            name = re.search(r"(\w+)\s*\(", text.replace("DQA_API", "")).group(1)
            yield first + 1, f"function {name}", good
        elif text.startswith("typedef"):
            name = re.search(r"\(\s*\*\s*(\w+)\s*\)", text) or re.search(r"(\w+)\s*;", text)
            yield first + 1, f"type {name.group(1)}", good
        else:
            yield first + 1, f"unexpected text {text!r}", False


def check(path):
    with open(path, encoding="utf-8") as file:
        found = list(declarations(file.read()))
    for line, what, good in found:
        if not good:
            yield f"{path}:{line}: no comment for {what}"
    if len(found) < 100:
        yield f"only {len(found)} declarations found; does this script still read the header rightly?"


def self_test():
    """Each of these lacks exactly the comments named, in order."""
    cases = [("#define A 1\n", ["macro A"]), ("#define A 1 /* one */\n", []), ("/* one */\n#define A 1\n", []),
             ("/* group */\n#define A 1\n#define B 2\n", ["macro B"]),
             ("/* far */\n\nDQA_API int f(int a,\n              int b);\n", ["function f"]),
             ("/* near */\nDQA_API int f(int a,\n              int b);\nDQA_API int g(void);\n", ["function g"]),
             ("/* s */\ntypedef struct s {\n    uint32_t struct_size;\n    int a; /* a,\n  still a */\n    int b[3];\n"
              "    /* c */\n    int c;\n} s;\n", ["field s.b"]),
             ("typedef struct s {\n    int a; /* a */\n} s;\ntypedef struct t t;\n", ["struct s", "type t"]),
             ("typedef int (*f)(int a, void *b);\n/* g */\ntypedef int (*g)(int a);\n", ["type f"]),
             ("int stray;\n", ["unexpected text 'int stray;'"])]
    for source, expected in cases:
        got = [what for _, what, good in declarations(source) if not good]
        if got != expected:
            yield f"{source!r}: {got}, expected {expected}"


if __name__ == "__main__":
    problems = list(self_test() if sys.argv[1] == "--self-test" else check(sys.argv[1]))
    print("\n".join(problems) or "every declaration has its comment")
    sys.exit(1 if problems else 0)
