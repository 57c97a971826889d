# SPDX-License-Identifier: MIT
"""The examples run and descend, their TensorBoard logs hold what they print, and the README's lines work when
pasted."""
import glob
import os
import re
import struct
import subprocess
import sys
import tempfile
import unittest

ROOT = os.environ["DQA_ROOT"]


def run(*command, **settings):
    done = subprocess.run([sys.executable, *command], capture_output=True, text=True, timeout=600, check=False,
                          **settings)
    if done.returncode:
        raise AssertionError(done.stderr)
    return done.stdout


def scalars(folder):
    """{name: values} of the event file in a folder: records of (length, checksum, event, checksum)."""
    from tensorboardX.proto.event_pb2 import Event
    name, = glob.glob(os.path.join(folder, "events*"))
    found = {}
    with open(name, "rb") as file:
        while head := file.read(12):
            event = Event.FromString(file.read(struct.unpack("<Q", head[:8])[0]))
            file.read(4)
            for value in event.summary.value:
                found.setdefault(value.tag, []).append(value.simple_value)
    return found


class Examples(unittest.TestCase):
    def descends(self, name, *arguments):
        with tempfile.TemporaryDirectory() as folder:
            text = run(os.path.join(ROOT, "bindings", "python", "examples", name), "--tensorboard", folder, *arguments)
            losses = scalars(folder)["loss_m"]
        printed = [float(value) for value in re.findall(r"travels +(-?\d+\.\d+) mm", text)]
        self.assertEqual(len(printed), len(losses))
        for value, loss in zip(printed, losses):
            self.assertAlmostEqual(value, -1e3 * loss, delta=0.006)
        first, best = map(float, re.search(r"first (\S+) mm, best (\S+) mm", text).groups())
        self.assertEqual((first, best), (printed[0], max(printed)))
        self.assertGreater(best, 1.5 * first)

    def test_torch(self):
        self.descends("with_torch.py", "--iterations", "8", "--steps", "20")

    def test_scipy(self):
        self.descends("with_scipy.py", "--iterations", "4", "--steps", "20")

    def test_cma(self):
        self.descends("with_cma.py", "--iterations", "3", "--steps", "16")


class Readme(unittest.TestCase):
    def test_pasted(self):
        for name, lines in (("README.md", 5), (os.path.join("bindings", "python", "README.md"), None)):
            with open(os.path.join(ROOT, name), encoding="utf-8") as file:
                programs = re.findall(r"^```python\n(.*?)^```$", file.read(), re.MULTILINE | re.DOTALL)
            self.assertTrue(programs, name)
            for program in programs:
                text = run("-c", program, cwd=ROOT)
                if lines:
                    self.assertEqual(len(program.splitlines()), lines)
                    self.assertRegex(text, r"-?0\.\d+.*\[.*\].*\[.*\]")


class Progress(unittest.TestCase):
    def test_bar(self):
        import io

        import diffaqua as dq
        import scene
        text = io.StringIO()
        with dq.ProgressBar("swims", file=text, mininterval=0, miniters=1) as bar:
            for _ in range(2):
                scene.swimmer().rollout(dq.Sinusoid(1), 3, progress=bar)
        self.assertIn("swims", text.getvalue())
        self.assertIn("3/3", text.getvalue())


if __name__ == "__main__":
    unittest.main(verbosity=1)
