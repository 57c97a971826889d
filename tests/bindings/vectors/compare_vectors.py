#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Two files of test vectors say the same: the same entries and texts, and numbers that differ by no more than a tolerance
relative to the largest number of their array.

    compare_vectors.py WRITTEN COMMITTED [TOLERANCE]      default tolerance 1e-12
"""
import json
import math
import sys


def is_numbers(value):
    return isinstance(value, list) and all(isinstance(entry, (int, float)) for entry in value)


def difference(found, expected, path=""):
    """(largest relative difference, where); raises ValueError where the files have other entries or texts."""
    if isinstance(expected, (int, float)) and isinstance(found, (int, float)):
        found, expected = [found], [expected]
    if is_numbers(expected) and is_numbers(found):
        if len(found) != len(expected):
            raise ValueError(f"{path}: {len(found)} numbers, expected {len(expected)}")
        if not all(map(math.isfinite, found)):
            raise ValueError(f"{path}: not finite")
        scale = max(map(abs, expected), default=0.0) or 1.0
        return max((abs(f - e) / scale for f, e in zip(found, expected)), default=0.0), path
    if isinstance(expected, dict) and isinstance(found, dict):
        if found.keys() != expected.keys():
            raise ValueError(f"{path}: entries {sorted(found)}, expected {sorted(expected)}")
        pairs = [(found[name], expected[name], f"{path}/{name}") for name in expected]
    elif isinstance(expected, list) and isinstance(found, list) and len(found) == len(expected):
        pairs = [(f, e, f"{path}/{index}") for index, (f, e) in enumerate(zip(found, expected))]
    elif found == expected:
        return 0.0, path
    else:
        raise ValueError(f"{path}: {found!r}, expected {expected!r}")
    return max((difference(*pair) for pair in pairs), default=(0.0, path))


def main():
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__.strip())
    files = []
    for name in sys.argv[1:3]:
        with open(name, encoding="utf-8") as file:
            files.append(json.load(file))
    tolerance = float(sys.argv[3]) if len(sys.argv) == 4 else 1e-12
    try:
        worst, where = difference(*files)
    except ValueError as error:
        sys.exit(f"the vectors differ: {error}")
    print(f"largest relative difference {worst:.1e} at {where}, tolerance {tolerance:.0e}")
    sys.exit(0 if worst <= tolerance else 1)


if __name__ == "__main__":
    main()
