# SPDX-License-Identifier: MIT
"""Objects compiled for wide instruction sets share no symbol with the rest.

An inline function or template instance that such an object emits is a weak symbol; the linker keeps one copy of it for
the whole library and may well keep the wide one, which then stops with an illegal instruction on older processors.
Kernels therefore put everything but their entry points into an anonymous namespace and call no out-of-line templates.
"""
import argparse
import re
import subprocess
import sys

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--nm", required=True)
parser.add_argument("--archive", required=True)
arguments = parser.parse_args()

output = subprocess.run([arguments.nm, "-C", "--defined-only", arguments.archive], check=True, text=True,
                        capture_output=True).stdout
problems, wide, member = [], 0, ""
for line in output.splitlines():
    if line.endswith(":"):
        member = line[:-1]
        wide += bool(re.search(r"_avx(2|512)\.cpp\.o$", member))
    elif re.search(r"_avx(2|512)\.cpp\.o$", member):
        match = re.match(r"^[0-9a-f]* ([A-Za-z]) (.*)$", line)
        # DW.ref.* only points to the exception personality: data, the same in every object.
        if match and match.group(1) in "WVuwv" and not match.group(2).startswith("DW.ref."):
            problems.append(f"{member}: weak symbol {match.group(2)}")

print("\n".join(problems) or f"{wide} wide objects, none with a weak symbol")
sys.exit(1 if problems else 0)
