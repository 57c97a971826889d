#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The paper's smoke test at half resolution: under a fixed sine a shark swims and an orca does not, so a swimmer
between the two must turn into the shark, from the orca itself and from the middle.

test_smoke.py PROGRAM needs Orca.stl and GreatWhiteShark.stl in the folder named by DQA_TEST_DATA; without them it is
skipped (exit code 77)."""
import os
import sys
import tempfile

import results

# Adam moves a weight by 0.05 an iteration, so that from (1, 0) to (0.1, 0.9) takes at least 18.
# The kernel keeps its width in metres relative to the full grid (0.7 cells of 60 x 16 x 26 would be 0.35 here) only at the
# price of fins of half a cell that flicker as the weights change; one cell keeps the loss smooth.
SETTINGS = ["--fixed-control", "--grid", "30x8x14", "--sigma", "1", "--iterations", "40"]


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: test_smoke.py PROGRAM")
    data = os.environ.get("DQA_TEST_DATA", "")
    meshes = [os.path.join(data, name) for name in ("Orca.stl", "GreatWhiteShark.stl")]
    if not data or not all(map(os.path.exists, meshes)):
        print("skipped: DQA_TEST_DATA does not name a folder with Orca.stl and GreatWhiteShark.stl")
        return 77
    failures, orca_loss = 0, None
    with tempfile.TemporaryDirectory(prefix="codesign-smoke-") as root:
        for start in ("1,0", "0.5,0.5"):
            out = os.path.join(root, start)
            process = results.run(os.path.abspath(sys.argv[1]), *SETTINGS, "--weights", start, "--out", out, *meshes,
                                  timeout=1800)
            if process.returncode != 0:
                print(f"from {start}: exit code {process.returncode}\n{process.stderr}")
                return 1
            summary = results.read_summary(out)
            if orca_loss is None:
                orca_loss = summary["loss_first"]
            shark, loss = summary["last"]["weights"][1], summary["last"]["loss"]
            good = shark >= 0.9 and loss < orca_loss
            failures += not good
            print(f"from {start}: shark {shark:.3f} (wanted >= 0.9), loss {loss:.5f} m (orca {orca_loss:.5f} m), "
                  f"{summary['iterations']} iterations, {summary['seconds']:.1f} s: {'good' if good else 'FAILED'}")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
