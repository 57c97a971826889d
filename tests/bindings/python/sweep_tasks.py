# SPDX-License-Identifier: MIT
"""Tasks for test_sweep.py, in a module that worker processes can import, and the program that runs them under MPI."""
import os
import signal
import sys
import time

import numpy as np

import diffaqua as dq


def swim(task):
    """(folder, index, deadly): the loss of a design that the index chooses. A note in the folder counts the runs; a
    deadly task kills its worker when it runs first."""
    import scene
    folder, index, deadly = task
    with open(os.path.join(folder, f"{index}.runs"), "a", encoding="utf-8") as file:
        file.write(f"{os.getpid()}\n")
    with open(os.path.join(folder, f"{index}.runs"), encoding="utf-8") as file:
        first = len(file.readlines()) == 1
    if deadly == "always" or (deadly and first):
        time.sleep(0.3)  # others are under way
        os.kill(os.getpid(), signal.SIGKILL)
    with scene.simulator() as simulator:
        share = index / 10.0
        return dq.rollout.Rollout(simulator, dq.Sinusoid(1), 3, dq.ObjectiveTerm())([1.0 - share, share],
                                                                                   [0.7, 11.0, 0.3])


def fail(task):
    if task == 3:
        raise KeyError("three")
    return task


def runs(folder, index):
    try:
        with open(os.path.join(folder, f"{index}.runs"), encoding="utf-8") as file:
            return len(file.readlines())
    except FileNotFoundError:
        return 0


def under_mpi(notes, results):
    from mpi4py.futures import MPIPoolExecutor
    with MPIPoolExecutor() as executor:
        tasks = [(notes, index, index == 6) for index in range(8)]
        np.save(os.path.join(notes, "mpi.npy"), dq.sweep(tasks, swim, executor=executor, folder=results))


if __name__ == "__main__":
    import sweep_tasks  # under its own name, for the workers
    sweep_tasks.under_mpi(*sys.argv[1:])
