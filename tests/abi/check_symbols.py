# SPDX-License-Identifier: MIT
"""The header's functions, the version script and the exported symbols of the library are the same set; and the library
imports nothing that would end the host, print, or change what belongs to it."""
import argparse
import re
import subprocess
import sys

import header

# What the C library has to end a process, to print, and to change settings that are the host's. (std::terminate stays:
# compilers put it behind every noexcept.)
FORBIDDEN = re.compile(r"_?_?exit|_Exit|quick_exit|abort|raise|kill|__assert_fail|v?printf|vf?printf|fprintf|puts|fputs|"
                       r"putchar|fputc|putc|perror|fwrite|__v?f?printf_chk|_ZSt4cout|_ZSt4cerr|_ZSt4clog|signal|sigaction|"
                       r"srand|rand|setlocale|setenv|putenv|chdir|umask|feenableexcept")


def difference(what, expected, found):
    lines = [f"{what}: missing {name}" for name in sorted(expected - found)]
    return lines + [f"{what}: unexpected {name}" for name in sorted(found - expected)]


parser = argparse.ArgumentParser(description=__doc__)
for option in ("--header", "--map", "--library", "--nm"):
    parser.add_argument(option, required=True)
arguments = parser.parse_args()

declared = header.functions(arguments.header)
problems = [f"header: {name} is declared twice" for name in set(declared) if declared.count(name) > 1]
declared = set(declared)
if len(declared) < 10:
    problems.append(f"header: only {len(declared)} functions found; does this script still read it rightly?")
for name in declared:
    if not name.startswith("dqa_"):
        problems.append(f"header: {name} lacks the prefix dqa_")

with open(arguments.map, encoding="utf-8") as file:
    script = re.sub(r"/\*.*?\*/", " ", file.read(), flags=re.S)
nodes = re.findall(r"^(\w+)\s*\{", script, flags=re.M)
listed = set(re.findall(r"\b(dqa_\w+)\s*;", script))
problems += difference("version script", declared, listed)

output = subprocess.run([arguments.nm, "-D", "--defined-only", arguments.library], check=True, text=True,
                        capture_output=True).stdout
exported = set()
for line in output.splitlines():
    name, _, version = line.split()[-1].partition("@")
    if name in nodes:
        continue  # the version node itself
    exported.add(name)
    if name in declared and version.lstrip("@") not in nodes:
        problems.append(f"library: {name} has no version node")
problems += difference("library", declared, exported)

output = subprocess.run([arguments.nm, "-D", "--undefined-only", arguments.library], check=True, text=True,
                        capture_output=True).stdout
imported = {line.split()[-1].partition("@")[0] for line in output.splitlines()}
if len(imported) < 50:
    problems.append(f"library: only {len(imported)} imports found; does this script still read them rightly?")
problems += [f"library: imports {name}, which ends, prints or changes what is the host's"
             for name in sorted(imported) if FORBIDDEN.fullmatch(name)]

print("\n".join(problems) or f"{len(declared)} functions: header, version script and library agree")
sys.exit(1 if problems else 0)
