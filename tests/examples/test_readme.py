#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""README.md tells the truth: its program compiles, runs and descends; its files and options exist.

test_readme.py ROOT COMPILER LIBRARY CODESIGN"""
import os
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = COMPILER = LIBRARY = CODESIGN = ""


def readme():
    with open(os.path.join(ROOT, "README.md"), encoding="utf-8") as stream:
        return stream.read()


def run(*command):
    return subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)


class Readme(unittest.TestCase):
    def test_program(self):
        programs = re.findall(r"^```c\n(.*?)^```$", readme(), re.MULTILINE | re.DOTALL)
        self.assertEqual(len(programs), 1)
        with tempfile.TemporaryDirectory(prefix="readme-") as folder:
            source, program = os.path.join(folder, "main.c"), os.path.join(folder, "main")
            with open(source, "w", encoding="utf-8") as stream:
                stream.write(programs[0])
            done = run(COMPILER, "-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Werror",
                       "-I" + os.path.join(ROOT, "capi"), source, LIBRARY,
                       "-Wl,-rpath," + os.path.dirname(os.path.abspath(LIBRARY)), "-o", program)
            self.assertEqual(done.returncode, 0, done.stderr)
            shapes = os.path.join(ROOT, "examples", "shapes")
            eel, tuna = (os.path.join(shapes, name + ".stl") for name in ("eel_vertical", "tuna"))
            done = run(program, eel, tuna)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            rows = [list(map(float, re.findall(r"-?\d+\.\d+", line))) for line in done.stdout.splitlines()]
            self.assertEqual([len(row) for row in rows], [5, 5, 5])
            for row in rows:
                self.assertAlmostEqual(row[0] + row[1], 1.0, delta=2e-3)
            self.assertLess(rows[-1][2], rows[0][2], "the loss does not fall")
            self.assertEqual(run(program).returncode, 2)
            done = run(program, eel, os.path.join(folder, "missing.stl"))
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, "DQA_ERROR_IO: .*missing.stl")

    def test_options(self):
        told = set(re.findall(r"--[a-z][a-z-]+", run(CODESIGN, "--help").stdout))
        section = readme().split("**`codesign`**")[1].split("**`plane`**")[0]
        self.assertEqual(set(re.findall(r"--[a-z][a-z-]+", section)), told)

    def test_links(self):
        for name in re.findall(r"\]\(([^)#:]+)\)", readme()):
            self.assertTrue(os.path.exists(os.path.join(ROOT, name)), name)


if __name__ == "__main__":
    if len(sys.argv) < 5:
        sys.exit("usage: test_readme.py ROOT COMPILER LIBRARY CODESIGN [unittest arguments]")
    ROOT, COMPILER, LIBRARY, CODESIGN = (sys.argv.pop(1) for _ in range(4))
    unittest.main(verbosity=2)
