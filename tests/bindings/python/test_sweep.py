# SPDX-License-Identifier: MIT
"""diffaqua.sweep over spawned processes, Dask and MPI: several workers, one killed in the middle, nothing lost."""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from concurrent.futures import ThreadPoolExecutor

import numpy as np

import diffaqua as dq
import sweep_tasks

HERE = os.path.dirname(os.path.abspath(__file__))


class Folders(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            cls.expected = [sweep_tasks.swim((folder, index, False)) for index in range(8)]

    def setUp(self):
        self.notes, self.results = tempfile.mkdtemp(), tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.notes)
        self.addCleanup(shutil.rmtree, self.results)

    def tasks(self, deadly=None, how=True):
        return [(self.notes, index, how if index == deadly else False) for index in range(8)]

    def runs(self):
        return [sweep_tasks.runs(self.notes, index) for index in range(8)]


class Processes(Folders):
    def test_one_is_killed(self):
        seen = []
        found = dq.sweep(self.tasks(deadly=2), sweep_tasks.swim, workers=2, folder=self.results,
                         progress=lambda done, total: seen.append((done, total)))
        self.assertEqual(found, self.expected)
        self.assertEqual(seen, [(done, 8) for done in range(1, 9)])
        self.assertEqual(self.runs()[2], 2)
        before = self.runs()
        self.assertEqual(dq.sweep(self.tasks(deadly=2), sweep_tasks.swim, folder=self.results), self.expected)
        self.assertEqual(self.runs(), before, "what is stored is not computed again")
        with self.assertRaisesRegex(dq.ArgumentError, "belongs to another task"):
            dq.sweep(self.tasks(deadly=3), sweep_tasks.swim, folder=self.results)

    def test_a_task_that_always_kills_fails_alone(self):
        with self.assertRaises(dq.SweepError) as caught:
            dq.sweep(self.tasks(deadly=2, how="always"), sweep_tasks.swim, workers=2, retries=2)
        self.assertEqual(list(caught.exception.failures), [2])
        self.assertEqual(caught.exception.results, self.expected[:2] + [None] + self.expected[3:])

    def test_stopped_and_resumed(self):
        with self.assertRaises(dq.CancelledError):
            dq.sweep(self.tasks(), sweep_tasks.swim, executor=lambda: ThreadPoolExecutor(1), folder=self.results,
                     progress=lambda done, total: done == 3)
        stored = [name for name in os.listdir(self.results) if name.endswith(".pickle")]
        self.assertEqual(len(stored), 3)
        with open(os.path.join(self.results, stored[0]), "rb") as file:
            whole = file.read()
        self.assertEqual(dq.sweep(self.tasks(), sweep_tasks.swim, executor=lambda: ThreadPoolExecutor(2),
                                  folder=self.results), self.expected)
        with open(os.path.join(self.results, stored[0]), "wb") as file:
            file.write(whole[:-7])
        with self.assertRaisesRegex(dq.ArgumentError, "is not a result of a sweep"):
            dq.sweep(self.tasks(), sweep_tasks.swim, folder=self.results)


class Failures(unittest.TestCase):
    def test_a_task_that_raises(self):
        with ThreadPoolExecutor(2) as executor, self.assertRaises(dq.SweepError) as caught:
            dq.sweep(range(5), sweep_tasks.fail, executor=executor)
        self.assertIsInstance(caught.exception.failures[3], KeyError)
        self.assertEqual(caught.exception.results, [0, 1, 2, None, 4])

    def test_refused(self):
        for arguments, message in (({"function": 7}, "function: expected"), ({"executor": 7}, "executor: expected"),
                                   ({"executor": dict}, "executor: expected"), ({"retries": -1}, "retries: expected"),
                                   ({"function": lambda task: task}, "picklable")):
            with self.assertRaisesRegex(dq.ArgumentError, message):
                dq.sweep(**{"tasks": [1], "function": sweep_tasks.fail, **arguments})
        self.assertEqual(dq.sweep([], sweep_tasks.fail), [])


class Dask(Folders):
    def test_one_is_killed(self):
        from distributed import Client, LocalCluster
        with LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster, \
                Client(cluster) as client:
            found = dq.sweep(self.tasks(deadly=2), sweep_tasks.swim, executor=client.get_executor(),
                             folder=self.results)
        self.assertEqual(found, self.expected)
        self.assertEqual(self.runs()[2], 2)


class Mpi(Folders):
    """A killed process takes an MPI job down; what it had computed is in the folder, and the next job goes on."""

    def job(self):
        command = [os.path.join(os.path.dirname(sys.executable), "mpiexec"), "-n", "3", sys.executable, "-m",
                   "mpi4py.futures", os.path.join(HERE, "sweep_tasks.py"), self.notes, self.results]
        return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)

    def test_one_is_killed(self):
        self.assertNotEqual(self.job().returncode, 0)
        stored = sorted(int(name[:6]) for name in os.listdir(self.results) if name.endswith(".pickle"))
        self.assertTrue(0 < len(stored) < 8, stored)
        done = self.job()
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(list(np.load(os.path.join(self.notes, "mpi.npy"))), self.expected)
        self.assertEqual([self.runs()[index] for index in stored], [1] * len(stored))
        self.assertEqual(self.runs()[6], 2)


del Folders  # not a test of its own
if __name__ == "__main__":
    unittest.main(verbosity=1)
