# SPDX-License-Identifier: MIT
"""Reads functions and structs out of the public header, which is plain enough for regular expressions."""
import re


def text(path):
    """The header without comments and preprocessor lines."""
    with open(path, encoding="utf-8") as file:
        source = re.sub(r"/\*.*?\*/", " ", file.read(), flags=re.S)
    return re.sub(r"^[ \t]*#.*$", "", source, flags=re.M)


def functions(path):
    """Names of the functions declared with DQA_API, in the order of the header."""
    return re.findall(r"\bDQA_API\b[^;(]*?\b(\w+)\s*\(", text(path))


def structs(path):
    """{struct: [field, ...]} of every public struct with a body."""
    found = {}
    for name, body in re.findall(r"typedef\s+struct\s+(\w+)\s*\{(.*?)\}\s*\1\s*;", text(path), flags=re.S):
        fields = [line.strip() for line in body.split(";") if line.strip()]
        found[name] = [re.search(r"(\w+)\s*(\[\w+\])*$", field).group(1) for field in fields]
    return found


def constants(path, versions=False):
    """{name: value} of the header's whole numbers; of its versions, which are meant to change, where asked for."""
    with open(path, encoding="utf-8") as file:
        found = re.findall(r"^#define (DQA_\w+) +\(?(-?\d+)\)?", file.read(), flags=re.M)
    changing = ("DQA_VERSION_MAJOR", "DQA_VERSION_MINOR", "DQA_VERSION_PATCH", "DQA_ABI_VERSION")
    return {name: int(value) for name, value in found if versions or name not in changing}
