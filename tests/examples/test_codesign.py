#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The main job from end to end: test_codesign.py PROGRAM runs codesign on the shipped shapes and reads every file."""
import math
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import results

PROGRAM = ""
SMALL = ["--grid", "24x10x12", "--steps", "10", "--iterations", "4"]


class Scratch(unittest.TestCase):
    """A folder of its own for each class."""

    @classmethod
    def setUpClass(cls):
        cls.root = tempfile.mkdtemp(prefix="codesign-")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.root, ignore_errors=True)

    def path(self, *parts):
        return os.path.join(self.root, *parts)

    def codesign(self, *arguments, **keywords):
        return results.run(PROGRAM, *arguments, **keywords)

    def assert_nothing_half_written(self, folder=None):
        for where, _, names in os.walk(folder or self.root):
            for name in names:
                self.assertFalse(name.endswith(".part"), os.path.join(where, name))


class Quick(Scratch):
    """What a --quick run on the shipped shapes leaves behind."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.out = os.path.join(cls.root, "out")
        started = time.monotonic()
        cls.process = results.run(PROGRAM, "--quick", "--out", cls.out)
        cls.seconds = time.monotonic() - started

    def test_ends_well_and_names_its_files(self):
        self.assertEqual(self.process.returncode, 0, self.process.stderr)
        for name in ("codesign.png", "history.csv", "summary.json", "swimmer.pvd", "design.stl", "controller.dqa",
                     "checkpoint.txt"):
            self.assertIn(os.path.join(self.out, name), self.process.stdout)
            self.assertGreater(os.path.getsize(os.path.join(self.out, name)), 0)
        self.assert_nothing_half_written()

    def test_says_a_line_per_iteration_when_stderr_is_no_terminal(self):
        lines = [line for line in self.process.stderr.splitlines() if line.startswith("iteration ")]
        self.assertEqual(len(lines), len(results.read_history(self.out)[1]))
        self.assertNotIn("\r", self.process.stderr)

    def test_history(self):
        names, rows = results.read_history(self.out)
        bases = results.read_summary(self.out)["bases"]
        self.assertEqual(names, ["iteration", "loss", *("weight_" + base for base in bases), "a", "omega", "phi",
                                 "grad_norm_weights", "grad_norm_control", "seconds", "cpu_seconds",
                                 "newton_iterations", "linear_iterations", "adjoint_iterations", "stage", "simulations"])
        spent = [float(row[names.index("cpu_seconds")]) for row in rows]
        self.assertEqual(spent, sorted(spent))
        self.assertEqual({row[names.index("stage")] for row in rows}, {"1"})
        self.assertEqual([int(row[0]) for row in rows], list(range(1, len(rows) + 1)))
        for row in rows:
            weights = [float(text) for text in row[2:2 + len(bases)]]
            self.assertTrue(all(math.isfinite(float(text)) for text in row))
            self.assertAlmostEqual(sum(weights), 1.0, delta=1e-9)
            self.assertGreaterEqual(min(weights), 0.0)
            self.assertTrue(0.0 <= float(row[names.index("a")]) <= 1.0)
        self.assertGreater(float(rows[0][names.index("grad_norm_weights")]), 0.0)
        self.assertGreater(float(rows[0][names.index("grad_norm_control")]), 0.0)

    def test_summary(self):
        summary = results.read_summary(self.out)
        names, rows = results.read_history(self.out)
        losses = [float(row[1]) for row in rows]
        self.assertEqual(summary["loss_first"], losses[0])
        self.assertEqual(summary["loss_last"], losses[-1])
        self.assertEqual(summary["loss_best"], min(losses))
        self.assertEqual(summary["iterations"], len(rows))
        self.assertLess(summary["loss_best"], summary["loss_first"], "nothing was gained")
        best = rows[losses.index(min(losses))]
        self.assertEqual(summary["weights"], [float(text) for text in best[2:2 + len(summary["weights"])]])
        self.assertEqual(summary["settings"]["grid"], [28, 10, 14])
        self.assertGreater(summary["cells"]["active"], summary["cells"]["body"])

    def test_the_gradient_is_proven(self):
        check = results.read_summary(self.out)["gradient_check"]
        for name in ("weights", "control"):
            self.assertLessEqual(check[name]["relative_error"], 1e-6, name)
            self.assertGreater(check[name]["gradient_norm"], 0.0, name)
            self.assertNotEqual(check[name]["finite_difference"], 0.0, name)

    def test_frames(self):
        frames = results.read_pvd(os.path.join(self.out, "swimmer.pvd"))
        steps = results.read_summary(self.out)["settings"]["steps"]
        self.assertEqual(len(frames), steps + 1)
        self.assertEqual(sorted(os.listdir(os.path.join(self.out, "frames"))),
                         [os.path.basename(path) for _, path in frames])
        rest = results.read_vtu(frames[0][1])
        self.assertEqual(set(rest["displacement"]), {0.0})
        for (before, _), (after, _) in zip(frames, frames[1:]):
            self.assertAlmostEqual(after - before, 1.0 / 30.0, delta=1e-6)
        for _, path in frames[1:]:
            now = results.read_vtu(path)
            self.assertEqual(now["connectivity"], rest["connectivity"])
            for x, x0, u in zip(now["Points"], rest["Points"], now["displacement"]):
                self.assertAlmostEqual(x - x0, u, delta=1e-6)
        self.assertGreater(max(map(abs, now["displacement"])), 1e-4, "the swimmer does not move")
        self.assertGreater(max(map(abs, now["velocity"])), 1e-3)

    def test_design(self):
        triangles = results.read_stl(os.path.join(self.out, "design.stl"))
        rest = results.read_vtu(os.path.join(self.out, "frames", "swimmer_0000.vtu"))
        self.assertEqual(3 * len(triangles), len(rest["connectivity"]))
        first = rest["connectivity"][0]
        self.assertEqual(triangles[0][0], rest["Points"][3 * first:3 * first + 3])
        xs = [corner[0] for triangle in triangles for corner in triangle]
        self.assertTrue(0.3 < max(xs) - min(xs) < 1.5, "about a metre long")

    def test_picture(self):
        width, height, rows = results.read_png(os.path.join(self.out, "codesign.png"))
        self.assertGreaterEqual(width, 1200)
        self.assertGreaterEqual(height, 900)
        background = rows[0][0]
        # Curves on top, a swimmer in each half below: ink in every part, and shades of more than a few colours.
        for top, bottom, left, right in ((0.0, 0.3, 0.0, 0.5), (0.0, 0.3, 0.5, 1.0),
                                         (0.5, 1.0, 0.0, 0.5), (0.5, 1.0, 0.5, 1.0)):
            part = [pixel for row in rows[int(top * height):int(bottom * height)]
                    for pixel in row[int(left * width):int(right * width)]]
            ink = sum(pixel != background for pixel in part) / len(part)
            self.assertGreater(ink, 0.02 if top == 0.0 else 0.05)
            self.assertLess(ink, 0.8)
        self.assertGreater(len({pixel for row in rows[height // 2:] for pixel in row}), 100)

    def test_ends_within_a_minute(self):
        if os.environ.get("DQA_TEST_TIMING") != "1":
            self.skipTest("set DQA_TEST_TIMING=1 on a machine that does nothing else")
        self.assertLess(self.seconds, 60.0)


class Resume(Scratch):
    """An interrupted run goes on bit for bit."""

    MORE = ()

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.reference = os.path.join(cls.root, "reference")
        cls.process = results.run(PROGRAM, *SMALL, *cls.MORE, "--out", cls.reference)

    def interrupt(self, out, number, after):
        """Starts a run and sends it the signal once `after` iterations are on disk; the finished process."""
        with subprocess.Popen([PROGRAM, *SMALL, *self.MORE, "--out", out], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                              text=True) as process:
            seen, lines = 0, []
            while seen < after:
                line = process.stderr.readline()
                self.assertTrue(line, "ended too early: " + "".join(lines))
                lines.append(line)
                seen += line.startswith("iteration ")
            time.sleep(0.02)
            process.send_signal(number)
            lines.append(process.communicate(timeout=60)[1])
        return process.returncode, "".join(lines)

    def assert_same_as_reference(self, out):
        self.assertEqual(results.history_without_seconds(out), results.history_without_seconds(self.reference))
        for name in ("design.stl", "swimmer.pvd", "frames/swimmer_0010.vtu"):
            with open(os.path.join(out, name), "rb") as a, open(os.path.join(self.reference, name), "rb") as b:
                self.assertEqual(a.read(), b.read(), name)
        self.assert_nothing_half_written(out)

    def resume(self, out, *more):
        process = self.codesign(*SMALL, *self.MORE, "--resume", "--out", out, *more)
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertIn("continuing after iteration", process.stderr)

    def test_the_same_settings_give_the_same_bits_on_other_thread_counts(self):
        out = self.path("threads")
        self.assertEqual(self.process.returncode, 0, self.process.stderr)
        self.assertEqual(self.codesign(*SMALL, *self.MORE, "--threads", 3, "--out", out).returncode, 0)
        self.assert_same_as_reference(out)

    def test_ctrl_c(self):
        for number, after in ((signal.SIGINT, 1), (signal.SIGTERM, 2)):
            with self.subTest(signal=number):
                out = self.path(f"signal-{int(number)}")
                code, said = self.interrupt(out, number, after)
                self.assertEqual(code, 130, said)
                self.assertRegex(said, r"continue with: .*--resume")
                self.assertFalse(os.path.exists(os.path.join(out, "summary.json")))
                self.assert_nothing_half_written(out)
                self.resume(out)
                self.assert_same_as_reference(out)

    def test_kill(self):
        out = self.path("killed")
        code, _ = self.interrupt(out, signal.SIGKILL, 2)
        self.assertEqual(code, -signal.SIGKILL)
        self.resume(out)
        self.assert_same_as_reference(out)

    def test_more_iterations(self):
        out = self.path("longer")
        self.assertEqual(self.codesign(*SMALL, *self.MORE, "--iterations", 2, "--out", out).returncode, 0)
        self.resume(out)
        self.assert_same_as_reference(out)

    def test_a_finished_run_resumes_to_itself(self):
        out = self.path("finished")
        shutil.copytree(self.reference, out)
        self.resume(out)
        self.assert_same_as_reference(out)

    def test_refuses_a_checkpoint_of_other_settings(self):
        before = results.history_without_seconds(self.reference)
        for more, word in ((["--steps", "11"], "steps"), (["--grid", "26x10x12"], "grid"),
                           (["--fixed-control"], "control"), (["--sigma", "1"], "sigma"),
                           (["--refinement", "2"], "refinement"),
                           (["--threshold", "0.1"], "threshold"), (["--model-error", "0.1"], "model-error"),
                           (["--weights", "0.4,0.2,0.2,0.2"], "weight")):
            process = self.codesign(*SMALL, *self.MORE, "--resume", "--out", self.reference, *more)
            self.assertEqual(process.returncode, 2, process.stderr)
            self.assertIn(word, process.stderr)
        self.assertEqual(results.history_without_seconds(self.reference), before)

    def test_refuses_a_damaged_checkpoint(self):
        with open(os.path.join(self.reference, "checkpoint.txt"), "rb") as stream:
            whole = stream.read()
        middle = len(whole) // 2
        for content in (whole[:middle], whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1:], b""):
            out = self.path("damaged")
            os.makedirs(out, exist_ok=True)
            with open(os.path.join(out, "checkpoint.txt"), "wb") as stream:
                stream.write(content)
            process = self.codesign(*SMALL, *self.MORE, "--resume", "--out", out)
            self.assertEqual(process.returncode, 1, process.stderr)
            self.assertIn("damaged", process.stderr)

    def test_refuses_a_forged_checkpoint(self):
        """A checksum proves nothing about who wrote it: every field is checked, and named."""
        with open(os.path.join(self.reference, "checkpoint.txt"), "rb") as stream:
            text = stream.read()
        text = text[:text.rindex(b"checksum")]
        last = text[text.rindex(b"\nrow "):]
        forged = [
            (rb"\niteration \d+", b"\niteration 99999999", "checkpoint's row 5: the next word"),
            (rb"\niteration \d+", b"\niteration -1", "iteration is \"-1\", expected a whole number of 0"),
            (rb"\niteration \d+", b"\niteration 99999999999999999999", "iteration is \"99999999999999999999\""),
            (rb" best \d+", b" best 5", "best is \"5\", expected a whole number of 0 ... 4"),
            (rb" best \d+", b" best 0", "best is \"0\", expected an iteration of the last stage"),
            (rb" stage \d+", b" stage 7", "stage is \"7\", expected a whole number of 0 ... "),
            (rb" stage \d+", b" stage -1", "stage is \"-1\""),
            (rb" from \d+", b" from 5", "the first iteration of the stage is \"5\""),
            (rb"\nseconds \S+", b"\nseconds -0x1p+3", "seconds is \"-0x1p\\+3\", expected a number >= 0"),
            (rb"\ncpu-seconds \S+", b"\ncpu-seconds nan", "cpu-seconds is \"nan\""),
            (rb"\nbest-loss \S+", b"\nbest-loss -0x1p+9", "best is \"\\d\", expected the iteration whose loss"),
            (rb"\nx \S+", b"\nx 0x1p+9", "x is \".*\", expected weights that sum to one"),
            (rb"\nx \S+", b"\nx inf", "x is \"inf\""),
            (rb"\nfirst-moment \S+", b"\nfirst-moment inf", "first-moment is \"inf\", expected a finite number"),
            (rb"\nsecond-moment \S+", b"\nsecond-moment -0x1p-3", "second-moment is \"-0x1p-3\""),
            (rb"\nbest-x \S+", b"\nbest-x 0x1.1p-2", "best is "),
            (rb"\ngradient \S+", b"\ngradient -inf", "gradient is \"-inf\""),
            (rb"\nproof-weights \d", b"\nproof-weights 3", "proof-weights is \"3\", expected a whole number of 0 ... 2"),
            (rb"\nrow 1 ", b"\nrow 2 ", "checkpoint's row 1: the iteration is \"2\""),
            (rb"\nrow 1 0 \d+", b"\nrow 1 0 -4", "checkpoint's row 1: simulations is \"-4\""),
            (rb"\nrow 1 0 ", b"\nrow 1 9 ", "checkpoint's row 1: the stage is \"9\""),
            (rb"\nterms \S+", b"\nterms nan", "checkpoint's row 1: terms is \"nan\""),
            (rb"\nat \S+", b"\nat -0x1p-9", "checkpoint's row 1: at is"),
            (re.escape(last), b"\n", "checkpoint's row 4: the next word"),
            (re.escape(last), last + last[1:], "what follows the rows"),
        ]
        out = self.path("forged")
        os.makedirs(out, exist_ok=True)
        for pattern, replacement, expected in forged:
            content, count = re.subn(pattern, lambda _: replacement, text, count=1)
            self.assertEqual(count, 1, pattern)
            checksum = 0xcbf29ce484222325
            for byte in content:
                checksum = (checksum ^ byte) * 0x100000001b3 % 2**64
            with open(os.path.join(out, "checkpoint.txt"), "wb") as stream:
                stream.write(content + b"checksum %016x\n" % checksum)
            process = self.codesign(*SMALL, *self.MORE, "--resume", "--out", out)
            self.assertEqual(process.returncode, 1, (replacement, process.stderr))
            self.assertRegex(process.stderr, expected)
            self.assertNotIn("damaged", process.stderr)


class Schedule(Resume):
    """A schedule of stages: what holds of an interrupted run holds in and between its stages, and more."""

    MORE = ("--schedule", "0.9:1e-4:0.5,1:1e-6")

    def test_stages(self):
        names, rows = results.read_history(self.reference)
        self.assertEqual([row[names.index("stage")] for row in rows], ["1", "1", "2", "2"])
        summary = results.read_summary(self.reference)
        bases = len(summary["bases"])
        last = [row for row in rows if row[names.index("stage")] == "2"]
        best = min(last, key=lambda row: float(row[1]))
        self.assertEqual(summary["loss_best"], float(best[1]))
        self.assertEqual(summary["weights"], [float(text) for text in best[2:2 + bases]])
        self.assertEqual([stage["grid"] for stage in summary["settings"]["schedule"]], [[22, 9, 11], [24, 10, 12]])
        # The design is handed on: the last stage starts from the best one of the first.
        first = min(rows[:2], key=lambda row: float(row[1]))
        self.assertEqual(last[0][2:2 + bases + 3], first[2:2 + bases + 3])
        self.assertEqual(summary["gradient_check"]["design"], "first of the last stage")
        for name in ("weights", "control"):
            self.assertLessEqual(summary["gradient_check"][name]["relative_error"], 1e-6, name)
        # The last stage is a run of its own from there, and the first loss is that of the first design on the last grid.
        out, start = self.path("alone"), self.path("start")
        self.assertEqual(self.codesign(*SMALL, "--iterations", 1, "--out", start).returncode, 0)
        self.assertEqual(results.read_summary(start)["loss_first"], summary["loss_first"])
        self.assertLess(summary["loss_best"], summary["loss_first"])
        self.assertEqual(self.codesign(*SMALL, *self.MORE, "--iterations", 1, "--out", out).returncode, 0)
        self.assertEqual(results.read_history(out)[1][0][1], results.read_history(start)[1][0][1])

    def test_a_stage_ends_when_its_loss_stalls(self):
        out = self.path("stalled")
        # One base under a fixed sine has nothing to vary: the coarse stage is over after the fewest iterations.
        tuna = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "examples", "shapes", "tuna.stl")
        process = self.codesign(*SMALL, "--iterations", 20, "--fixed-control", *self.MORE, "--out", out, tuna)
        self.assertEqual(process.returncode, 0, process.stderr)
        names, rows = results.read_history(out)
        self.assertEqual([row[names.index("stage")] for row in rows], ["1"] * 5 + ["2"] * 5)
        self.assertRegex(process.stderr, r"iteration 6/20  stage 2/2 ")

    def test_more_iterations(self):
        """They go to the last stage: shares of the iterations are those of the run that was started."""
        out = self.path("longer")
        self.assertEqual(self.codesign(*SMALL, *self.MORE, "--iterations", 2, "--out", out).returncode, 0)
        self.resume(out)
        names, rows = results.read_history(out)
        self.assertEqual([row[names.index("stage")] for row in rows], ["1", "2", "2", "2"])

    def test_refuses_a_grid_on_which_the_muscles_are_others(self):
        """Fins that a coarse grid does not resolve; seen on real animals before any iteration."""
        data = os.environ.get("DQA_TEST_DATA", "")
        meshes = [os.path.join(data, name) for name in ("Orca.stl", "GreatWhiteShark.stl")]
        if not data or not all(map(os.path.exists, meshes)):
            self.skipTest("DQA_TEST_DATA does not name a folder with Orca.stl and GreatWhiteShark.stl")
        out = self.path("muscles")
        process = self.codesign("--grid", "56x14x24", "--automatic-fins", "--schedule", "coarse", "--out", out, *meshes)
        self.assertEqual(process.returncode, 1, process.stderr)
        self.assertIn("on 28x8x12 cells the meshes have other muscles", process.stderr)
        self.assertNotIn("iteration", process.stderr)
        self.assertFalse(os.path.exists(out))

    def test_refuses_another_schedule(self):
        process = self.codesign(*SMALL, "--resume", "--out", self.reference)
        self.assertEqual(process.returncode, 2, process.stderr)
        self.assertIn("schedule", process.stderr)

    def test_fewer_iterations_than_are_done(self):
        out = self.path("fewer")
        self.interrupt(out, signal.SIGKILL, 2)
        self.resume(out, "--iterations", 1)
        names, rows = results.read_history(out)
        self.assertEqual(rows[-1][names.index("stage")], "2")


class Repeats(Scratch):
    """A design that does not change is evaluated once."""

    def test_a_vertex(self):
        for number, meshes in enumerate(((), ("tuna.stl",))):
            out = self.path(f"vertex-{number}")
            shapes = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "examples", "shapes")
            # Of these shapes the first is the fastest already.
            start = () if meshes else ("--weights", "1,0,0,0")
            process = self.codesign(*SMALL, "--iterations", 12, "--fixed-control", *start, "--out", out,
                                    *(os.path.join(shapes, mesh) for mesh in meshes))
            self.assertEqual(process.returncode, 0, process.stderr)
            names, rows = results.read_history(out)
            work = names.index("newton_iterations")
            control = names.index("grad_norm_control")
            repeated = 0
            for before, row in zip(rows, rows[1:]):
                same = row[2:control] == before[2:control]
                repeated += same
                self.assertEqual(int(row[work]) == 0, same)
                if same:
                    self.assertEqual(row[1:control + 1], before[1:control + 1])
            if meshes:
                self.assertEqual(repeated, 4)
                self.assertEqual(len(rows), 5)
            again = self.path(f"again-{number}")
            shutil.copytree(out, again)
            process = self.codesign(*SMALL, "--iterations", 12, "--fixed-control", *start, "--out", again, "--resume",
                                    *(os.path.join(shapes, mesh) for mesh in meshes))
            self.assertEqual(process.returncode, 0, process.stderr)
            self.assertEqual(results.history_without_seconds(out), results.history_without_seconds(again))
            with open(os.path.join(out, "design.stl"), "rb") as a, open(os.path.join(again, "design.stl"), "rb") as b:
                self.assertEqual(a.read(), b.read())


class Tasks(Scratch):
    """Other objectives and controllers, and a record that does not fit its memory."""

    NET = ("--grid", "24x8x12", "--steps", 30, "--iterations", 2, "--controller", "mlp", "--objective",
           "travel:1,efficiency:0.1,effort:0.01")

    def test_a_network_under_a_weighted_sum(self):
        first, again = self.path("net"), self.path("net-small")
        process = self.codesign(*self.NET, "--out", first)
        self.assertEqual(process.returncode, 0, process.stderr)
        names, rows = results.read_history(first)
        self.assertEqual(names[-3:], ["travel", "efficiency", "effort"])
        for row in rows:
            travel, efficiency, effort = map(float, row[-3:])
            self.assertAlmostEqual(float(row[1]), travel + 0.1 * efficiency + 0.01 * effort, delta=1e-12)
        summary = results.read_summary(first)
        self.assertEqual(summary["settings"]["controller"], "mlp")
        self.assertEqual(summary["settings"]["objective"], {"travel": 1, "efficiency": 0.1, "effort": 0.01})
        self.assertEqual((len(summary["control"]) - 64 * 36 - 64 * 65) % 65, 0)
        for name in ("weights", "control"):
            self.assertLessEqual(summary["gradient_check"][name]["relative_error"], 1e-6, name)
        # One MiB does not hold the states of thirty steps: they are computed again, to the same bits.
        process = self.codesign(*self.NET, "--checkpoint-mib", 1, "--out", again)
        self.assertEqual(process.returncode, 0, process.stderr)
        for name in ("design.stl", "controller.dqa"):
            with open(os.path.join(first, name), "rb") as a, open(os.path.join(again, name), "rb") as b:
                self.assertEqual(a.read(), b.read(), name)

    def test_the_threshold_and_the_error_that_chooses_it(self):
        short = ("--grid", "24x8x12", "--steps", 2, "--iterations", 1)
        cells, thresholds = [], []
        for name, more in (("coarse", ("--model-error", 0.2)), ("fine", ("--model-error", "0.01")),
                           ("given", ("--threshold", 0.02)), ("silent", ()), ("all", ("--threshold", 0))):
            process = self.codesign(*short, *more, "--out", self.path(name))
            self.assertEqual(process.returncode, 0, process.stderr)
            summary = results.read_summary(self.path(name))
            settings = summary["settings"]
            if "--model-error" in more:
                self.assertEqual(settings["model_error"], float(more[1]))
                self.assertTrue(0.0 < settings["model_error_estimate"] <= settings["model_error"])
                self.assertIn("estimated error", process.stderr)
            else:
                self.assertIsNone(settings["model_error"])
            thresholds.append(settings["threshold"])
            cells.append(summary["cells"]["active"])
        coarse, fine, given, silent, every = thresholds
        self.assertTrue(0.0 < fine < coarse < 0.5)
        self.assertEqual((given, silent, every), (0.02, 0.02, 0.0))
        self.assertLess(cells[0], cells[1])
        self.assertEqual(cells[2], cells[3])
        self.assertEqual(cells[4], 24 * 8 * 12)
        # The threshold is chosen from the initial design: a resumed run finds it again.
        process = self.codesign(*short, "--iterations", 2, "--model-error", 0.2, "--resume", "--out",
                                self.path("coarse"))
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertEqual(results.read_summary(self.path("coarse"))["settings"]["threshold"], coarse)
        process = self.codesign(*short, "--model-error", 0.1, "--resume", "--out", self.path("coarse"))
        self.assertEqual(process.returncode, 2)
        self.assertIn("model-error", process.stderr)

    def test_a_path(self):
        path = self.path("path.txt")
        with open(path, "w", encoding="utf-8") as stream:
            stream.write("0 0 0 0\n1.0, 0.2, 0.1, 0\n")
        out = self.path("path")
        small = ("--grid", "24x8x12", "--steps", 10, "--iterations", 2)
        process = self.codesign(*small, "--objective", "path,keep:0.5", "--path", path, "--out", out)
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertIn("loss", process.stdout)
        # The points belong to the settings of a checkpoint.
        with open(path, "a", encoding="utf-8") as stream:
            stream.write("2 0 0 0\n")
        process = self.codesign(*small, "--objective", "path,keep:0.5", "--path", path, "--out", out, "--resume")
        self.assertEqual(process.returncode, 2)
        self.assertIn("path", process.stderr)


class Laws(Scratch):
    """Other water, material, integrator and muscles."""

    SMALL = ("--grid", "24x8x12", "--steps", 8, "--iterations", 2)

    def table(self, text):
        path = self.path("current.txt")
        with open(path, "w", encoding="utf-8") as stream:
            stream.write(text)
        return path

    def test_all_at_once(self):
        out, file = self.path("all"), self.table("0 0.3 0 0\n0.2, 0.1, 0.1, 0\n")
        laws = ("--interpolation", "bures", "--automatic-fins", "--material", "volume", "--integrator", "bdf2", "--planar",
                "--current-file", file)
        process = self.codesign(*self.SMALL, *laws, "--out", out)
        self.assertEqual(process.returncode, 0, process.stderr)
        summary = results.read_summary(out)
        settings = summary["settings"]
        self.assertEqual({name: settings[name] for name in ("interpolation", "automatic_fins", "material", "integrator",
                                                            "planar", "current", "current_file")},
                         {"interpolation": "bures", "automatic_fins": True, "material": "volume",
                          "integrator": "bdf2", "planar": True, "current": [], "current_file": file})
        for name in ("weights", "control"):
            self.assertLessEqual(summary["gradient_check"][name]["relative_error"], 1e-6, name)
        last = results.read_vtu(os.path.join(out, "frames", "swimmer_0008.vtu"))
        self.assertEqual(max(map(abs, last["displacement"][2::3])), 0.0, "a planar swimmer rose or sank")
        self.assertGreater(max(map(abs, last["displacement"][1::3])), 1e-6)
        self.assertEqual(self.codesign(*self.SMALL, *laws, "--out", out, "--resume").returncode, 0)

        def changed(option, value):
            at = laws.index(option)
            return laws[:at + 1] + (value,) + laws[at + 2:]
        still = laws[:-2]
        for other, word in ((changed("--interpolation", "linear"), "interpolation"),
                            (changed("--material", "neo-hookean"), "material"),
                            (changed("--integrator", "euler"), "integrator"),
                            ([word for word in laws if word != "--automatic-fins"], "automatic-fins"),
                            ([word for word in laws if word != "--planar"], "planar"),
                            (still, "current"), (still + ("--current", "0.3,0,0"), "current")):
            process = self.codesign(*self.SMALL, *other, "--out", out, "--resume")
            self.assertEqual(process.returncode, 2, process.stderr)
            self.assertRegex(process.stderr, f'it has "{word}')
        self.table("0 0.3 0 0\n0.2, 0.1, 0.1, 0.01\n")
        process = self.codesign(*self.SMALL, *laws, "--out", out, "--resume")
        self.assertEqual(process.returncode, 2, process.stderr)
        self.assertIn("current-file", process.stderr)

    def test_materials_differ(self):
        losses = set()
        for material in ("corotated", "volume", "neo-hookean"):
            out = self.path(material)
            process = self.codesign(*self.SMALL, "--iterations", 1, "--material", material, "--out", out)
            self.assertEqual(process.returncode, 0, process.stderr)
            losses.add(results.read_summary(out)["loss_first"])
        self.assertEqual(len(losses), 3)

    def test_a_current_carries_the_swimmer(self):
        losses = []
        for k, current in enumerate((("--current", "0.5,0,0"), ("--current-file", self.table("0 0.5 0 0\n")),
                                     ("--current", "0,0,0"), ())):
            out = self.path(f"current-{k}")
            process = self.codesign(*self.SMALL, "--iterations", 1, *current, "--out", out)
            self.assertEqual(process.returncode, 0, process.stderr)
            losses.append(results.read_summary(out)["loss_first"])
            self.assertEqual(results.read_summary(out)["settings"]["current"], [[0.5, 0, 0], [], [0, 0, 0], [0, 0, 0]][k])
        self.assertEqual(losses[0], losses[1])
        self.assertEqual(losses[2], losses[3])
        self.assertLess(losses[0], losses[2] - 1e-3)


class Refusals(Scratch):
    """Wrong input is refused with a message that names it, and leaves nothing behind."""

    def refuse(self, code, pattern, *arguments, **keywords):
        out = os.path.join(tempfile.mkdtemp(dir=self.root), "refused")
        process = self.codesign("--quick", "--out", out, *arguments, **keywords)
        self.assertEqual(process.returncode, code, process.stderr)
        self.assertTrue(re.search(pattern, process.stderr), process.stderr)
        self.assertTrue(all(line.startswith("codesign: ") for line in process.stderr.splitlines()), process.stderr)
        self.assertFalse(os.path.exists(out), "a folder was left behind")

    def test_command_line(self):
        for text in ("60x16", "60x16x26x2", "ax16x26", "60x16x4", "60x16x9999", "60,16,26", "-60x16x26", ""):
            self.refuse(2, "--grid", "--grid", text)
        for option in ("--iterations", "--steps", "--threads"):
            for text in ("0", "-1", "1.5", "many", "99999999999999999999"):
                self.refuse(2, option, option, text)
        for text in ("0", "0.1", "17", "nan", "wide", "0.7x"):
            self.refuse(2, "--sigma", "--sigma", text)
        for text in ("0", "5", "-1", "1.5", "fine", ""):
            self.refuse(2, "--refinement", "--refinement", text)
        for text in ("-0.1", "0.5", "nan", "thin", "0.1x", ""):
            self.refuse(2, "--threshold", "--threshold", text)
        for text in ("0", "1", "-0.1", "nan", "small", "0.1x", ""):
            self.refuse(2, "--model-error", "--model-error", text)
        self.refuse(2, "not both", "--threshold", "0.1", "--model-error", "0.1")
        self.refuse(2, "--frobnicate", "--frobnicate")
        self.refuse(2, "expects a value", "--steps")

    def test_task(self):
        for text in ("", "fast", "travel:", "travel:x", "travel,,keep", "travel,travel", "effort:nan", "keep:1:2"):
            self.refuse(2, "--objective", "--objective", text)
        self.refuse(2, "--path", "--objective", "path")
        self.refuse(2, "--path", "--path", "nowhere.txt")
        self.refuse(1, "nowhere.txt", "--objective", "path", "--path", "nowhere.txt")
        for text in ("0 0 0\n", "", "0 0 0 0\n0 1 1 1\n", "a b c d\n"):
            path = self.path("bad.txt")
            with open(path, "w", encoding="utf-8") as stream:
                stream.write(text)
            self.refuse(2, "bad.txt", "--objective", "path", "--path", path)
        self.refuse(2, "--controller", "--controller", "mpc")
        self.refuse(2, "--fixed-control", "--controller", "mlp", "--fixed-control")
        self.refuse(2, "--checkpoint-mib", "--checkpoint-mib", "0")

    def test_laws(self):
        for option, expected in (("--interpolation", "linear or bures"), ("--integrator", "euler or bdf2"),
                                 ("--material", "corotated, volume or neo-hookean")):
            for text in ("other", "", "0"):
                self.refuse(2, f"{option} expects {expected if text else 'a value'}", option, text)
        for text in ("1", "1,2", "1,2,3,4", "a,0,0", "nan,0,0", "inf,0,0", "1 0 0", "0,0,0x"):
            self.refuse(2, "--current expects", "--current", text)
        self.refuse(2, "not both", "--current", "0,0,0", "--current-file", "nowhere.txt")
        self.refuse(1, "nowhere.txt", "--current-file", "nowhere.txt")
        for text in ("0 0 0\n", "", "0 0 0 0\n0 1 1 1\n", "a b c d\n", "0 0 inf 0\n"):
            path = self.path("still.txt")
            with open(path, "w", encoding="utf-8") as stream:
                stream.write(text)
            self.refuse(2, "still.txt: expected lines of four numbers.*m/s", "--current-file", path)

    def test_schedule(self):
        for text in ("", "fast", "0.5:1e-4", "0.5:1e-4,0.9:1e-6", "0.5:1e-4,1", "0.5,1", "1:1e-6:0.5", "0.05:1e-4,1:1e-6",
                     "1.5:1e-4,1:1e-6", "0.5:0,1:1e-6", "0.5:1e-4,1:0.1", "0.5:nan,1:1e-6", "nan:1e-4,1:1e-6",
                     "0.5:1e-4:1,1:1e-6", "0.5:1e-4:0.5,0.9:1e-4:0.5,1:1e-6", "0.5:1e-4;1:1e-6", "0.5:1e-4,1:1e-6,",
                     "0.5:1e-4,1:1e-6x"):
            self.refuse(2, "--schedule expects", "--schedule", text)
        self.refuse(2, "at most 8 stages", "--schedule", ",".join(["0.5:1e-4"] * 8 + ["1:1e-6"]))

    def test_weights(self):
        self.refuse(2, "sum to 1", "--weights", "0.5,0.5,0.5,0.5")
        self.refuse(2, "2 weights for 4 meshes", "--weights", "0.5,0.5")
        self.refuse(2, "--weights expects", "--weights", "1.5,-0.5,0,0")
        self.refuse(2, "--weights expects", "--weights", "0.5;0.5")
        self.refuse(2, "--weights expects", "--weights", "nan,0,0,1")

    def test_meshes(self):
        garbage = self.path("garbage.stl")
        with open(garbage, "wb") as stream:
            stream.write(b"garbage" * 100)
        with open(self.path("empty.stl"), "wb"):
            pass
        self.refuse(1, "missing.stl", self.path("missing.stl"))
        self.refuse(1, "garbage.stl", garbage)
        self.refuse(1, "empty.stl", self.path("empty.stl"))
        self.refuse(1, "DQA_SHAPES_DIR", env={**os.environ, "DQA_SHAPES_DIR": self.path("nowhere")})

    def test_bases_file(self):
        def listed(text):
            path = self.path("list.txt")
            with open(path, "w", encoding="utf-8") as stream:
                stream.write(text)
            return "--bases-file", path

        base = "base some.stl\n"
        for line, pattern in {
                "shark.stl": r"list\.txt:2: expected base, caudal, fins or lengths",
                "lengths": r"list\.txt:2: lengths expects own or longest, not \"end of line\"",
                "lengths 2": r"list\.txt:2: lengths expects own or longest, not \"2\"",
                "base": r"list\.txt:2: base expects the path",
                "caudal half 1 1 1": r"list\.txt:2: the actuator needs \"mean\"",
                "caudal mean 0 0 0": r"list\.txt:2: the actuator needs \"half\"",
                "caudal mean 0 0 x half 1 1 1": r"list\.txt:2: mean expects a number, not \"x\"",
                "caudal mean 0 0": r"list\.txt:2: mean expects a number, not \"end of line\"",
                "caudal mean 0 0 0 half 1 0 1": r"list\.txt:2: half expects",
                "caudal mean 0 0 0 half 1 1 1 layers 2": r"list\.txt:2: expected mean, half, angles, category, not",
                "fins mean 0 0 0 half 1 1 1 layers 5": r"list\.txt:2: layers expects a whole number from 1 to 4",
                "fins mean 0 0 0 half 1 1 1 side up": r"list\.txt:2: side expects left or right",
                "fins mean 0 0 0 half 1 1 1 category 16": r"list\.txt:2: category expects",
                "caudal mean nan 0 0 half 1 1 1": r"list\.txt:2: mean expects a number",
        }.items():
            self.refuse(2, pattern, *listed(base + line + "  # a comment\n"))
        self.refuse(2, r"list\.txt:1: an actuator before", *listed("caudal mean 0 0 0 half 1 1 1\n"))
        self.refuse(2, "names no base", *listed("# nothing\n\n"))
        self.refuse(2, "longer than", *listed(base + "#" * 5000 + "\n"))
        self.refuse(2, "not both", *listed(base), "mesh.stl")
        self.refuse(1, "some.stl", *listed(base))
        self.refuse(1, "cannot read .*nowhere.txt", "--bases-file", self.path("nowhere.txt"))
        pipe = self.path("pipe")
        os.mkfifo(pipe)
        for path in ("/dev/zero", pipe, self.root):
            self.refuse(1, f"cannot read {path}: it is not a regular file", "--bases-file", path)
            self.refuse(1, f"cannot read {path}: it is not a regular file", "--objective", "path", "--path", path)
            self.refuse(1, "regular file|folder", path)
        shapes = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "examples", "shapes")
        tuna = "base " + os.path.abspath(os.path.join(shapes, "tuna.stl")) + "\n"
        thick = "fins mean 0 0.1 0 half 0.1 0.05 0.2\n"
        self.refuse(1, "actuator in line 2 of .*variance\\[2\\]", *listed(tuna + thick))

    def test_resume_without_a_checkpoint(self):
        self.refuse(2, "no checkpoint", "--resume")

    def test_folder(self):
        blocked = self.path("blocked")
        with open(blocked, "w"):
            pass
        folders = [blocked, os.path.join(blocked, "out"), self.path("missing", "out"), "/proc/codesign-out"]
        if os.geteuid() != 0:
            os.makedirs(self.path("locked"))
            os.chmod(self.path("locked"), 0o555)
            folders += [self.path("locked"), self.path("locked", "out")]
        for folder in folders:
            process = self.codesign("--quick", "--out", folder)
            self.assertEqual(process.returncode, 1, process.stderr)
            self.assertIn(folder, process.stderr)
        self.assertEqual(os.path.getsize(blocked), 0)

    def test_help(self):
        process = self.codesign("--help")
        self.assertEqual((process.returncode, process.stderr), (0, ""))
        for option in ("--grid", "--iterations", "--steps", "--fixed-control", "--weights", "--out", "--quick",
                       "--resume", "--threads", "--sigma", "--refinement", "--controller", "--objective", "--path", "--checkpoint-mib",
                       "--threshold", "--model-error", "--bases-file", "--automatic-fins", "--interpolation", "--material", "--integrator", "--planar",
                       "--current", "--current-file", "--schedule"):
            self.assertIn(option, process.stdout)


class Shortage(Scratch):
    """A full disk or a missing helper program. A file-size limit stands in for the full disk: writes fail in the
    middle of a file, as they do there."""

    def limited(self, size, out):
        def limit():
            resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
        return self.codesign(*SMALL, "--iterations", 2, "--out", out, preexec_fn=limit)

    def test_no_room_at_all(self):
        out = self.path("none")
        process = self.limited(100, out)
        self.assertEqual(process.returncode, 1, process.stderr)
        self.assertIn("cannot write", process.stderr)
        self.assertFalse(os.path.exists(out))

    def test_no_room_for_the_frames(self):
        out = self.path("few")
        process = self.limited(8000, out)
        self.assertEqual(process.returncode, 1, process.stderr)
        self.assertIn("cannot write", process.stderr)
        self.assert_nothing_half_written(out)
        self.assertFalse(os.path.exists(os.path.join(out, "summary.json")))
        self.assertEqual(len(results.read_history(out)[1]), 2)
        again = self.codesign(*SMALL, "--iterations", 2, "--resume", "--out", out)
        self.assertEqual(again.returncode, 0, again.stderr)

    def test_standard_output_is_full(self):
        with open("/dev/full", "w") as full:
            process = subprocess.run([PROGRAM, *SMALL, "--iterations", "1", "--out", self.path("full")], stdout=full,
                                     stderr=subprocess.PIPE, text=True, timeout=600)
        self.assertEqual(process.returncode, 1)
        self.assertIn("standard output", process.stderr)

    def test_without_gnuplot(self):
        out = self.path("plain")
        process = self.codesign(*SMALL, "--iterations", 1, "--out", out, env={**os.environ, "PATH": self.root})
        self.assertEqual(process.returncode, 0, process.stderr)
        self.assertIn("gnuplot is not installed", process.stderr)
        self.assertNotIn("codesign.png", process.stdout)
        self.assertTrue(os.path.exists(os.path.join(out, "summary.json")))
        self.assertFalse(os.path.exists(os.path.join(out, "codesign.png")))


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit("usage: test_codesign.py PROGRAM [unittest arguments]")
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main(verbosity=2)
