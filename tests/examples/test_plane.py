#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""plane proves its gradient, gains distance, and draws what it found.

test_plane.py PROGRAM"""
import math
import os
import re
import resource
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

PROGRAM = ""
SVG = "{http://www.w3.org/2000/svg}"
ITERATIONS = 30


def run(*arguments):
    return subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, timeout=600, check=False,
                          env={**os.environ, "OPENBLAS_NUM_THREADS": "1"})


class Plane(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="plane-")
        cls.file = os.path.join(cls.folder.name, "swimmer.svg")
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        cls.process = run(cls.file)
        cls.seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def rows(self):
        found = re.findall(r"^ *(\d+) +(\S+) mm +(\S+) % +(\S+) % +(\S+) % +(\S+) +(\S+) +(\S+)$", self.process.stdout,
                           re.MULTILINE)
        return [list(map(float, row)) for row in found]

    def test_runs(self):
        self.assertEqual((self.process.returncode, self.process.stderr), (0, ""))
        # Of the processor, so that other work on the machine does not count.
        self.assertLess(self.seconds, 30.0)

    def test_the_gradient_is_proven(self):
        errors = dict(re.findall(r"gradient of the (\w+): .* relative error (\S+)", self.process.stdout))
        self.assertEqual(set(errors), {"weights", "control"})
        for name, error in errors.items():
            self.assertLessEqual(float(error), 1e-6, name)

    def test_the_loss_falls(self):
        rows = self.rows()
        self.assertEqual([row[0] for row in rows], list(range(1, ITERATIONS + 1)))
        for row in rows:
            self.assertAlmostEqual(sum(row[2:5]), 100.0, delta=0.2)
            self.assertTrue(min(row[2:5]) >= 0.0 and 0.0 <= row[5] <= 1.0 and all(map(math.isfinite, row)))
        travel = [row[1] for row in rows]
        self.assertGreater(travel[0], 0.0, "the first swimmer swims backward")
        self.assertGreater(travel[-1], 2.0 * travel[0])
        said = re.search(r"first (\S+) mm, best (\S+) mm \(iteration (\d+)\)", self.process.stdout)
        self.assertEqual(float(said[1]), travel[0])
        self.assertEqual(float(said[2]), travel[int(said[3]) - 1])
        self.assertEqual(float(said[2]), max(travel))

    def test_the_picture(self):
        root = ElementTree.parse(self.file).getroot()
        self.assertEqual(root.tag, SVG + "svg")
        width, height = float(root.get("width")), float(root.get("height"))
        self.assertIn(f"picture: {self.file}", self.process.stdout)
        with open(self.file, encoding="utf-8") as stream:
            text = stream.read()
        self.assertNotRegex(text, r"nan|inf|href|<image")
        lines = [path for path in root.iter(SVG + "path") if path.get("class") == "line"]
        self.assertEqual(len(lines), 4, "the loss and three shares")
        bodies = [path for path in root.iter(SVG + "path") if path.get("class") == "body"]
        self.assertEqual(len(bodies), 10, "two swimmers at five instants")
        for path in lines + bodies:
            numbers = list(map(float, re.findall(r"-?[\d.]+", path.get("d"))))
            self.assertEqual(len(numbers) % 2, 0)
            self.assertGreaterEqual(len(numbers), 2 * ITERATIONS)
            self.assertTrue(all(0.0 <= x <= width for x in numbers[0::2]))
            self.assertTrue(all(0.0 <= y <= height for y in numbers[1::2]))
        for path in bodies:
            self.assertTrue(path.get("d").startswith("M") and path.get("d").endswith("Z"))

    def test_refusals(self):
        for arguments in (("--fast",), ("a.svg", "b.svg"), ("",)):
            process = run(*arguments)
            self.assertEqual(process.returncode, 2)
            self.assertIn("usage", process.stderr)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit("usage: test_plane.py PROGRAM [unittest arguments]")
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main(verbosity=2)
