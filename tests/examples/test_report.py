#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""report.html in headless Chromium, from disk: test_report.py CODESIGN LARGE_REPORT runs codesign and
compares what the page shows with the other files of the run. Skipped (exit code 77) where Chromium is missing."""
import base64
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

import results

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "examples", "report"))
import browser  # noqa: E402

PROGRAM = LARGE_REPORT = ""
SMALL = ["--grid", "24x10x12", "--steps", "12", "--iterations", "3"]


def read_data(path):
    """The data of a page, without a browser."""
    with open(path, encoding="utf-8") as stream:
        text = stream.read()
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S).group(1))


def decode_positions(swimmer):
    """Positions [frames][vertices * 3] as the page's own decoder finds them (format: report_motion.h)."""
    data, at = base64.b64decode(swimmer["positions"], validate=True), 0
    n, frames = 3 * swimmer["vertices"], []
    for k in range(len(swimmer["times"])):
        levels = []
        for i in range(n):
            rest = shift = 0
            while True:
                byte = data[at]
                at += 1
                rest |= (byte & 0x7f) << shift
                shift += 7
                if byte < 0x80:
                    break
            guess = 0
            if k == 0 and i >= 3:
                guess = levels[i - 3]
            elif k == 1:
                guess = frames[0][i]
            elif k >= 2:
                guess = 2 * frames[-1][i] - frames[-2][i]
            levels.append(guess + (-(rest + 1) // 2 if rest & 1 else rest // 2))
        frames.append(levels)
    assert at == len(data), "bytes are left over"
    return [[swimmer["origin"][i % 3] + swimmer["quantum"] * level for i, level in enumerate(levels)] for levels in frames]


class Report(unittest.TestCase):
    """One run, one browser."""

    @classmethod
    def setUpClass(cls):
        cls.root = tempfile.mkdtemp(prefix="report-")
        cls.out = os.path.join(cls.root, "out")
        # A name that tries to end the script which holds the data.
        hostile = os.path.join(cls.root, "a<b>'&.stl")
        shapes = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "examples", "shapes")
        shutil.copy(os.path.join(shapes, "eel_vertical.stl"), hostile)
        meshes = [os.path.join(shapes, name) for name in ("clownfish.stl", "tuna.stl")]
        cls.process = results.run(PROGRAM, *SMALL, "--current", "-0.1,0.05,0", "--objective", "travel:1,effort:0.01",
                                  "--out", cls.out, hostile, *meshes)
        assert cls.process.returncode == 0, cls.process.stderr
        cls.path = os.path.join(cls.out, "report.html")
        cls.data = read_data(cls.path)
        cls.page = browser.Browser(800, 900)
        cls.opened = None

    @classmethod
    def tearDownClass(cls):
        cls.page.close()
        shutil.rmtree(cls.root, ignore_errors=True)

    def open(self, fragment="", scheme="light", motion="reduce", width=800):
        """The page at its start; it is loaded again only for another fragment, theme or width."""
        wanted = (fragment, scheme, motion, width)
        if wanted == Report.opened:
            self.page.evaluate("report.player.pause(); report.player.show('all'); report.player.setMode('body');"
                               "report.player.look('ahead'); report.player.setTime(0)")
        else:
            self.page.resize(width, 900)
            self.page.media(scheme, motion)
            self.page.open(self.path, fragment)
            Report.opened = wanted
        self.assertEqual(self.page.complaints(), [])

    def chart(self, title):
        return next(item for item in self.data["items"] if item["type"] == "chart" and item["title"].startswith(title))

    def pixels(self):
        """Pixels of the view, made smaller, row by row."""
        numbers = self.page.evaluate("""(() => { const c = document.createElement("canvas"), pen = c.getContext("2d");
            c.width = 180; c.height = 90;
            pen.drawImage(report.player.view.canvas, 0, 0, 180, 90);
            return Array.from(pen.getImageData(0, 0, 180, 90).data); })()""")
        return [tuple(numbers[i:i + 3]) for i in range(0, len(numbers), 4)]

    def test_is_one_small_file(self):
        self.assertIn(self.path, self.process.stdout)
        with open(self.path, encoding="utf-8") as stream:
            text = stream.read()
        self.assertLess(len(text), 3 << 20)
        self.assertNotRegex(text, r'<(?:script|img|link|iframe)[^>]*(?:src|href)="(?!data:,)')
        self.assertIn("default-src 'none'", text)

    def test_facts_are_those_of_the_summary(self):
        summary = results.read_summary(self.out)
        facts = {item["key"]: item for item in self.data["items"] if item["type"] == "fact" and item["key"]}
        self.assertEqual(set(facts), {"loss_best", "loss_first", "iterations", "seconds"})
        for key, fact in facts.items():
            self.assertEqual(fact["value"], summary[key], key)
        self.open()
        shown = self.page.evaluate("Object.fromEntries([...document.querySelectorAll('.fact[data-key]')]"
                                   ".map((f) => [f.dataset.key, f.querySelector('b').textContent]))")
        for key, fact in facts.items():
            number = float(shown[key].split()[0].replace("\u2212", "-"))
            self.assertAlmostEqual(number, fact["scale"] * summary[key], delta=0.51 * 10.0 ** -fact["digits"], msg=key)
        settings = next(item["rows"] for item in self.data["items"] if item.get("title") == "Settings")
        self.assertEqual(settings, summary["settings"])

    def test_charts_hold_the_history(self):
        names, rows = results.read_history(self.out)
        column = {name: [float(row[k]) for row in rows] for k, name in enumerate(names)}
        self.assertEqual(self.chart("Loss")["series"][0]["y"], column["loss"])
        self.assertEqual(self.chart("Loss")["series"][1]["y"], [min(column["loss"])])
        bases = results.read_summary(self.out)["bases"]
        self.assertEqual([(s["name"], s["y"]) for s in self.chart("Share")["series"]],
                         [(base, column["weight_" + base]) for base in bases])
        self.assertEqual([(s["name"], s["y"]) for s in self.chart("Terms")["series"]],
                         [(name, column[name]) for name in ("travel", "effort")])
        self.assertEqual([s["y"] for s in self.chart("Gradient")["series"]],
                         [column["grad_norm_weights"], column["grad_norm_control"]])
        self.assertEqual(self.chart("Muscle signal a")["series"][0]["y"], column["a"])
        radar = self.chart("Mix")
        self.assertEqual(radar["axes"], bases)
        self.assertEqual([s["y"] for s in radar["series"]],
                         [results.read_summary(self.out)[k]["weights"] for k in ("first", "best")])

    def test_every_series_is_drawn_with_all_its_points(self):
        self.open()
        drawn = self.page.evaluate("""Object.fromEntries([...document.querySelectorAll('.chart')].map((c) => [
            c.dataset.title, [...c.querySelectorAll('g.series')].map((s) => [s.dataset.name, Number(s.dataset.points),
            s.querySelector('.curve') ? s.querySelector('.curve').getAttribute('d').match(/[ML]/g).length : 1])]))""")
        charts = [item for item in self.data["items"] if item["type"] == "chart"]
        self.assertEqual(set(drawn), {chart["title"] for chart in charts})
        for chart in charts:
            self.assertEqual(drawn[chart["title"]], [[s["name"], len(s["y"]), len(s["y"])] for s in chart["series"]])
        self.assertEqual(self.page.evaluate("[...document.querySelectorAll('.chart path[d*=NaN], .chart text')]"
                                            ".filter((e) => e.tagName === 'path' || /NaN|undefined/.test(e.textContent)).length"), 0)
        for chart in charts:
            if chart["kind"] != "radar":
                self.assertTrue(chart["x_title"] and chart["y_title"], chart["title"])

    def test_forces_and_signals_are_those_of_the_swim(self):
        steps = results.read_summary(self.out)["settings"]["steps"]
        for what in ("initial", "optimised"):
            forces = self.chart(f"Forces of the water along x, {what}")["series"]
            self.assertEqual([(s["name"], len(s["y"])) for s in forces], [("drag", steps), ("thrust", steps)])
            self.assertTrue(all(any(v != 0.0 for v in s["y"]) for s in forces))
            # The water comes from ahead onto a body at rest: the first drag is backward.
            self.assertLess(forces[0]["y"][0], 0.0)
            signals = self.chart(f"Muscle signals, {what}")["series"]
            self.assertTrue(all(len(s["y"]) == steps and max(map(abs, s["y"])) <= 1.0 for s in signals))
        self.assertEqual([s["y"] for s in self.chart("Current")["series"]], [[v] * steps for v in (-0.1, 0.05, 0.0)])

    def test_positions_are_those_of_the_frames(self):
        swimmer = [item for item in self.data["items"] if item["type"] == "swimmer"][-1]
        frames = results.read_pvd(os.path.join(self.out, "swimmer.pvd"))
        positions = decode_positions(swimmer)
        self.assertEqual(len(positions), len(frames))
        for (when, path), time_here, here in zip(frames, swimmer["times"], positions):
            there = results.read_vtu(path)["Points"]
            self.assertAlmostEqual(when, time_here, delta=1e-6)
            self.assertLess(max(abs(a - b) for a, b in zip(here, there)), 0.51 * swimmer["quantum"])
        self.open()
        page = self.page.evaluate("Array.from(report.swimmers[1].frames.slice(-30))")
        self.assertLess(max(abs(a - b) for a, b in zip(page, positions[-1][-30:])), 1e-6)

    def test_the_animation_runs(self):
        self.open(motion="no-preference")
        self.assertEqual(self.page.evaluate("report.player.view.kind"), "three")
        self.assertTrue(self.page.evaluate("report.player.playing"))
        seen, until = set(), time.monotonic() + 60.0
        while len(seen) < 3 and time.monotonic() < until:
            seen.add(self.page.evaluate("document.getElementById('clock').textContent"))
            time.sleep(0.1)
        self.assertGreaterEqual(len(seen), 3, "the clock stands still")
        self.page.evaluate("document.getElementById('play').click()")
        drawn = self.page.evaluate("report.player.drawn")
        time.sleep(0.3)
        self.assertLessEqual(self.page.evaluate("report.player.drawn"), drawn + 1, "it goes on after pause")

    def test_readers_who_want_no_motion_get_none(self):
        self.open(motion="reduce")
        self.assertFalse(self.page.evaluate("report.player.playing"))

    def check_pictures(self, fragment, kind):
        self.open(fragment)
        self.assertEqual(self.page.evaluate("report.player.view.kind"), kind)
        pictures = []
        for mode, share in (("body", 0.0), ("body", 0.9), ("actuation", 0.9), ("speed", 0.9)):
            self.page.evaluate(f"report.player.setMode('{mode}'); report.player.time = {share} * report.player.duration;"
                               "report.player.draw()")
            pictures.append(self.pixels())
            ink = sum(pixel != pictures[-1][0] for pixel in pictures[-1])
            self.assertGreater(ink, 0.05 * len(pictures[-1]), mode)
            self.assertGreater(len(set(pictures[-1])), 50, mode)
        for before, after in zip(pictures, pictures[1:]):
            self.assertNotEqual(before, after)
        self.page.evaluate("report.player.look('top')")
        self.page.evaluate("report.player.draw()")
        self.assertNotEqual(self.pixels(), pictures[-1])
        # What the reader sees is what the canvas holds.
        with tempfile.NamedTemporaryFile(suffix=".png") as stream:
            stream.write(self.page.screenshot("#view", scale=0.25))
            stream.flush()
            rows = results.read_png(stream.name)[2]
        self.assertGreater(len({pixel for row in rows for pixel in row}), 50)
        self.assertEqual(self.page.complaints(), [])

    def test_pictures_by_three(self):
        self.check_pictures("", "three")

    def test_pictures_without_webgl(self):
        self.check_pictures("#canvas", "canvas")

    def test_turns_with_the_mouse(self):
        for fragment in ("", "#canvas"):
            self.open(fragment)
            before = self.page.evaluate("report.player.view.project([0.3, 0, 0])")
            box = self.page.evaluate("(() => { const b = report.player.view.canvas.getBoundingClientRect();"
                                     "return [b.left + b.width / 2, b.top + b.height / 2]; })()")
            for kind, move, buttons in (("mousePressed", 0, 1), ("mouseMoved", 60, 1), ("mouseMoved", 120, 1),
                                        ("mouseReleased", 120, 0)):
                self.page.call("Input.dispatchMouseEvent", type=kind, x=box[0] + move, y=box[1], buttons=buttons,
                               button="left" if kind != "mouseMoved" else "none", clickCount=1)
            self.page.evaluate("report.player.draw()")
            after = self.page.evaluate("report.player.view.project([0.3, 0, 0])")
            self.assertGreater(abs(after[0] - before[0]) + abs(after[1] - before[1]), 5.0, fragment or "three")

    def test_one_alone_and_time_from_charts(self):
        self.open()
        self.page.evaluate("report.player.show('optimised'); report.player.draw()")
        self.assertEqual(self.page.evaluate("[...document.querySelectorAll('#labels span')].map((l) => l.hidden)"),
                         [True, False])
        self.page.evaluate("document.querySelector('[data-title^=\"Way along\"] svg').scrollIntoView()")
        box = self.page.evaluate("(() => { const b = document.querySelector('[data-title^=\"Way along\"] svg')"
                                 ".getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()")
        for kind in ("mousePressed", "mouseReleased"):
            self.page.call("Input.dispatchMouseEvent", type=kind, x=box[0] + 0.55 * box[2], y=box[1] + 0.4 * box[3],
                           button="left", clickCount=1)
        share = self.page.evaluate("report.player.time / report.player.duration")
        self.assertTrue(0.4 < share < 0.6, share)

    def test_fits_narrow_and_wide_in_light_and_dark(self):
        grounds = set()
        for width in (360, 1600):
            self.open(width=width)
            for scheme in ("light", "dark"):
                self.page.media(scheme, "reduce")
                self.assertLessEqual(self.page.evaluate("document.documentElement.scrollWidth"), width)
                grounds.add(self.page.evaluate("getComputedStyle(document.body).backgroundColor"))
        self.assertEqual(len(grounds), 2)
        Report.opened = None
        self.page.media("dark", "reduce", "print")
        self.assertEqual(self.page.evaluate("getComputedStyle(document.body).backgroundColor"), "rgb(255, 255, 255)")

    def test_a_page_that_wants_the_network_would_be_noticed(self):
        self.open()
        self.page.evaluate("fetch('http://localhost/').catch(() => 0)")
        self.page.evaluate("new Image().src = 'https://localhost/'; new Promise((done) => setTimeout(done, 200))")
        self.page.evaluate("console.error('noticed')")
        found = " ".join(self.page.complaints())
        Report.opened = None
        for word in ("http://localhost/", "https://localhost/", "noticed"):
            self.assertIn(word, found)

    def test_names_are_shown_as_they_are(self):
        self.open()
        self.assertIn("a<b>'&", self.page.evaluate("document.querySelector('[data-title^=Share]').textContent"))


class Corners(unittest.TestCase):
    """Runs with as little as there can be, and with a network whose signals have no numbers of their own."""

    def test_pages(self):
        tuna = os.path.join(os.path.dirname(browser.__file__), "..", "shapes", "tuna.stl")
        with tempfile.TemporaryDirectory(prefix="report-") as root, browser.Browser(800, 900) as page:
            for k, more in enumerate((("--steps", 1, "--iterations", 1, "--fixed-control", tuna),
                                      ("--iterations", 2, "--controller", "mlp", "--automatic-fins"))):
                out = os.path.join(root, str(k))
                process = results.run(PROGRAM, *SMALL, "--out", out, *more)
                self.assertEqual(process.returncode, 0, process.stderr)
                page.media(motion="reduce")
                page.open(os.path.join(out, "report.html"))
                page.evaluate("report.player.setTime(report.player.duration); report.player.setMode('actuation');"
                              "report.player.draw()")
                self.assertEqual(page.complaints(), [])
                self.assertNotRegex(page.evaluate("document.body.innerText"), "NaN|undefined|Infinity")
                self.assertEqual(page.evaluate("document.querySelectorAll('[d*=NaN], [transform*=NaN]').length"), 0)


class Large(unittest.TestCase):
    """Pages stay small: where there is too much, frames are left out, but never the last one."""

    def test_size_and_positions(self):
        with tempfile.TemporaryDirectory(prefix="report-") as root:
            for vertices, frames, whole in ((2000, 101, True), (9000, 201, False)):
                process = results.run(LARGE_REPORT, root, vertices, frames)
                self.assertEqual(process.returncode, 0, process.stderr)
                path = os.path.join(root, "report.html")
                self.assertLess(os.path.getsize(path), 6 << 20)
                swimmer = read_data(path)["items"][0]
                kept = [round(30.0 * t) for t in swimmer["times"]]
                self.assertEqual(kept == list(range(frames)), whole)
                self.assertEqual((kept[0], kept[-1], kept), (0, frames - 1, sorted(set(kept))))
                positions = decode_positions(swimmer)
                for k, here in zip(kept, positions):
                    for i in range(0, vertices, 97):
                        s = i / vertices
                        there = (s + k / 100, 0.1 * s * s * math.sin(0.5 * k - 5.0 * s), 0.05 * math.cos(i))
                        for a, b in zip(here[3 * i:3 * i + 3], there):
                            self.assertLess(abs(a - b), 0.51 * swimmer["quantum"])
            with browser.Browser(800, 900) as page:
                page.media(motion="reduce")
                page.open(path)
                page.evaluate("report.player.setTime(report.player.duration); report.player.draw()")
                self.assertEqual(page.complaints(), [])
                self.assertIn("left out", page.evaluate("document.getElementById('stage-note').textContent"))


class WithoutThree(unittest.TestCase):
    """The page that a build without three.js makes, put around the same data."""

    def test_draws_on_a_canvas(self):
        embed = os.path.join(os.path.dirname(browser.__file__), "embed.cmake")
        with tempfile.TemporaryDirectory(prefix="report-") as root:
            source, out = os.path.join(root, "page.c"), os.path.join(root, "out")
            subprocess.run(["cmake", "-DPAGE=" + os.path.join(os.path.dirname(embed), "report.html"),
                            "-DOUTPUT=" + source, "-DTHREE=", "-P", embed], check=True)
            self.assertEqual(results.run(PROGRAM, *SMALL, "--iterations", 1, "--out", out).returncode, 0)
            with open(source, encoding="ascii") as stream:
                head, tail = (bytes(int(text, 16) for text in part.split(",")[:-1])
                              for part in re.findall(r"\[\] = \{([^}]*)\}", stream.read()))
            path = os.path.join(out, "report.html")
            with open(path, "rb") as stream:
                text = stream.read()
            start = text.index(b'id="data">') + 10
            with open(path, "wb") as stream:
                stream.write(head + text[start:text.index(b"</script>", start)] + tail)
            self.assertLess(len(head) + len(tail), 100 << 10)
            with browser.Browser() as page:
                page.open(path)
                self.assertEqual(page.evaluate("report.player.view.kind"), "canvas")
                self.assertGreater(page.evaluate("document.querySelectorAll('.chart').length"), 5)
                self.assertEqual(page.complaints(), [])


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit("usage: test_report.py CODESIGN LARGE_REPORT [unittest arguments]")
    PROGRAM, LARGE_REPORT = (os.path.abspath(sys.argv.pop(1)) for _ in range(2))
    if browser.find() is None:
        print("skipped: Chromium is not installed")
        sys.exit(77)
    unittest.main(verbosity=2)
