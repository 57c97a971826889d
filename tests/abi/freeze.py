#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Freezes the ABI of today in frozen/: the dump of the library, named after its SONAME, and the header, named after its
version and without comments.

    freeze.py BUILD     BUILD is a build folder in which the target diffaqua_abi has been built

As long as CHANGELOG.md calls the version of the header unreleased, both may follow any change. What has been released
stays: its header is never written again, and its dump only where nothing that it promised is broken (new functions and
fields then are promised too).
"""
import os
import re
import sys
import tempfile

import abigail
import check_abidiff
import header

ROOT = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
HEADERS = os.path.join(ROOT, "capi")


def without_comments(path, version):
    with open(path, encoding="utf-8") as file:
        text = re.sub(r"/\*.*?\*/", "", file.read(), flags=re.S)
    text = "\n".join(line.rstrip() for line in text.splitlines())
    text = re.sub(r"\n{3,}", "\n\n", text).strip()
    return (f"/* SPDX-License-Identifier: MIT\n * The header of version {version} without its comments, made by freeze.py: "
            f"never edited by hand. */\n{text}\n")


def is_unreleased(version):
    with open(os.path.join(ROOT, "CHANGELOG.md"), encoding="utf-8") as file:
        heading = re.search(rf"^## {re.escape(version)}\b(.*)$", file.read(), flags=re.M)
    if not heading:
        sys.exit(f"CHANGELOG.md has no heading for version {version}")
    return "unreleased" in heading.group(1)


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__.strip())
    tool = abigail.missing_tool()
    if tool:
        sys.exit(f"no {tool} (Debian: abigail-tools)")
    public = os.path.join(HEADERS, "diffaqua.h")
    numbers = header.constants(public, versions=True)
    version = ".".join(str(numbers[f"DQA_VERSION_{part}"]) for part in ("MAJOR", "MINOR", "PATCH"))
    unreleased = is_unreleased(version)
    frozen_header = os.path.join(check_abidiff.FROZEN, "diffaqua-" + version.rpartition(".")[0] + ".h")
    with tempfile.TemporaryDirectory(prefix="abi-") as folder:
        now = os.path.join(folder, "now.abi")
        abigail.dump(os.path.join(sys.argv[1], "tests", "libdiffaqua_abi.so"), HEADERS, now)
        frozen = os.path.join(check_abidiff.FROZEN, abigail.soname(now) + ".abi")
        if os.path.exists(frozen) and not unreleased:
            problems = abigail.breaks(frozen, now)
            if problems:
                sys.exit(f"{problems}\n{version} is released: what its ABI promised may not change without another "
                         "DQA_ABI_VERSION")
        with open(now, encoding="utf-8") as source, open(frozen, "w", encoding="utf-8") as target:
            target.write(source.read())
    print("wrote", os.path.relpath(frozen))
    if unreleased or not os.path.exists(frozen_header):
        with open(frozen_header, "w", encoding="utf-8") as file:
            file.write(without_comments(public, version))
        print("wrote", os.path.relpath(frozen_header))


if __name__ == "__main__":
    main()
