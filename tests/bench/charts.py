#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws the charts of speed against accuracy from the CSV files of the benchmarks, as SVG, with gnuplot.

    charts.py [--results DIR] [--charts DIR] [name ...]

Names: work_precision_<scene>, rollout_<scene>, threshold, adjoint, quadrature, model, scaling, barycenter, schedule,
stability; default all whose CSV files are there. Titles are made from the figures. A ring marks what the library does
by default.
"""
import argparse
import csv
import math
import pathlib
import subprocess
import sys
import textwrap

HERE = pathlib.Path(__file__).resolve().parent

# Colours that colour-blind readers tell apart (Okabe & Ito 2008), the same for a thing in every chart.
BLUE, ORANGE, GREEN, RED, PURPLE, SKY, BLACK = "#0072B2 #E69F00 #009E73 #D55E00 #CC79A7 #56B4E9 #000000".split()
METHOD_COLOURS = {"newton_pcg": BLUE, "projective": ORANGE, "newton_direct": GREEN, "reference": RED}
FIVE = [BLUE, ORANGE, GREEN, PURPLE, SKY, RED, BLACK]
DEFAULT_TOLERANCE, DEFAULT_THRESHOLD, DEFAULT_SIGMA, DEFAULT_H = 1e-6, 0.02, 0.4, 1 / 30
SCENES = {"eel": "two eels", "orca_shark": "orca and shark", "shipped": "clownfish and tuna", "three": "three rays"}


def read(folder, name):
    """Rows of name.csv and of name_<scene>.csv, numbers as such; none where there is no file."""
    rows = []
    for path in [folder / f"{name}.csv"] + [folder / f"{name}_{scene}.csv" for scene in SCENES]:
        if not path.exists():
            continue
        with open(path, newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                for key, text in row.items():
                    if key == "outcome":  # one of them is the word nan
                        continue
                    try:
                        row[key] = float(text)
                    except (TypeError, ValueError):
                        pass
                rows.append(row)
    return rows


def near(a, b):
    return abs(a - b) <= 1e-3 * abs(b) if b else a == 0


def escape(text):
    """Text as gnuplot shows it: no markup."""
    return str(text).replace("\\", "\\\\").replace("_", "\\\\_").replace('"', "'").replace("^", "\\\\^")


def sci(value):
    """1e-6 for 1e-06."""
    mantissa, exponent = f"{value:.0e}".split("e")
    return f"{mantissa}e{int(exponent)}"


class Curve:
    def __init__(self, label, colour, points, rings=(), texts=(), dash=1, style="linespoints", mark=7):
        self.label, self.colour, self.points = label, colour, list(points)
        self.rings, self.texts, self.dash, self.style, self.mark = list(rings), list(texts), dash, style, mark


class Panel:
    def __init__(self, title, x, y, curves, log="xy", extra=()):
        self.title, self.x, self.y, self.log, self.extra = title, x, y, log, list(extra)
        self.curves = [c for c in curves if c.points]


def header(path, title, width, height, layout):
    return [f"set terminal svg size {width},{height} font 'DejaVu Sans,13' background '#ffffff'",
            f"set output '{path}'", "set encoding utf8", "set tics nomirror out", "set border 3 lc rgb '#555555'",
            "set grid lc rgb '#e4e4e4' lw 1", "set key outside below center horizontal maxcols 2 font ',11' samplen 2",
            "set multiplot layout {} title \"{}\" font ',15'".format(
                layout, "\\n".join(textwrap.wrap(escape(title), width // 9))),
            "set lmargin 10", "set rmargin 3"]


def gnuplot(lines):
    done = subprocess.run(["gnuplot"], input="\n".join(lines) + "\n", text=True, capture_output=True, check=False)
    if done.returncode != 0 or "rror" in done.stderr:
        sys.exit(f"charts: gnuplot: {done.stderr}")


def draw(path, title, panels, width=1080, height=520):
    """One SVG of panels side by side."""
    lines = header(path, title, width, height, f"1,{len(panels)}")
    for number, panel in enumerate(panels):
        lines += ["unset logscale", "set format '%g'", "set autoscale", f"set title \"{escape(panel.title)}\" font ',13'",
                  f"set xlabel \"{escape(panel.x)}\"", f"set ylabel \"{escape(panel.y)}\""]
        for axis in panel.log:
            lines += [f"set logscale {axis}", f"set format {axis} '10^{{%L}}'"]
        labels = [c.label for c in panel.curves if c.label]
        columns = 2 if all(len(label) < 20 for label in labels) else 1
        rows = (len(labels) + columns - 1) // columns
        lines += [f"set key outside below center horizontal maxcols {columns} font ',11' samplen 2",
                  f"set bmargin {5 + rows}"] + panel.extra
        plots = []
        for k, curve in enumerate(panel.curves):
            block = f"$p{number}_{k}"
            lines += [f"{block} << EOD"] + [f"{x:.8g} {y:.8g}" for x, y in curve.points] + ["EOD"]
            plots.append(f"{block} using 1:2 with {curve.style} lc rgb '{curve.colour}' lw 2 dt {curve.dash} "
                         f"pt {curve.mark} ps 0.6 title \"{escape(curve.label)}\"" if curve.style != "lines" else
                         f"{block} using 1:2 with lines lc rgb '{curve.colour}' lw 1.5 dt {curve.dash} "
                         f"title \"{escape(curve.label)}\"")
            if curve.rings:
                lines += [f"{block}r << EOD"] + [f"{x:.8g} {y:.8g}" for x, y in curve.rings] + ["EOD"]
                plots.append(f"{block}r using 1:2 with points pt 6 ps 1.7 lw 2.5 lc rgb '{curve.colour}' notitle")
            if curve.texts:
                lines += [f"{block}t << EOD"] + [f'{x:.8g} {y:.8g} "{t}"' for x, y, t in curve.texts] + ["EOD"]
                plots.append(f"{block}t using 1:2:3 with labels offset 1.2,0.6 font ',10' tc rgb '{curve.colour}' "
                             "notitle")
        lines.append("plot " + ", \\\n  ".join(plots))
    gnuplot(lines + ["unset multiplot"])
    print(f"charts: {path}")


def step_ms(row):
    return row["forward_ms"] + row["backward_ms"]


def least_ms(row):
    """The least time of a step: two of them compare where medians fall into different moods of the machine."""
    return row["forward_least_ms"] + row["backward_least_ms"]


def at_tolerance(rows, tolerance):
    return next((r for r in rows if near(r["tolerance"], tolerance)), None)


def work_precision(results, charts, scene):
    """Error against time per step over the tolerance, a curve for each method and set of cells."""
    rows = [r for r in read(results, "step_tolerance") if str(r["scene"]).split(":")[0] == scene]
    rows = [r for r in rows if r["threads"] == 1 and r["integrator"] == "euler"]
    groups = {}
    for r in rows:
        box = r["threshold"] == 0
        if box == (r["scene"] == scene):  # the exact answer of the row's own cells
            groups.setdefault((r["method"], box), []).append(r)
    for group in groups.values():
        group.sort(key=lambda r: -r["tolerance"])
    if not groups:
        return
    panels = []
    for error, name in (("state_error", "state"), ("gradient_error", "gradient")):
        curves = []
        for (method, box), group in sorted(groups.items()):
            good = [r for r in group if r[error] > 0]
            curves.append(Curve(f"{method}, {'full box' if box else 'active cells'}", METHOD_COLOURS[method],
                                [(step_ms(r), r[error]) for r in good], dash=2 if box else 1,
                                mark=5 if method == "reference" else 7,
                                rings=[(step_ms(r), r[error]) for r in good
                                       if method == "newton_pcg" and not box and near(r["tolerance"], 1e-6)]))
        panels.append(Panel(f"Error of the {name}, tolerances from 1e-1 to 1e-10",
                            "forward and backward step (ms, one core)", f"relative error of the {name}", curves))
    title = f"{SCENES.get(scene, scene)}: work against precision"
    ours, box = groups.get(("newton_pcg", False)), groups.get(("newton_pcg", True))
    textbook = groups.get(("reference", True))
    if ours and box and textbook and all(at_tolerance(g, 1e-6) for g in (ours, box, textbook)):
        slow, full, fast = (step_ms(at_tolerance(g, 1e-6)) for g in (textbook, box, ours))
        title += (f": at a residual of 1e-6 {slow / fast:.0f} times faster than the textbook method, "
                  f"{slow / full:.0f} by the solver and {full / fast:.1f} by fewer cells")
    elif ours and groups.get(("projective", False)):
        slow, fast = (at_tolerance(groups[m, False], 1e-6) for m in ("projective", "newton_pcg"))
        if slow and fast:
            title += f": at a residual of 1e-6 newton_pcg takes {step_ms(fast) / step_ms(slow):.2f} of projective's time"
    draw(charts / f"work_precision_{scene}.svg", title, panels)


def rollout(results, charts, scene):
    """Error of a second of swimming over the time step."""
    rows = [r for r in read(results, "rollout") if r["scene"] == scene and r["threads"] == 1]
    plain = [r for r in rows if r["method"] == "newton_pcg" and r["checkpoint_mib"] == 0]
    if not plain:
        return
    panels, slopes = [], {}
    for error, name in (("loss_error", "loss"), ("gradient_error", "gradient")):
        curves = []
        for integrator, colour in (("euler", BLUE), ("bdf2", PURPLE)):
            group = {r["h"]: r for r in sorted(plain, key=lambda r: -r["h"])
                     if r["integrator"] == integrator and r[error] > 0}
            time = {h: 1e-3 * step_ms(r) for h, r in group.items()}
            curves.append(Curve({"euler": "implicit Euler", "bdf2": "BDF2"}[integrator], colour,
                                [(time[h], r[error]) for h, r in group.items()],
                                rings=[(time[h], r[error]) for h, r in group.items()
                                       if integrator == "euler" and near(h, DEFAULT_H)],
                                texts=[(time[h], r[error], f"1/{1 / h:.0f}") for h, r in group.items()]))
            if len(group) > 1 and error == "loss_error":
                slopes[integrator] = group[min(group)][error]
        for r in rows:
            if r["method"] == "reference" and r[error] > 0:
                curves.append(Curve(f"reference, tolerance {sci(r['tolerance'])}", RED,
                                    [(1e-3 * step_ms(r), r[error])], mark=5 if r["tolerance"] > 1e-3 else 4))
        panels.append(Panel(f"Error of the {name} (labels: h in s)", "forward and backward rollout (s, one core)",
                            f"relative error of the {name}", curves))
    shortest = min(r["h"] for r in plain)
    title = f"{SCENES.get(scene, scene)}, {plain[0]['steps'] * plain[0]['h']:.1g} s of swimming"
    if len(slopes) == 2:
        title += (f": at h = 1/{1 / shortest:.0f} s BDF2's loss is off by {100 * slopes['bdf2']:.2g} %, "
                  f"implicit Euler's by {100 * slopes['euler']:.2g} %")
    draw(charts / f"rollout_{scene}.svg", title, panels)


def threshold(results, charts):
    """Error against the full box over the threshold of active cells."""
    rows = [r for r in read(results, "step_threshold") if ":" not in r["scene"] and r["threads"] == 1]
    rows = [r for r in rows if r["method"] == "newton_pcg" and r["integrator"] == "euler"]
    rows.sort(key=lambda r: -r["threshold"])
    scenes = [s for s in SCENES if any(r["scene"] == s for r in rows)]
    if not scenes:
        return
    panels, parts = [], []
    for error, name in (("state_error", "state"), ("gradient_error", "gradient")):
        curves = []
        for scene, colour in zip(scenes, FIVE):
            group = [r for r in rows if r["scene"] == scene and r["threshold"] > 0 and r[error] > 0]
            curves.append(Curve(SCENES[scene], colour, [(step_ms(r), r[error]) for r in group],
                                rings=[(step_ms(r), r[error]) for r in group if near(r["threshold"], DEFAULT_THRESHOLD)],
                                texts=[(step_ms(r), r[error], f"{r['threshold']:g}") for r in group]))
            full = next((r for r in rows if r["scene"] == scene and r["threshold"] == 0), None)
            if full:
                lows = [r[error] for r in group] or [1e-6]
                curves.append(Curve(f"{SCENES[scene]}, full box", colour,
                                    [(step_ms(full), 0.3 * min(lows)), (step_ms(full), 1.0)], dash=3, style="lines"))
                usual = next((r for r in group if near(r["threshold"], DEFAULT_THRESHOLD)), None)
                if usual and name == "state":
                    parts.append(f"{step_ms(full) / step_ms(usual):.1f} times faster than the full box, state within "
                                 f"{100 * usual[error]:.2g} % ({SCENES[scene]})")
        panels.append(Panel(f"Error of the {name} against the full box (labels: threshold)",
                            "forward and backward step (ms, one core)", f"relative error of the {name}", curves))
    draw(charts / "threshold.svg", "Threshold 0.02: " + "; ".join(parts[:2]), panels, height=540)


def adjoint(results, charts):
    """Error of the gradient over the time of a backward step as the adjoints' tolerance tightens."""
    rows = read(results, "step_adjoint")
    if not rows:
        return
    rows.sort(key=lambda r: -r["adjoint_tolerance"])
    panels = []
    for scene in (s for s in SCENES if any(r["scene"] == s for r in rows)):
        curves = []
        own = [r for r in rows if r["scene"] == scene and r["gradient_error"] > 0]
        for tolerance, colour in zip(sorted({r["tolerance"] for r in own}, reverse=True), FIVE):
            group = [r for r in own if r["tolerance"] == tolerance]
            curves.append(Curve(f"states to {sci(tolerance)}", colour,
                                [(r["adjoint_iterations"], r["gradient_error"]) for r in group],
                                texts=[(r["adjoint_iterations"], r["gradient_error"], sci(r["adjoint_tolerance"]))
                                       for r in group]))
        panels.append(Panel(f"{SCENES[scene]} (labels: tolerance of the adjoints)", "iterations of an adjoint step",
                            "relative error of the gradient", curves, log="y"))
    draw(charts / "adjoint.svg", "How far adjoints need to be solved: until the error of the states takes over", panels)


def quadrature(results, charts):
    """Error of the state over time: eight integration points a cell against one, larger cells and smaller."""
    rows = read(results, "step_quadrature")
    panels = []
    for scene in (s for s in SCENES if any(r["scene"] == s for r in rows)):
        own = [r for r in rows if r["scene"] == scene]
        curves = []
        for name, label, colour in (("full", "eight points a cell", ORANGE), ("reduced", "one point a cell", BLUE)):
            group = sorted((r for r in own if r["quadrature"] == name), key=lambda r: r["active_cells"])
            least = max(r["cells_per_cell"] for r in own)
            points = [(step_ms(r), r["state_error"]) for r in group if r["cells_per_cell"] < least]
            curves.append(Curve(label, colour, points, texts=[
                (*point, f"{r['active_cells']:.0f} cells") for point, r in zip(points, group)]))
            apart = [r["state_error"] for r in group if r["cells_per_cell"] == least]
            if apart and points:
                ends = min(p[0] for c in curves for p in c.points), max(p[0] for c in curves for p in c.points)
                curves.append(Curve("they still differ by, on the finest grid", BLACK,
                                    [(x, apart[0]) for x in ends], dash=3, style="lines"))
        steps = own[0]["steps"]
        panels.append(Panel(f"{SCENES[scene]}, {steps:.0f} steps", "forward and backward step (ms, one core)",
                            "relative error of the state", curves))
    if panels:
        draw(charts / "quadrature.svg", "Against cells of a quarter of the size",
             panels, width=640 * len(panels))


MODELS = {"planar": "planar", "plane": "2-D", "no_water": "no water"}


def model(results, charts):
    """Errors of simpler scenes over their time, beside the time of the full one."""
    rows = read(results, "step_model")
    scenes = [s for s in SCENES if any(r["scene"] == s for r in rows)]
    if not scenes:
        return
    panels, parts = [], []
    for error in ("state", "travel", "gradient"):
        curves = []
        for scene, colour in zip(scenes, FIVE):
            group = [r for r in rows if r["scene"] == scene and r["model"] in MODELS and r[f"{error}_error"] > 0]
            points = [(step_ms(r), r[f"{error}_error"]) for r in group]
            curves.append(Curve(f"{SCENES[scene]} (dotted: full scene)", colour, points, style="points",
                                texts=[(*point, MODELS[r["model"]]) for point, r in zip(points, group)]))
            whole = next((r for r in rows if r["scene"] == scene and r["model"] == "full"), None)
            if whole and points:
                curves.append(Curve("", colour, [(step_ms(whole), 0.3 * min(y for _, y in points)),
                                                 (step_ms(whole), 3.0)], dash=3, style="lines"))
            plane = next((r for r in group if r["model"] == "plane"), None)
            if whole and plane and error == "travel":
                parts.append(f"{step_ms(whole) / step_ms(plane):.0f} times faster, travel off by "
                             f"{100 * plane['travel_error']:.2g} % ({SCENES[scene]})")
        panels.append(Panel(f"Error of the {error}", "forward and backward step (ms, one core)",
                            f"relative error of the {error}", curves, extra=["set xrange [*<1:*]"]))
    title = "Simpler scenes against the full one" + (". In two dimensions: " + "; ".join(parts) if parts else "")
    draw(charts / "model.svg", title, panels, width=1320)


def slope(points):
    xs, ys = [math.log(x) for x, _ in points], [math.log(y) for _, y in points]
    mx, my = sum(xs) / len(xs), sum(ys) / len(ys)
    return sum((x - mx) * (y - my) for x, y in zip(xs, ys)) / sum((x - mx) ** 2 for x in xs)


def scaling(results, charts):
    """Time and memory over active cells; speed-up over threads."""
    rows = read(results, "step_scaling")
    if not rows:
        return
    rows.sort(key=lambda r: (r["active_cells"], r["threads"]))
    one = [r for r in rows if r["threads"] == 1]
    times = [Curve(label, colour, [(r["active_cells"], r[key]) for r in one if r[key] > 0])
             for label, colour, key in (("set-up", GREEN, "setup_ms"), ("forward step", BLUE, "forward_ms"),
                                        ("backward step", ORANGE, "backward_ms"))]
    panels = [Panel("Time, one core", "active cells", "time (ms)", times),
              Panel("Peak memory of the process", "active cells", "peak (MiB)",
                    [Curve("peak", PURPLE, [(r["active_cells"], r["peak_mib"]) for r in one])])]
    threads = sorted({r["threads"] for r in rows})
    title = "One step over active cells"
    if len(one) > 1:
        exponents = [slope(c.points) for c in times]
        title += f": set-up grows as n^{exponents[0]:.2f}, forward as n^{exponents[1]:.2f}, backward as n^{exponents[2]:.2f}"
    if len(threads) > 1:
        curves = []
        for (grid, base), colour in zip([(r["grid"], r) for r in one], FIVE):
            group = [r for r in rows if r["grid"] == grid]
            curves.append(Curve(f"{grid}", colour, [(r["threads"], least_ms(base) / least_ms(r)) for r in group]))
        ideal = Curve("ideal", BLACK, [(threads[0], threads[0]), (threads[-1], threads[-1])], dash=3, style="lines")
        panels.append(Panel("Speed-up of a step (least times)", "threads", "speed-up", curves + [ideal], log="",
                            extra=["set xtics 1", "set yrange [0.5:*]"]))
    draw(charts / "scaling.svg", title, panels, width=1320)


def barycenter(results, charts):
    """Error and vertex IoU against time, over sigma, method and tolerance."""
    rows = [r for r in read(results, "barycenter") if r["threads"] == 1]
    if not rows:
        return
    rows.sort(key=lambda r: -r["tolerance"])
    bases, grid = rows[0]["bases"], rows[0]["grid"]
    rows = [r for r in rows if r["bases"] == bases and r["grid"] == grid]
    methods = sorted({r["method"] for r in rows})
    sigmas = sorted({r["sigma"] for r in rows})
    shown = DEFAULT_SIGMA if any(near(s, DEFAULT_SIGMA) for s in sigmas) else sigmas[0]
    time = lambda r: r["forward_ms"] + r["pullback_ms"]
    by_error, by_gradient, by_iou = [], [], []
    for method, colour in zip(methods, FIVE):
        group = [r for r in rows if r["method"] == method]
        at_sigma = [r for r in group if near(r["sigma"], shown)]
        for curves, key in ((by_error, "marginal_error"), (by_gradient, "gradient_error")):
            good = [r for r in at_sigma if r[key] > 0]
            curves.append(Curve(method, colour, [(time(r), r[key]) for r in good],
                                rings=[(time(r), r[key]) for r in good if near(r["tolerance"], 1e-9)]))
        tightest = {r["sigma"]: r for r in group}  # the last of each is that of the least tolerance
        tightest = dict(sorted(tightest.items()))
        by_iou.append(Curve(method, colour, [(time(r), r["vertex_iou"]) for r in tightest.values()],
                            texts=[(time(r), r["vertex_iou"], f"{s:g}") for s, r in tightest.items()],
                            rings=[(time(r), r["vertex_iou"]) for s, r in tightest.items() if near(s, DEFAULT_SIGMA)]))
    panels = [Panel(f"Marginal error, sigma {shown:g}", "barycentre and pullback (ms, one core)", "marginal error",
                    by_error),
              Panel(f"Error of the gradient, sigma {shown:g}", "barycentre and pullback (ms, one core)",
                    "relative error of the gradient", by_gradient),
              Panel("Shape at a vertex (labels: sigma)", "barycentre and pullback (ms, one core)",
                    "IoU with the base shape", by_iou, log="x")]
    panels = [p for p in panels if p.curves]
    best = max(r["vertex_iou"] for r in rows if near(r["sigma"], shown))
    draw(charts / "barycenter.svg", f"Barycentre of {bases:.0f} bases on {grid}: at sigma {shown:g} a vertex gives its "
         f"shape back to IoU {best:.3f}", panels, width=1320)


def schedule(results, charts):
    """Loss of the last stage over the CPU seconds spent, with and without a schedule, a panel for each start."""
    rows = read(results, "schedule")
    if not rows:
        return
    starts = list(dict.fromkeys(str(r["start"]) for r in rows))
    names = list(dict.fromkeys(str(r["schedule"]) for r in rows))
    panels, gains = [], []
    for start in starts:
        curves, reached = [], {}
        runs = {name: [r for r in rows if str(r["start"]) == start and str(r["schedule"]) == name] for name in names}
        runs = {name: group for name, group in runs.items() if group}
        lasts = {name: [r for r in group if r["stage"] == group[-1]["stage"]] for name, group in runs.items()}
        # Where the run without a schedule ends up, to a hundredth.
        least = min(r["loss"] for r in lasts[next(iter(lasts))])
        for (name, group), colour in zip(runs.items(), FIVE):
            last = lasts[name]
            reached[name] = next((r["seconds"] for r in last if r["loss"] <= least + 0.01 * abs(least)), None)
            at = next((r for r in last if r["seconds"] == reached[name]), None)
            label = f"schedule {name}" if name != "none" else "no schedule"
            curves.append(Curve(label, colour, [(r["seconds"], r["loss"]) for r in last],
                                rings=[(at["seconds"], at["loss"])] if at else ()))
            if len(last) < len(group):
                curves.append(Curve(f"{name}, its coarser stages (losses of their own)", colour,
                                    [(r["seconds"], r["loss"]) for r in group if r not in last], dash=3, style="lines"))
        times = list(reached.values())
        if len(times) > 1 and times[0] and times[1]:
            gains.append(f"{times[1]:.1f} s instead of {times[0]:.1f} s")
        panels.append(Panel(f"Start {start} (ring: within 1 % of the least loss without)", "CPU seconds", "loss (m)",
                            curves, log="", extra=["set xrange [0:*]", "set lmargin 12"]))
    title = "Coarse and loose first" + (": as low a loss after " + " and ".join(gains) if gains else "")
    draw(charts / "schedule.svg", title, panels)


# Colour and letter both tell the outcome; the first is what nearly every tile is, and stays without a letter.
OUTCOMES = {"accurate": (SKY, "", "right (state to 1e-4, gradient to 1e-3)"),
            "reported": (ORANGE, "R", "R: not solved, and said so"), "silent": (RED, "S", "S: wrong, silently"),
            "nan": (BLACK, "N", "N: not a number")}
PANELS = [("young_modulus", "time_step"), ("contraction", "time_step"), ("flow", "time_step"),
          ("occupancy_floor", "threshold"), ("sigma", "separation")]
OURS = ("newton_pcg", "newton")  # of scenes, of barycentres
AXES = {"young_modulus": "Young's modulus (Pa)", "time_step": "time step (s)",
        "contraction": "contraction at full stroke", "flow": "flow (body lengths/s)",
        "occupancy_floor": "stiffness of the void", "threshold": "threshold of cells",
        "sigma": "width of the kernel (cells)", "separation": "separation (cells)", "none": ""}


def value_text(axis, value):
    if axis == "time_step":
        return f"1/{1 / value:.0f}"
    return sci(value) if value and (abs(value) >= 1e4 or abs(value) < 5e-3) else f"{value:g}"


def tiles(name, places, half):
    """Gnuplot data and plots of tiles: places by outcome, half a tile's width and height."""
    lines, plots = [], []
    for outcome, (colour, letter, _) in OUTCOMES.items():
        block = f"${name}_{outcome}"
        lines += [f"{block} << EOD"] + [f'{x:g} {y:g} "{letter}"' for x, y in places.get(outcome) or [(-99, -99)]] + ["EOD"]
        plots.append(f"{block} using 1:2:({half[0]}):({half[1]}) with boxxyerror fs solid 1.0 noborder "
                     f"lc rgb '{colour}' notitle")
        if letter:
            plots.append(f"{block} using 1:2:3 with labels font ',9' tc rgb '#ffffff' notitle")
    return lines, plots


def places_of(rows, place):
    out = {}
    for row in rows:
        out.setdefault(row["outcome"], []).append(place(row))
    return out


def stability_panels(rows):
    """A row of panels of the library, and one of the textbook method, a column for each pair of axes."""
    lines, number = [], 0
    for k, (colour, _, text) in enumerate(OUTCOMES.values()):
        lines.append(f"set label {k + 1} \"■ {text}\" at screen {(0.05, 0.37, 0.61, 0.79)[k]},0.408 left font ',12' "
                     f"tc rgb '{colour}'")
    for line, (name, wanted) in enumerate((("libdiffaqua", OURS), ("reference", ("reference",)))):
        for column, (x, y) in enumerate(PANELS):
            every = [r for r in rows if (r["axis_x"], r["axis_y"]) == (x, y)]
            xs, ys = (sorted({r[k] for r in every}) for k in ("value_x", "value_y"))
            group = [r for r in every if r["method"] in wanted]
            lines += [f"set origin {column / 5 + 0.004},{(0.68, 0.415)[line]}", "set size 0.196,0.265",
                      f"set title \"{name}\" font ',12' offset 0,-0.5",
                      f"set xlabel \"{escape(AXES[x])}\" font ',11' offset 0,0.3",
                      f"set ylabel \"{escape(AXES[y])}\" font ',11' offset {0.5 if y == 'separation' else 2},0",
                      f"set xrange [-0.6:{max(0, len(xs) - 1) + 0.6}]", f"set yrange [-0.6:{max(0, len(ys) - 1) + 0.6}]"]
            for axis, values, label in (("x", xs, x), ("y", ys, y)):
                marks = ", ".join(f"'{value_text(label, v)}' {k}" for k, v in enumerate(values))
                lines.append(f"set {axis}tics ({marks}) scale 0 font ',9'" + (" rotate by -50" if axis == "x" else ""))
            data, plots = tiles(f"p{number}", places_of(group, lambda r: (xs.index(r["value_x"]), ys.index(r["value_y"]))),
                                (0.47, 0.47))
            number += 1
            lines += data + ["plot " + ", ".join(plots)] + [f"unset label {k + 1}" for k in range(len(OUTCOMES))]
    return lines


def stability_strips(rows):
    """All other cells: a strip for each pair of axes and method, or for each single axis with all its methods."""
    strips = {}
    for r in rows:
        pair = (r["axis_x"], r["axis_y"])
        if pair in PANELS and r["method"] not in OURS + ("reference",):
            strips.setdefault(f"{r['axis_x']}, {r['axis_y']}: {r['method']}", []).append(r)
        elif pair not in PANELS:
            reference = r["method"].startswith("reference")
            strips.setdefault(f"{r['axis_x']}: {r['method']}" if reference else r["axis_x"], []).append(r)
    if not strips:
        return []
    # In two columns, each as long as its longest strip.
    half = (len(strips) + 1) // 2
    lines = []
    for column in range(2):
        part = list(strips.items())[column * half:(column + 1) * half]
        if not part:
            continue
        longest = max(len(group) for _, group in part)
        tics = ", ".join(f"\"{escape(name)}\" {-k}" for k, (name, _) in enumerate(part))
        places = {}
        for k, (_, group) in enumerate(part):
            for outcome, found in places_of(group, lambda r, k=k, group=group: (group.index(r), -k)).items():
                places.setdefault(outcome, []).extend(found)
        lines += [f"set origin {0.5 * column},0", "set size 0.5,0.4", "unset title", "unset xlabel", "unset ylabel",
                  "unset xtics", f"set xrange [-0.6:{longest - 0.4}]", f"set yrange [{-half + 0.4}:0.6]",
                  f"set ytics ({tics}) scale 0 font ',10' norotate", "set lmargin 37", "set rmargin 1", "set bmargin 2.5",
                  "set tmargin 1"]
        data, plots = tiles(f"s{column}", places, (0.44, 0.4))
        lines += data + ["plot " + ", ".join(plots)]
    return lines


def stability(results, charts):
    """Outcome over pairs of settings, the library above the textbook method; the other cells in strips."""
    rows = read(results, "stability_map")
    if not rows:
        return
    counts = {}
    for r in rows:
        name = "reference" if str(r["method"]).startswith("reference") else "libdiffaqua"
        counts.setdefault(name, []).append(r["outcome"])
    title = "Far beyond reason: " + "; ".join(
        f"{name} is right in {found.count('accurate')} of {len(found)} cases, says so in {found.count('reported')} and is "
        f"wrong in silence in {found.count('silent') + found.count('nan')}" for name, found in counts.items())
    path = charts / "stability.svg"
    lines = header(path, title, 1320, 1240, "1,1") + ["unset grid", "unset key", "set border 0", "unset colorbox"]
    lines = [line for line in lines if not line.startswith("set multiplot")]
    wrapped = "\\n".join(textwrap.wrap(escape(title), 150))
    lines += [f"set multiplot title \"{wrapped}\" font ',15'", "set lmargin 9", "set rmargin 0.2", "set bmargin 5",
              "set tmargin 1.5"]
    gnuplot(lines + stability_panels(rows) + stability_strips(rows) + ["unset multiplot"])
    print(f"charts: {path}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--results", type=pathlib.Path, default=HERE / "results")
    parser.add_argument("--charts", type=pathlib.Path, default=HERE / "charts")
    parser.add_argument("names", nargs="*")
    options = parser.parse_args()
    options.charts.mkdir(parents=True, exist_ok=True)
    jobs = {f"work_precision_{s}": lambda s=s: work_precision(options.results, options.charts, s) for s in SCENES}
    jobs |= {f"rollout_{s}": lambda s=s: rollout(options.results, options.charts, s) for s in SCENES}
    jobs |= {f.__name__: lambda f=f: f(options.results, options.charts)
             for f in (threshold, adjoint, quadrature, model, scaling, barycenter, schedule, stability)}
    for name in options.names:
        if name not in jobs:
            sys.exit(f"charts: there is no chart '{name}'; there are {', '.join(jobs)}")
    for name, job in jobs.items():
        if not options.names or name in options.names:
            job()


if __name__ == "__main__":
    main()
