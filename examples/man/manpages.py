#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Writes the manual pages of the installed programs from what they say of themselves with --help.

    manpages.py FOLDER PROGRAM...            writes the pages of the built programs to FOLDER
    manpages.py --check FOLDER PROGRAM...    fails where a page lacks an option of its program
"""
import os
import re
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
HEADER = os.path.join(HERE, "..", "..", "capi", "diffaqua.h")

# What programs are, in a line; those that are not here are experiments by the name that they have.
SUMMARIES = {
    "codesign": "co-design of a soft swimmer: its shape and controller improve together",
    "open_loop": "experiment: an eel's shape and sine, with baselines",
    "shape_optimization": "experiment: the fastest shape between two animals",
    "shape_exploration": "experiment: the shapes between three animals",
    "pareto": "experiment: swimmers between speed and efficiency",
    "domain_error": "experiment: what leaving faint cells out does to a swimmer",
    "ablations": "experiment: scales of parameters, and random starts",
    "beyond": "experiment: stiffness along the body, and searches against local minima",
    "closed_loop": "experiment: a network that sees the swimmer",
    "position_keeping": "experiment: a swimmer that keeps its place in a current",
    "plane": "co-design of a swimmer in two dimensions, in seconds",
}
# What a program would say if it had a --help.
PLANE = """usage: plane [FILE]

Three fish seen from above, each drawn by a formula, span a space of outlines, and a sine bends the swimmer's tail. Adam
moves the shares of the three and the sine's amplitude, frequency and phase together, for the distance travelled in two
seconds. Before that, finite differences prove the gradient. The loss, the shares, and the first and the best swimmer on
their way are drawn to FILE, an SVG (plane.svg).

Exit codes: 0 done, 1 failure, 2 wrong command line.
"""
SHAPES = """.SH ENVIRONMENT
.TP
.B DQA_SHAPES_DIR
Folder of the shapes to use in place of those that come with the programs.
.SH FILES
.TP
.I ../share/diffaqua/shapes
The shapes that come with the programs, and lists of their muscles; relative to the folder of the program.
"""


def roff(text):
    """Text that troff prints as it stands."""
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("'", "\\(aq").replace("`", "\\(ga")
    return re.sub(r"^\.", r"\\&.", text, flags=re.M)


def options(lines):
    """Two columns as tagged paragraphs; a line that starts further in goes on with the one above."""
    found = []
    for line in lines:
        tag = re.fullmatch(r"  (--\S+(?: \S+)?) +(\S.*)", line)
        if tag:
            found.append([tag.group(1), tag.group(2)])
        else:
            found[-1][1] += " " + line.strip()
    for tag, text in found:
        name, _, value = tag.partition(" ")
        yield f".TP\n.BR {roff(name)}" + (f" \" \\fI{roff(value)}\\fR\"" if value else "") + f"\n{roff(text)}"


def installed_name(program):
    return program if program == "codesign" else "diffaqua-" + program.replace("_", "-")


def page(program, said, version, others):
    name = installed_name(program)
    summary = SUMMARIES.get(program) or "experiment: " + program.replace("_", " ")
    usage, *blocks = said.strip("\n").split("\n\n")
    out = [f'.\\" Made by manpages.py from what the program says with --help.\n.TH {name.upper()} 1 "" "diffaqua {version}"',
           f".SH NAME\n{name} \\- {roff(summary)}", ".SH SYNOPSIS"]
    for line in usage.splitlines():
        words = re.fullmatch(rf"(?:usage:)? *{program}(.*)", line).group(1)
        out.append(f".B {roff(name)}\n{roff(words.strip())}\n.br")
    out[-1] = out[-1].removesuffix("\n.br")
    out.append(".SH DESCRIPTION")
    section, first = "DESCRIPTION", True
    for block in blocks:
        lines = block.splitlines()
        if block.startswith("Exit codes: "):
            out.append(".SH EXIT STATUS")
            for code, text in re.findall(r"(\d+) ([^,]+?)(?:, |\.$)", block.removeprefix("Exit codes: ")):
                out.append(f".TP\n.B {code}\n{roff(text)}")
            continue
        at = next((k for k, line in enumerate(lines) if line.startswith("  --")), None)
        if at is not None:
            out += [".SH OPTIONS", *options(lines[at:])]
            section, first = "OPTIONS", True
        elif section == "OPTIONS":  # what the options refer to with "see below"
            out += [".SH LISTS OF BASES", roff(" ".join(lines))]
            section = "LISTS"
        elif all(line.startswith("  ") for line in lines):
            out += [".PP\n.nf\n.RS", roff(block), ".RE\n.fi"]
        else:
            out += ([] if first and section == "DESCRIPTION" else [".PP"]) + [roff(" ".join(line.strip() for line in lines))]
            first = False
    if program != "plane":
        out.append(SHAPES.strip())
    out += [".SH SEE ALSO", *(f".BR {roff(other)} (1)," for other in others if other != name), ".BR diffaqua (3)"]
    return "\n".join(out) + "\n"


def main():
    arguments = sys.argv[1:]
    check = arguments[:1] == ["--check"]
    if check:
        del arguments[0]
    if len(arguments) < 2 or arguments[0].startswith("-"):
        sys.exit(__doc__.strip())
    folder, *programs = arguments
    with open(HEADER, encoding="utf-8") as file:
        version = ".".join(re.findall(r"^#define DQA_VERSION_\w+ +(\d+)", file.read(), flags=re.M))
    os.makedirs(folder, exist_ok=True)
    names = sorted(installed_name(os.path.basename(program)) for program in programs)
    for path in programs:
        program = os.path.basename(path)
        name = installed_name(program)
        said = PLANE if program == "plane" else subprocess.run([path, "--help"], check=True, capture_output=True,
                                                               text=True).stdout
        path = os.path.join(folder, name + ".1")
        if not check:
            with open(path, "w", encoding="utf-8") as file:
                file.write(page(program, said, version, names))
            continue
        with open(path, encoding="utf-8") as file:
            written = file.read().replace("\\-", "-")
        lacking = set(re.findall(r"--[a-z-]+", said)) - set(re.findall(r"--[a-z-]+", written))
        if lacking or "EXIT STATUS" not in written or len(written) < len(said):
            sys.exit(f"{name}.1 lacks {', '.join(sorted(lacking)) or 'a part of what the program says'}")
    if check:
        print("every manual page says what its program says")


if __name__ == "__main__":
    main()
