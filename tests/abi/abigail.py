# SPDX-License-Identifier: MIT
"""The ABI of a library as libabigail reads it from the debug information: dumps, and what differs between two of them.

A dump holds the functions of the public header and the types that they reach, and nothing of the machine that made it.
Growable structs may gain fields at their end, and a field called padding may get a name: libabigail counts both as
changes, so they are recognised here, struct by struct, and only for structs whose other fields are the same in every
respect. Functions may be added. All else that abidiff reports is a break.
"""
import os
import re
import shutil
import subprocess
import tempfile
import xml.etree.ElementTree as ElementTree

TOOLS = ("abidw", "abidiff")


def missing_tool():
    """The first of the tools that is not there, or None."""
    return next((tool for tool in TOOLS if not shutil.which(tool)), None)


def dump(library, headers, path):
    """Writes the ABI of `library`, as far as the public header in the folder `headers` tells it, to `path`."""
    with tempfile.TemporaryDirectory(prefix="abi-") as alone:  # without the internal headers beside it
        shutil.copy(os.path.join(headers, "diffaqua.h"), alone)
        done = subprocess.run(["abidw", "--headers-dir", alone, "--drop-private-types", "--exported-interfaces-only",
                               "--drop-undefined-syms", "--no-show-locs", "--no-corpus-path", "--no-comp-dir-path",
                               "--no-elf-needed", "--type-id-style", "hash", "--out-file", path, library],
                              capture_output=True, text=True, check=False)
    if done.returncode != 0 or not os.path.exists(path):
        raise RuntimeError(f"abidw failed on {library} ({done.returncode}): {done.stdout}{done.stderr}")
    with open(path, encoding="utf-8") as file:
        text = file.read()
    # The folder of the sources, which says nothing about the ABI.
    text = re.sub(r"(<abi-instr [^>]*?path=')[^']*?([^/']+')", r"\1\2", text)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    if "<function-decl name='dqa_version'" not in text or "dqa_tape_options" not in Types(path).structs():
        raise RuntimeError(f"the debug information of {library} does not tell its functions and structs")


def soname(path):
    """SONAME of the library of a dump."""
    return ElementTree.parse(path).getroot().get("soname")


class Types:
    """The types of a dump by their ids."""

    def __init__(self, path):
        self.root = ElementTree.parse(path).getroot()
        self.by_id = {node.get("id"): node for node in self.root.iter() if node.get("id")}

    def functions(self):
        """{name: types of what it returns and of its parameters, structs by their names alone}."""
        return {node.get("name"): [self.spell(part.get("type-id"), (), structs=False)
                                   for part in [*node.findall("return"), *node.findall("parameter")]]
                for node in self.root.iter("function-decl")}

    def structs(self):
        """{name: [(field, offset in bits, type spelled out), ...]} of the structs with a body."""
        found = {}
        for node in self.by_id.values():
            if node.tag == "class-decl" and not node.get("is-declaration-only"):
                fields = found.setdefault(node.get("name"), [])
                for member in node.findall("data-member"):
                    variable = member.find("var-decl")
                    fields.append((variable.get("name"), int(member.get("layout-offset-in-bits")),
                                   self.spell(variable.get("type-id"), ())))
        return found

    def spell(self, identifier, above, structs=True):
        """A type with all that it is made of; a type within itself is named only, and so are structs unless wanted."""
        node = self.by_id[identifier]
        own = " ".join(f"{key}={node.get(key)}" for key in ("name", "size-in-bits", "length", "const") if node.get(key))
        if identifier in above or (node.tag == "class-decl" and not structs):
            return f"({node.tag} {node.get('name')})"
        below = [child for child in node.iter() if child is not node and child.get("type-id")]
        parts = [self.spell(child.get("type-id"), above + (identifier,), structs) for child in below]
        if node.get("type-id"):
            parts.insert(0, self.spell(node.get("type-id"), above + (identifier,), structs))
        return f"({node.tag} {own} {' '.join(parts)})"


def compare(old, new):
    """(Names of the structs whose only change is one that growable structs may make, lines on what abidiff is silent
    about: renamed fields, and parameters that point to const no longer, or only now. They keep the ABI, but programs do
    not compile as they did.)"""
    old, new = Types(old), Types(new)
    before, after, signatures = old.structs(), new.structs(), new.functions()
    grown, silent = [], []
    for name, types in old.functions().items():
        if signatures.get(name, types) != types:
            silent.append(f"{name} has other types")
    for name, fields in before.items():
        pairs = list(zip(fields, after.get(name, [])))
        silent += [f"{name}.{was[0]} is now called {now[0]}" for was, now in pairs
                   if was[1:] == now[1:] and was[0] not in (now[0], "padding")]
        if (name in after and after[name] != fields and len(pairs) == len(fields) and fields[0][0] == "struct_size"
                and all(was[1:] == now[1:] and was[0] in (now[0], "padding") for was, now in pairs)):
            grown.append(name)
    return grown, silent


def breaks(old, new):
    """What a program built against `old` would stumble over in `new`: the report of abidiff, "" when nothing."""
    grown, silent = compare(old, new)
    with tempfile.NamedTemporaryFile("w", suffix=".suppressions", encoding="utf-8") as rules:
        for name in grown:
            rules.write(f"[suppress_type]\n  type_kind = struct\n  name = {name}\n")
        rules.flush()
        done = subprocess.run(["abidiff", "--suppressions", rules.name, "--no-added-syms", old, new],
                              capture_output=True, text=True, check=False)
    if done.returncode & 3:  # an error of the tool or of its command line
        raise RuntimeError(f"abidiff failed ({done.returncode}): {done.stdout}{done.stderr}")
    return (done.stdout if done.returncode else "") + "\n".join(silent)
