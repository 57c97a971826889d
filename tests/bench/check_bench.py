#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs a benchmark on a small scene and checks its columns and that errors are what each method promises; no timings.

    check_bench.py step|rollout|parts|map PROGRAM
    check_bench.py schedule CODESIGN
    check_bench.py charts
"""
import csv
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

HERE = pathlib.Path(__file__).resolve().parent
STEP = ("scene,grid,active_cells,threshold,method,integrator,precision,tolerance,threads,setup_ms,forward_ms,"
        "backward_ms,newton_iterations,linear_iterations,adjoint_iterations,residual,state_error,gradient_error,peak_mib,"
        "forward_least_ms,backward_least_ms")
ROLLOUT = ("scene,grid,active_cells,method,integrator,steps,h,tolerance,threads,checkpoint_mib,forward_ms,backward_ms,"
           "loss,loss_error,gradient_error,peak_mib")
QUADRATURE = "scene,grid,active_cells,quadrature,cells_per_cell,steps,forward_ms,backward_ms,state_error"
ADJOINT = ("scene,grid,active_cells,threshold,tolerance,adjoint_tolerance,adjoint_iterations,backward_ms,"
           "gradient_error")
MODEL = "scene,grid,active_cells,model,steps,forward_ms,backward_ms,state_error,travel_error,gradient_error"
PARTS = "scene,grid,active_cells,part,precision,threads,kib,bandwidth_gb_s,bound_us,time_us,times_bound,speed_up"
WORDS = {"scene", "grid", "method", "integrator", "precision", "part", "quadrature", "model"}


def require(good, *what):
    if not good:
        sys.exit("check_bench: " + " ".join(str(w) for w in what))


def rows_of(program, header, *options):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "out.csv"
        done = subprocess.run([program, "--csv", path, *options], text=True, capture_output=True, check=False)
        print(done.stdout, done.stderr)
        require(done.returncode == 0, program, *options, "ended with", done.returncode)
        lines = path.read_text(encoding="utf-8").splitlines()
    require(lines[0] == header, "the header is", lines[0])
    rows = list(csv.DictReader(lines))
    for row in rows:
        for key, text in row.items():
            if key not in WORDS:
                row[key] = float(text)
                require(math.isfinite(row[key]), key, "is", text, "in", row)
        for key in ("active_cells", "forward_ms", "backward_ms", "tolerance", "threads", "peak_mib", "time_us"):
            require(row.get(key, 1) > 0, key, "is", row.get(key), "in", row)
    return rows


def stability_map(program):
    """A map that was interrupted ends as one that was not."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "map.csv"

        def run(*options):
            done = subprocess.run([program, "--quick", "--only", "start_speed", "--csv", path, *options], text=True,
                                  capture_output=True, check=False)
            require(done.returncode == 0, done.stdout, done.stderr)
            return done.stdout

        run()
        whole = path.read_text(encoding="utf-8")
        rows = list(csv.DictReader(whole.splitlines()))
        require([r["method"] for r in rows] == ["newton_pcg" + v for v in ("", "/volume", "/neo-Hookean", "/bdf2")], rows)
        require(all(r["outcome"] == "accurate" and float(r["state_error"]) <= 1e-4 for r in rows), whole)
        # A line that was cut short does not count, and what is kept is not worked on again.
        lines = whole.splitlines()
        kept = lines[2].replace(",4,", ",3,")
        path.write_text("\n".join([lines[0], lines[1], kept, lines[3][:-9]]), encoding="utf-8")
        require("2 of 4 rows" in run("--resume"), "rows were not kept")
        require(path.read_text(encoding="utf-8") == whole.replace(lines[2], kept), path.read_text(encoding="utf-8"))


def step(program):
    rows = rows_of(program, STEP, "--quick", "--grid", "24x8x8", "--repeat", "1", "--steps", "2", "--algebraic",
                   "--threads", "1,2")
    kinds = {(r["scene"], r["method"], r["threshold"], r["tolerance"], r["threads"]) for r in rows}
    require(len(kinds) == len(rows), "a configuration was measured twice")
    for threads in (1, 2):
        for method in ("newton_pcg", "projective", "newton_direct"):
            for scene, threshold in (("eel", 0.0), ("eel", 0.02), ("eel:same_cells", 0.02)):
                require((scene, method, threshold, 1e-6, threads) in kinds, "no row of", scene, method, threshold)
    for tolerance in (1e-1, 1e-6):
        require(("eel", "reference", 0.0, tolerance, 1) in kinds, "no row of the reference at", tolerance)
    for r in rows:
        require(r["residual"] <= r["tolerance"], "residual above the tolerance in", r)
        require(r["precision"] == ("single" if r["method"] in ("newton_pcg", "projective") else "double"), r)
        require(0 < r["active_cells"] <= 24 * 8 * 8 and r["setup_ms"] > 0 and r["newton_iterations"] > 0, r)
        own_cells = r["threshold"] == 0 or r["scene"].endswith(":same_cells")
        if own_cells and r["tolerance"] <= 1e-6:
            require(r["state_error"] <= 1e-4 and r["gradient_error"] <= 1e-3, "inaccurate:", r)
        elif own_cells:
            require(r["state_error"] > 1e-3, "loose tolerances are not this accurate:", r)
        else:
            require(1e-6 < r["state_error"] <= 0.2, "fewer cells leave an error, but not this one:", r)
    answers = {}
    for r in rows:
        key = (r["scene"], r["method"], r["threshold"], r["tolerance"])
        value = (r["active_cells"], r["newton_iterations"], r["residual"], r["state_error"], r["gradient_error"])
        require(answers.setdefault(key, value) == value, "threads change the answer of", key)
    rows = rows_of(program, STEP, "--quick", "--grid", "24x8x8", "--repeat", "1", "--steps", "2", "--discretisation",
                   "--methods", "newton_pcg", "--threshold", "0.02", "--tolerance", "1e-6,1e-8", "--integrators", "bdf2")
    tags = {r["scene"] for r in rows if r["method"] == "newton_pcg"}
    require(tags == {"eel", "eel:h/8", "eel:dx/2"}, "rows of", tags)
    rows = rows_of(program, STEP, "--quick", "--grid", "24x8x8", "--repeat", "1", "--steps", "2", "--methods",
                   "newton_pcg", "--threshold", "0", "--precision", "single,double", "--scenes", "shipped")
    require([r["precision"] for r in rows] == ["single", "double"], "precisions of", rows)
    require(all(r["state_error"] <= 1e-4 for r in rows), "inaccurate:", rows)
    for bad in (["--scenes", "whale"], ["--methods", "guess"], ["--tolerance", "small"], ["--steps", "0"], ["--no"], ["--precision", "half"]):
        done = subprocess.run([program, *bad], text=True, capture_output=True, check=False)
        require(done.returncode == 2 and done.stderr, *bad, "ended with", done.returncode)
    done = subprocess.run([program, "--indicator", "--scenes", "eel", "--grid", "24x8x8", "--steps", "6", "--repeat", "1",
                           "--threshold", "0.1,0.02,0.004"], text=True, capture_output=True, check=True)
    errors = [tuple(map(float, found)) for found in
              re.findall(r"tau (\S+) .*estimate (\S+) .*state error (\S+) .*gradient error (\S+) ", done.stdout)]
    require([e[0] for e in errors] == [0.1, 0.02, 0.004], "rows of the indicator:", done.stdout)
    require(errors[0][1] > errors[1][1] > errors[2][1] > 0, "estimates do not fall with the threshold:", errors)
    for threshold, estimate, state, gradient in errors:
        require(0.1 * estimate <= state <= estimate, "at threshold", threshold, "an error of", state, "of", estimate)
        require(0 < gradient, "no error of the gradient at threshold", threshold)
    adjoints(program)
    quadratures(program)
    models(program)


def adjoints(program):
    """Adjoints solved more exactly cost more, and help until the error of the states is all that is left."""
    rows = rows_of(program, ADJOINT, "--sweep", "adjoint", "--scenes", "eel", "--grid", "24x8x8", "--repeat", "1",
                   "--steps", "2")
    for tolerance in (1e-6, 1e-10):
        error = {r["adjoint_tolerance"]: r["gradient_error"] for r in rows if r["tolerance"] == tolerance}
        work = [r["adjoint_iterations"] for r in rows if r["tolerance"] == tolerance]
        require(len(error) == 10 and work == sorted(work) and work[0] < work[-1], "rows of", tolerance, work, error)
        require(error[1e-3] > 10 * error[1e-12], "the tolerance of adjoints does not matter:", error)
        require(error[tolerance] <= 3 * error[1e-12] + tolerance, "adjoints at the tolerance of states add:", error)


def quadratures(program):
    """Smaller cells lower the error with either quadrature, and one point a cell is no worse than eight."""
    rows = rows_of(program, QUADRATURE, "--sweep", "quadrature", "--scenes", "eel", "--grid", "32x8x12", "--repeat",
                   "1", "--steps", "3")
    error = {(r["quadrature"], r["cells_per_cell"]): r["state_error"] for r in rows}
    require(set(error) == {("full", 1), ("reduced", 1), ("full", 8), ("reduced", 8), ("reduced", 64)}, "rows:", error)
    for name in ("full", "reduced"):
        require(error[name, 1] > 1.2 * error[name, 8] > 0, name, "does not gain from smaller cells:", error)
    require(error["reduced", 8] > error["reduced", 64], "the finest grids disagree:", error)


def models(program):
    """What moves in a plane is right there, and nearly so in two dimensions; without water nothing swims."""
    rows = [r for scene, grid in (("eel", "24x8x8"), ("three", "32x30x14"))
            for r in rows_of(program, MODEL, "--sweep", "model", "--scenes", scene, "--grid", grid, "--repeat", "1",
                             "--steps", "10")]
    found = {(r["scene"], r["model"]): r for r in rows}
    require(set(found) == {("eel", m) for m in ("full", "planar", "plane", "no_water")}
            | {("three", m) for m in ("full", "planar", "no_water")}, "rows of", set(found))
    for (scene, name), row in found.items():
        errors = [row[f"{kind}_error"] for kind in ("state", "travel", "gradient")]
        if name == "full":
            require(0 < errors[0] <= 1e-4 and max(errors) <= 1e-3, "the full scene is not its own answer:", row)
        if scene == "three" and name == "planar":
            require(row["state_error"] > 0.05, "wings that cannot beat make no difference:", row)
        if name == "no_water":
            require(row["state_error"] > 0.01 and row["travel_error"] > 0.1, "water makes no difference:", row)
    eel = {m: found["eel", m] for m in ("planar", "plane")}
    require(eel["planar"]["state_error"] <= 0.02 and eel["planar"]["travel_error"] <= 1e-3, "planar:", eel)
    require(eel["plane"]["active_cells"] <= 24 * 8 and eel["plane"]["state_error"] <= 0.2, "in two dimensions:", eel)


def parts(program):
    rows = rows_of(program, PARTS, "--quick", "--scenes", "eel", "--grid", "24x8x8", "--threads", "1,2")
    names = {"single": ["body", "water", "multilevel", "vectors", "iteration"],
             "double": ["body", "water", "multilevel", "factor", "vectors", "iteration", "forces"]}
    require([(r["threads"], r["precision"], r["part"]) for r in rows]
            == [(t, p, n) for t in (1, 2) for p in names for n in names[p]], "rows of", rows)
    for r in rows:
        require(r["kib"] > 0 and r["bound_us"] > 0, r)
        require(abs(r["times_bound"] / (r["time_us"] / r["bound_us"]) - 1) <= 0.05, "times_bound of", r)
        require(r["threads"] > 1 or r["speed_up"] == 1, "speed-up of", r)
    for precision in names:
        of = {r["part"]: r["time_us"] for r in rows if (r["threads"], r["precision"]) == (1, precision)}
        total = sum(of[n] for n in ("body", "water", "multilevel", "vectors"))
        require(abs(of["iteration"] / total - 1) <= 0.01, "an iteration is not the sum of its parts:", of)


def rollout(program):
    rows = rows_of(program, ROLLOUT, "--quick", "--rates", "30,60,120", "--threads", "1,2")
    plain = {(r["integrator"], round(1 / r["h"])): r for r in rows
             if (r["method"], r["threads"], r["checkpoint_mib"]) == ("newton_pcg", 1, 0)}
    for integrator in ("euler", "bdf2"):
        for rate in (30, 60, 120):
            require((integrator, rate) in plain, "no row of", integrator, rate)
            require(plain[integrator, rate]["steps"] == round(0.2 * rate), plain[integrator, rate])
    for key in ("loss_error", "gradient_error"):
        coarse, fine, second = (plain[k][key] for k in (("euler", 30), ("euler", 120), ("bdf2", 120)))
        require(second < fine < coarse, key, "does not fall as it should:", coarse, fine, second)
    usual = plain["euler", 30]
    others = [r for r in rows if r["integrator"] == "euler" and round(1 / r["h"]) == 30 and r is not usual]
    require({r["checkpoint_mib"] for r in others} == {0, 64, 8}, "budgets of the tape are missing")
    for r in others:
        if r["method"] == "newton_pcg":
            same = all(r[key] == usual[key] for key in ("loss", "loss_error", "gradient_error"))
            require(same, "threads or checkpoints change the answer:", r)
    methods = {r["method"]: r for r in others}
    require(abs(methods["projective"]["loss"] / usual["loss"] - 1) <= 1e-3, "projective goes elsewhere")
    require("reference" in methods, "the reference is missing")


def compared(program):
    """The comparison of schedules: its columns, its stages, and the same optimum with and without."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "schedule.csv"
        done = subprocess.run([sys.executable, "-B", HERE / "bench_schedule.py", "--quick", "--csv", path, program],
                              text=True, capture_output=True, check=False)
        print(done.stdout, done.stderr)
        require(done.returncode == 0, "bench_schedule.py ended with", done.returncode)
        with open(path, newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
    best = {}
    for name, stages in (("none", {"1"}), ("coarse", {"1", "2"})):
        group = [r for r in rows if r["schedule"] == name]
        require({r["stage"] for r in group} == stages, "stages of", name)
        seconds = [float(r["seconds"]) for r in group]
        require(seconds == sorted(seconds) and seconds[0] > 0, "seconds of", name)
        for r in group:
            require(abs(sum(float(r[key]) for key in r if key.startswith("weight_")) - 1) <= 1e-9, "weights of", r)
        best[name] = min(float(r["loss"]) for r in group if r["stage"] == group[-1]["stage"])
    require(best["coarse"] <= best["none"] + 0.05 * abs(best["none"]), "the schedule loses the optimum:", best)


def charts(_=None):
    """Every chart is drawn from rows of the promised columns and is an SVG that holds its curves."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)

        def write(name, header, rows):
            (folder / f"{name}.csv").write_text("\n".join([header] + [",".join(map(str, r)) for r in rows]) + "\n",
                                                encoding="utf-8")

        def step_row(scene, cells, tau, method, tolerance, threads, ms, error):
            return [scene, f"{cells}x1x1", cells, tau, method, "euler", "single", tolerance, threads, ms, ms, ms, 5, 50,
                    40, tolerance, error, 10 * error, 12, ms, ms]

        write("step_tolerance", STEP, [
            step_row(scene, cells, tau, method, t, 1, ms * cells * (1 - math.log(t)), 10 * t)
            for scene, cells, tau in (("eel", 2560, 0), ("eel:same_cells", 488, 0.02))
            for method, ms in (("newton_pcg", 0.001), ("projective", 0.003), ("reference", 0.05))
            for t in (1e-1, 1e-3, 1e-6, 1e-9)])
        write("step_threshold", STEP, [step_row("eel", 500, tau, "newton_pcg", 1e-6, 1, 10 / (tau + 0.01), tau + 1e-6)
                                       for tau in (0.1, 0.02, 0.005, 0)])
        write("step_adjoint", "scene,grid,active_cells,threshold,tolerance,adjoint_tolerance,adjoint_iterations,"
              "backward_ms,gradient_error",
              [["eel", "40x8x8", 488, 0.02, tolerance, 10.0 ** -k, 10 * k, k, max(10.0 ** -k, tolerance)]
               for tolerance in (1e-6, 1e-10) for k in range(3, 12)])
        write("step_quadrature", QUADRATURE, [
            ["eel", "40x8x8", 500 * size, name, size, 20, ms * size, ms * size, 0.3 / size]
            for name, ms in (("full", 10), ("reduced", 7)) for size in (1, 8)])
        write("step_model", MODEL, [
            ["eel", "40x8x8", 500, name, 20, ms, ms, error, 2 * error, 3 * error]
            for name, ms, error in (("full", 5, 1e-7), ("planar", 5.1, 1e-3), ("plane", 1, 0.05), ("no_water", 6, 0.8))])
        write("step_scaling", STEP, [step_row("shipped", n, 0.02, "newton_pcg", 1e-6, threads, n ** 1.2 / threads, 1e-6)
                                     for n in (100, 1000) for threads in (1, 2)])
        write("rollout", ROLLOUT, [
            ["eel", "40x8x8", 488, "newton_pcg", name, n, 1 / n, 1e-6, 1, 0, 10 * n, 10 * n, 0.1, n ** -p, n ** -p, 12]
            for name, p in (("euler", 1), ("bdf2", 2)) for n in (15, 30, 60)])
        write("barycenter", "bases,grid,sigma,method,tolerance,threads,iterations,forward_ms,pullback_ms,marginal_error,"
              "vertex_iou,gradient_error,peak_mib",
              [[2, "60x16x26", sigma, method, t, 1, 50, 100 / sigma - ms * math.log(t), 30, t, 1 - 0.05 * sigma, 10 * t,
                60] for sigma in (0.4, 1.0) for method, ms in (("anderson", 5), ("plain", 50)) for t in (1e-3, 1e-9)])
        write("schedule", "start,schedule,iteration,stage,seconds,loss,weight_a,weight_b",
              [["0.5 0.5", name, k, 2 if k > own else 1, cost * k, -0.01 * (1 - 0.5 ** k), 0.5, 0.5]
               for name, own, cost in (("none", 0, 2), ("coarse", 6, 1)) for k in range(1, 12)])
        outcomes = ("accurate", "reported", "silent", "nan")
        planes = [("young_modulus", 1e4, "time_step", "newton_pcg"), ("contraction", 0.2, "time_step", "newton_pcg"),
                  ("flow", 1, "time_step", "newton_pcg/bdf2"), ("occupancy_floor", 1e-8, "threshold", "newton_pcg"),
                  ("sigma", 0.4, "separation", "newton"), ("poisson_ratio", 0.1, "none", "newton_pcg")]
        write("stability_map", "axis_x,value_x,axis_y,value_y,method,outcome,steps_done,residual,state_error,"
              "gradient_error,inverted_cells,max_speed,reason",
              [[x, first * 2 ** k, y, z, method, outcomes[k] if method == "reference" else "accurate", 4, 0, 0, 0, 0, 1, ""]
               for x, first, y, own in planes for k in range(4) for z in ((0.01, 0.1) if y != "none" else (0,))
               for method in (own, "reference")])
        done = subprocess.run([sys.executable, "-B", HERE / "charts.py", "--results", folder, "--charts", folder],
                              text=True, capture_output=True, check=False)
        require(done.returncode == 0, done.stdout, done.stderr)
        for name in ("work_precision_eel", "threshold", "adjoint", "quadrature", "model", "scaling", "rollout_eel",
                     "barycenter", "schedule", "stability"):
            path = folder / f"{name}.svg"
            require(path.exists(), name, "was not drawn:", done.stdout)
            texts = " ".join(xml.etree.ElementTree.parse(path).getroot().itertext())
            require(len(texts) > 100, name, "says next to nothing")
            if name == "stability":
                for text in ("libdiffaqua is right in 44 of 44 cases", "reference is right in 11 of 44", "in silence in 22"):
                    require(text in " ".join(texts.split()), "the chart of stability does not say", text, ":", texts)
        if len(sys.argv) > 2:  # kept for a look at them
            target = pathlib.Path(sys.argv[2])
            for path in folder.glob("*.svg"):
                (target / path.name).write_bytes(path.read_bytes())


if __name__ == "__main__":
    {"step": step, "rollout": rollout, "parts": parts, "map": stability_map, "schedule": compared, "charts": charts}[sys.argv[1]](*sys.argv[2:3])
