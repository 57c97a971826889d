# SPDX-License-Identifier: MIT
"""Shape and control by CMA-ES, without gradients: for landscapes with many optima. Every generation is a sweep that may
run on any executor; here on this machine's processors."""
import cma
import numpy as np

import diffaqua as dq
import fish

SCALE = np.array([1.0, 1.0, 1.0, 15.0, 1.0])
STATE = {}  # of a worker: the scene is built once


def travel(task):
    steps, y = task
    if steps not in STATE:
        STATE[steps] = fish.rollout(steps)[0]
    x = np.asarray(y) * SCALE
    return STATE[steps](x[:2], x[2:])


def main():
    options = fish.arguments(__doc__, iterations=6)
    log = fish.Log(options.tensorboard)
    search = cma.CMAEvolutionStrategy([0.5, 0.5, 0.6, 1.0, 0.0], 0.15, {
        "bounds": [[1e-3, 1e-3, 0.0, 0.2, -3.0], [1.0, 1.0, 1.0, 2.0, 3.0]], "seed": 1, "verbose": -9})
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as executor:
        for _ in range(options.iterations):
            points = search.ask()
            losses = dq.sweep([(options.steps, point.tolist()) for point in points], travel, executor=executor)
            search.tell(points, losses)
            best = int(np.argmin(losses))
            log(losses[best], points[best][:2], points[best][2:] * SCALE[2:])
    log.close()


if __name__ == "__main__":
    main()
