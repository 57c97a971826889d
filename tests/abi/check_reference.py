# SPDX-License-Identifier: MIT
"""The reference says what it should: its example descends, and every function, struct, field and constant of the header
is on a page for the browser and in the manual page, in readable text.

    check_reference.py --example PROGRAM
    check_reference.py --header HEADER --pages FOLDER
"""
import argparse
import glob
import html
import os
import re
import subprocess
import sys

import header


def check_example(program):
    done = subprocess.run([program], capture_output=True, text=True, check=False, timeout=200)
    losses = [float(loss) for loss in re.findall(r"loss (-?\d+\.\d+) m", done.stdout)]
    if done.returncode != 0 or done.stderr:
        yield f"the example ends with {done.returncode}: {done.stderr}"
    if len(losses) != 3 or not losses[0] > losses[1] > losses[2]:
        yield f"the example does not descend: {losses}"


def check_pages(path, folder):
    pages = ""
    for name in glob.glob(os.path.join(folder, "html", "*.html")):
        with open(name, encoding="utf-8") as file:
            pages += re.sub(r"<[^>]*>", "", file.read())
    with open(os.path.join(folder, "diffaqua.3"), encoding="utf-8") as file:
        manual = file.read()
    functions, structs = header.functions(path), header.structs(path)
    names = {*functions, *structs, *header.constants(path), *(field for struct in structs.values() for field in struct)}
    for what, text in (("the HTML", html.unescape(pages)), ("the manual page", manual)):
        words = set(re.findall(r"\w+", text))
        for name in sorted(names - words):
            yield f"{what} lacks {name}"
    for mark in re.findall(r"[@\\](?:defgroup|addtogroup|verbatim|endverbatim|file|ref|include)\b|&(?:#\d+|\w+);",
                           html.unescape(pages)):
        yield f"a mark was left in the HTML: {mark}"
    if len(functions) < 90 or not names:
        yield "few names were found in the header; does this script still read it rightly?"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for option in ("--example", "--header", "--pages"):
        parser.add_argument(option)
    arguments = parser.parse_args()
    problems = list(check_example(arguments.example) if arguments.example else
                    check_pages(arguments.header, arguments.pages))
    print("\n".join(problems) or "the reference is whole")
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
