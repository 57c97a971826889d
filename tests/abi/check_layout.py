# SPDX-License-Identifier: MIT
"""Every field of every public struct has its size and offset asserted, so that none can move unseen."""
import argparse
import re
import sys

import header

parser = argparse.ArgumentParser(description=__doc__)
for option in ("--header", "--asserts"):
    parser.add_argument(option, required=True)
arguments = parser.parse_args()

with open(arguments.asserts, encoding="utf-8") as file:
    asserts = file.read()
sizes = set(re.findall(r"^SIZE\((\w+), *\d+\)", asserts, flags=re.M))
offsets = set(re.findall(r"^AT\((\w+), *(\w+), *\d+\)", asserts, flags=re.M))

structs = header.structs(arguments.header)
fields = {(struct, field) for struct in structs for field in structs[struct]}
problems = [f"no size asserted for {struct}" for struct in sorted(set(structs) - sizes)]
problems += [f"no offset asserted for {struct}.{field}" for struct, field in sorted(fields - offsets)]
problems += [f"{struct} is asserted but not public" for struct in sorted(sizes - set(structs))]
problems += [f"{struct}.{field} is asserted but not public" for struct, field in sorted(offsets - fields)]
if not structs:
    problems.append("no structs found in the header; does this script still read it rightly?")
for struct, names in structs.items():
    if names[0] != "struct_size":
        problems.append(f"{struct} does not begin with struct_size")

print("\n".join(problems) or f"{len(structs)} structs, {len(fields)} fields: all frozen")
sys.exit(1 if problems else 0)
