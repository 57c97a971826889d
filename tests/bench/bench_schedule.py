#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs codesign with and without a schedule from the same starts and compares them by CPU seconds, which other work on
the machine disturbs less than the wall clock.

    bench_schedule.py [options] CODESIGN [option of codesign ...]
      --csv FILE         a row per iteration: start, schedule, iteration, stage, seconds, loss, weights
      --starts LIST      of shares of the meshes, separated by spaces (equal shares; mostly goldfish)
      --schedules LIST   texts of codesign's --schedule, separated by spaces ("none coarse")
      --quick            a coarser grid, fewer steps and one start: half a minute

What follows CODESIGN replaces the task used otherwise: the shares of the four shapes of codesign without meshes under
a fixed sine. From the second start the iterations end in a local optimum without a schedule. `seconds` are CPU seconds of
all threads since the start of the program: shapes and the proof of the gradient (the same work in both) included, files
and picture not. Losses of different stages are not comparable; those of the last stage are, between all schedules.
"""
import argparse
import csv
import os
import pathlib
import resource
import subprocess
import sys
import tempfile

STARTS = ["0.25,0.25,0.25,0.25", "0.1,0.1,0.1,0.7"]
SCENE = ["--fixed-control", "--grid", "48x12x20", "--steps", "30", "--iterations", "25"]
QUICK = ["--fixed-control", "--grid", "48x10x16", "--steps", "10", "--iterations", "20"]
CLOSE = 0.01


def children_seconds():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def run(program, options, start, schedule):
    """Rows of one run, and the CPU seconds of all of it."""
    with tempfile.TemporaryDirectory(prefix="schedule-") as folder:
        before = children_seconds()
        done = subprocess.run([program, "--threads", "1", *options, "--weights", start, "--schedule", schedule, "--out",
                               os.path.join(folder, "out")], text=True, capture_output=True, check=False)
        if done.returncode != 0:
            sys.exit(f"bench_schedule: codesign ended with {done.returncode}: {done.stderr}")
        total = children_seconds() - before
        with open(os.path.join(folder, "out", "history.csv"), newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file)), total


def reached(rows, target):
    """CPU seconds at which the last stage first had a loss of `target` or less; None: never."""
    last = rows[-1]["stage"]
    return next((float(r["cpu_seconds"]) for r in rows if r["stage"] == last and float(r["loss"]) <= target), None)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--csv", type=pathlib.Path)
    parser.add_argument("--starts", default=" ".join(STARTS))
    parser.add_argument("--schedules", default="none coarse")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("program")
    parser.add_argument("options", nargs=argparse.REMAINDER)
    o = parser.parse_args()
    options = o.options or (QUICK if o.quick else SCENE)
    starts = o.starts.split()[:1] if o.quick else o.starts.split()
    table, weights = [], []
    for start in starts:
        least = goal = None
        for schedule in o.schedules.split():
            rows, total = run(o.program, options, start, schedule)
            weights = [name for name in rows[0] if name.startswith("weight_")]
            last = [r for r in rows if r["stage"] == rows[-1]["stage"]]
            best = min(last, key=lambda r: float(r["loss"]))
            if least is None:
                least = float(best["loss"])
                goal = least + CLOSE * abs(least)
            at = reached(rows, goal)
            print(f"start {start}  schedule {schedule:8}  iterations {len(rows):3} ({len(last)} in the last stage)  "
                  f"CPU {total:6.2f} s  best loss {float(best['loss']):.6f}  within {100 * CLOSE:g} % of the first after "
                  f"{'-' if at is None else f'{at:.2f} s'}  weights "
                  + ",".join(f"{float(best[name]):.3f}" for name in weights), flush=True)
            for r in rows:
                table.append([start.replace(",", " "), schedule, r["iteration"], r["stage"], r["cpu_seconds"], r["loss"],
                              *(r[name] for name in weights)])
    if o.csv:
        with open(o.csv, "w", newline="", encoding="utf-8") as file:
            csv.writer(file, lineterminator="\n").writerows(
                [["start", "schedule", "iteration", "stage", "seconds", "loss", *weights], *table])


if __name__ == "__main__":
    main()
