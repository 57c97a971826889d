#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Reads the comments of the public header, which are plain C, for those who make pages of them.

    read_header.py --doxygen HEADER              prints the header with doxygen's marks (its INPUT_FILTER)
    read_header.py --manual HEADER VERSION OUT   writes the manual page diffaqua(3)

A comment that stands by itself belongs to what follows it in the next line, one behind code to that line, and one that
nothing follows to its section, which a line of hyphens with a name begins.
"""
import re
import sys

SECTION = re.compile(r"-{10,} *(.+)")
FUNCTIONS, CONSTANTS = set(), set()  # names in the header that is read
STRUCT_SIZE = "Size of this struct as the caller knows it, in bytes: set by its _init function, or given with the call."


def pieces(source):
    """(kind, text) in order: "code", or what a comment is: "file", "section", "free", "before", "behind"."""
    at, first = 0, True
    for match in re.finditer(r"/\*(.*?)\*/", source, flags=re.S):
        if match.start() > at:
            yield "code", source[at:match.start()]
        at = match.end()
        body = match.group(1).strip()
        section = SECTION.fullmatch(body)
        line = source[source.rfind("\n", 0, match.start()) + 1:match.start()]
        after = source[at:].split("\n", 2)
        if first:
            yield "file", body
        elif section:
            yield "section", section.group(1)
        elif line.strip():
            yield "behind", body
        elif not after[0].strip() and len(after) > 1 and (not after[1].strip() or after[1].lstrip().startswith("/*")):
            yield "free", body
        else:
            yield "before", body
        first = False
    yield "code", source[at:]


def lines_of(body):
    """The lines of a comment without its decoration; what stands further in than the text keeps two spaces."""
    found = []
    for number, line in enumerate(body.split("\n")):
        decorated = re.match(r"\s*\* ?", line)
        if number and decorated:
            found.append(line[decorated.end():].rstrip())
        else:
            found.append(line.strip())
    return found


# ---------------------------------------------------------------------------------------------- doxygen
def escape(line):
    """Text that doxygen takes as it stands, with links at the names of functions and constants."""
    line = re.sub(r"([\\@<>&#%*~|])", r"\\\1", line)
    line = re.sub(r"\b(e\.g\.|i\.e\.|et al\.) ", r"\1\\ ", line)  # no end of a sentence
    line = re.sub(r"\b(dqa_\w+)\b(?![(*\\])", lambda name: name.group(1) + ("()" if name.group(1) in FUNCTIONS else ""), line)
    return re.sub(r"\b(DQA_\w+)\b", lambda name: ("#" if name.group(1) in CONSTANTS else "") + name.group(1), line)


def for_doxygen(body, lists=False):
    """The text of a comment; lines that stand further in are formulas, or with `lists` go on with an item."""
    out = []
    for line in lines_of(body):
        if lists:
            out.append(re.sub(r"^ +- (\w+)\.", r"- **\1.**", escape(line)) if line.startswith("  - ") or
                       line.startswith(" - ") else escape(line))
        elif line.startswith("  "):
            out.append(f"@verbatim\n{line}\n@endverbatim")
        else:
            out.append(escape(line.strip()))
    return "\n".join(out)


def doxygen(source):
    out, group = [], ""
    for kind, text in pieces(source):
        if kind == "code":
            # Every growable struct begins so; explained once in the header.
            out.append(re.sub(r"(uint32_t struct_size;)(?!\s*/\*)", rf"\1 /**< {STRUCT_SIZE} */", text))
        elif kind == "file":
            text = text.removeprefix("SPDX-License-Identifier: MIT")
            out.append(f"/** @file\n{for_doxygen(text, lists=True)}\n*/")
        elif kind == "section":
            out.append("/** @} */\n" if group else "")
            group = re.sub(r"\W+", "_", text)
            out.append(f"/** @defgroup {group} {text[0].upper()}{text[1:]}\n@{{ */")
        elif kind == "free":
            out.append(f"/** @}} */\n/** @addtogroup {group}\n{for_doxygen(text)}\n@{{ */")
        else:
            out.append(("/**< " if kind == "behind" else "/** ") + for_doxygen(text) + " */")
    # The last group ends before the braces of C++ do.
    whole = "".join(out)
    at = whole.rfind("#ifdef __cplusplus")
    return whole[:at] + "/** @} */\n" + whole[at:]


# ---------------------------------------------------------------------------------------------- manual page
def roff(text):
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("'", "\\(aq").replace("`", "\\(ga").replace("^", "\\(ha")
    return re.sub(r"^\.", r"\\&.", text.replace("~", "\\(ti"), flags=re.M)


def paragraphs(body):
    """Text with list items and indented lines as troff has them."""
    out = []
    for line in lines_of(body):
        item = re.match(r" *- (\w.*)", line)
        if item:
            out.append(f".IP \\(bu 2\n{roff(item.group(1))}")
        elif line.startswith("  ") and not (out and out[-1].startswith(".IP")):
            out.append(f".br\n{roff(line)}\n.br")
        else:
            out.append(roff(line.strip()) if line.strip() else ".PP")
    return "\n".join(out)


def manual(source, version):
    out = ['.\\" Made by read_header.py from diffaqua.h.', f'.TH DIFFAQUA 3 "" "diffaqua {version}"', ".SH NAME",
           "diffaqua \\- co\\-design of soft swimmers: shape space, simulator, controller, tape, adjoint", ".SH SYNOPSIS",
           ".nf\n.B #include <diffaqua.h>\n.PP\nLink with \\fI\\-ldiffaqua\\fR, or ask \\fBpkg\\-config diffaqua\\fR.\n.fi"]
    code, before, started = "", None, False

    def flush():
        """Prints the declarations so far, and under them the comment that explains them."""
        nonlocal code, before
        text = "\n".join(line for line in code.split("\n") if line.strip())
        if text.startswith("DQA_API "):
            text = re.sub(r"\n {8}", "\n", text.removeprefix("DQA_API "))
        if text:
            out.append(".PP\n.nf\n.ft B\n" + roff(text) + "\n.ft R\n.fi")
        if before is not None:
            out.append((".RS 4\n" if text else ".PP\n") + paragraphs(before) + ("\n.RE" if text else ""))
        code, before = "", None

    for kind, text in pieces(source):
        if kind == "file":
            body = text.removeprefix("SPDX-License-Identifier: MIT").strip(" *\n")
            out += [".SH DESCRIPTION", paragraphs(body)]
        elif kind == "section":
            flush()
            started = True
            out.append(f".SH {roff(text.upper())}")
        elif not started:
            continue  # the preprocessor's part
        elif kind == "code":
            parts = re.split(r"(?<=;)\n(?=\n)|\n(?=\n)", text.split("#ifdef __cplusplus")[0])
            for number, part in enumerate(parts):
                if number:
                    flush()
                code += part
        elif kind == "behind" or re.search(r"\{[^}]*$", code):  # of a constant or a field
            indent = "\n" + " " * (len(code) - code.rfind("\n") + 2)
            code += "/* " + indent.join(line.strip() for line in lines_of(text)) + " */"
        else:
            flush()
            before = text
    flush()
    out += [".SH SEE ALSO", ".BR codesign (1),", ".BR pkg\\-config (1)"]
    return "\n".join(out) + "\n"


def main():
    with open(sys.argv[2], encoding="utf-8") as file:
        source = file.read()
    FUNCTIONS.update(re.findall(r"\bDQA_API\b[^;(]*?\b(\w+)\s*\(", source))
    CONSTANTS.update(re.findall(r"^#define (DQA_\w+) +[-(\d]", source, flags=re.M))
    if sys.argv[1] == "--doxygen":
        sys.stdout.write(doxygen(source))
    else:
        with open(sys.argv[4], "w", encoding="utf-8") as file:
            file.write(manual(source, sys.argv[3]))


if __name__ == "__main__":
    if len(sys.argv) < 3 or sys.argv[1] not in ("--doxygen", "--manual") or (sys.argv[1] == "--manual") != (
            len(sys.argv) == 5):
        sys.exit(__doc__.strip())
    main()
