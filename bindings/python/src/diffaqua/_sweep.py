# SPDX-License-Identifier: MIT
"""Many tasks over the processes of any executor. Results are stored as they come; tasks whose worker died are tried
again; a folder of results lets another run go on."""
from __future__ import annotations

import hashlib
import inspect
import multiprocessing
import os
import pickle
import tempfile
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait
from typing import Any

from ._callbacks import Progress
from .errors import ArgumentError, CancelledError

_FORMAT = 1


class SweepError(RuntimeError):
    """Some tasks failed; `failures` has the exception of each by its index, `results` what the others gave."""

    def __init__(self, failures: dict[int, BaseException], results: list[Any]) -> None:
        first = min(failures)
        super().__init__(f"{len(failures)} of {len(results)} tasks failed; task {first}: {failures[first]!r}")
        self.failures = failures
        self.results = results


def _spawned(workers: int | None) -> Executor:
    # Never fork: a child would inherit locks of the library's threads in whatever state they are.
    return ProcessPoolExecutor(workers or os.cpu_count(), mp_context=multiprocessing.get_context("spawn"))


def _lost_its_worker(error: BaseException) -> bool:
    """The task itself did not fail: what ran it is gone. Dask and MPI have names of their own for that."""
    return isinstance(error, BrokenExecutor) or type(error).__name__ in ("KilledWorker", "CommClosedError")


# ------------------------------------------------------------------ folder of results
def _path(folder: str, index: int) -> str:
    return os.path.join(folder, f"{index:06d}.pickle")


def _write(path: str, value: Any) -> None:
    """Whole or not at all."""
    handle, temporary = tempfile.mkstemp(dir=os.path.dirname(path), prefix=".", suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            pickle.dump(value, file)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise


def _key(function: Callable[[Any], Any], task: Any) -> str:
    """Tells whether a stored result belongs to a task: by what is computed of what."""
    name = f"{getattr(function, '__module__', '')}.{getattr(function, '__qualname__', repr(type(function)))}"
    return hashlib.sha256(pickle.dumps((_FORMAT, name, task), protocol=4)).hexdigest()


def _stored(folder: str, keys: list[str]) -> dict[int, Any]:
    found = {}
    for index, key in enumerate(keys):
        try:
            with open(_path(folder, index), "rb") as file:
                written, value = pickle.load(file)
        except FileNotFoundError:
            continue
        except Exception as error:
            raise ArgumentError(f"folder: {_path(folder, index)} is not a result of a sweep: {error}") from error
        if written != key:
            raise ArgumentError(f"folder: {_path(folder, index)} belongs to another task or function; "
                                "give each sweep a folder of its own")
        found[index] = value
    return found


# ------------------------------------------------------------------ the sweep
class _Pool:
    """An executor that is made anew when its workers are gone, where it is ours to make."""

    def __init__(self, executor: Executor | Callable[[], Executor] | None, workers: int | None) -> None:
        self._given = executor if executor is not None and hasattr(executor, "submit") else None
        self._make = (lambda: _spawned(workers)) if executor is None else executor
        self._executor: Executor | None = None

    def submit(self, function: Callable[[Any], Any], task: Any) -> Future[Any]:
        if self._given is not None:
            return self._given.submit(function, task)
        if self._executor is None:
            self._executor = self._make()  # type: ignore[operator]
        return self._executor.submit(function, task)

    def renew(self) -> bool:
        """Whether there is a new executor to go on with."""
        if self._given is not None:
            return False
        self.close()
        return True

    def close(self) -> None:
        if self._executor is not None:
            self._executor.shutdown(wait=True, cancel_futures=True)
            self._executor = None


def _check(tasks: list[Any], function: Any, executor: Any, retries: int) -> None:
    if not callable(function):
        raise ArgumentError(f"function: expected a function of one task, got {type(function).__name__}")
    if executor is not None and not callable(executor) and not hasattr(executor, "submit"):
        raise ArgumentError("executor: expected an Executor, a function that makes one, or None, "
                            f"got {type(executor).__name__}")
    if inspect.isclass(executor) and not issubclass(executor, Executor):
        raise ArgumentError(f"executor: expected an Executor, got the class {executor.__name__}")
    if retries < 0:
        raise ArgumentError(f"retries: expected a number >= 0, got {retries}")
    try:
        pickle.dumps((function, tasks))
    except Exception as error:
        raise ArgumentError(f"tasks and function must be picklable, to reach other processes: {error}") from error


def sweep(tasks: Iterable[Any], function: Callable[[Any], Any], *, executor: Executor | Callable[[], Executor] | None =
          None, workers: int | None = None, folder: str | os.PathLike[str] | None = None, retries: int = 3,
          progress: Progress | None = None) -> list[Any]:
    """[function(task) for task in tasks], by the worker processes of an executor, in any order; the results are in the
    order of the tasks. Tasks, results and the function (by name: of a module, not of a cell) must be picklable;
    simulators are not, so the function builds its own.

    executor    any concurrent.futures.Executor, such as Dask's client.get_executor() or
                mpi4py.futures.MPIPoolExecutor(); a function that makes one, which is then made anew when its workers
                die; None: a pool of `workers` spawned processes (default: one for each processor), made anew as well
    folder      where every result is stored as it comes. A later call with the same tasks takes from it what is there
                and computes the rest. Whoever may write to the folder may run code here: results are pickles
    retries     how often a task is tried again whose worker died. A task that raises is not tried again
    progress    (done, total); a true result stops with CancelledError, when the tasks under way are through

    SweepError, when all others are through, if tasks raised or lost more workers than `retries`."""
    todo, found = list(tasks), {}
    _check(todo, function, executor, retries)
    keys = [_key(function, task) for task in todo]
    place = None if folder is None else os.fspath(folder)
    if place is not None:
        os.makedirs(place, exist_ok=True)
        found = _stored(place, keys)
    tries = {index: 0 for index in range(len(todo)) if index not in found}
    failures: dict[int, BaseException] = {}
    pool = _Pool(executor, workers)

    def keep(index: int, value: Any) -> None:
        if place is not None:
            _write(_path(place, index), (keys[index], value))
        found[index] = value
        if progress is not None and progress(len(found), len(todo)):
            raise CancelledError(f"progress asked to stop after {len(found)} of {len(todo)} tasks")

    try:
        while tries:
            lost = _round(pool, function, todo, keep, failures, tries)
            for index, error in lost:
                tries[index] += 1
                if tries[index] > retries:
                    failures[index] = error
                    del tries[index]
            if lost and not pool.renew() and all(isinstance(error, BrokenExecutor) for _, error in lost):
                failures.update(lost)  # an executor that was given and is broken for good
                break
    finally:
        pool.close()
    results = [found.get(index) for index in range(len(todo))]
    if failures:
        raise SweepError(failures, results)
    return results


def _room(tries: int, total: int) -> int:
    """How many tasks may be under way beside one that was tried so often. A broken pool takes down whatever it holds: a
    task that lost its worker runs in smaller company, and the next time alone, so that the others are not blamed."""
    return total if tries == 0 else (os.cpu_count() or 1) if tries == 1 else 1


def _round(pool: _Pool, function: Callable[[Any], Any], tasks: list[Any], keep: Callable[[int, Any], None],
           failures: dict[int, BaseException], tries: dict[int, int]) -> list[tuple[int, BaseException]]:
    """Runs the tasks of `tries` once, those that were tried most first; the ones that lost their worker."""
    lost: list[tuple[int, BaseException]] = []
    waiting: dict[Future[Any], int] = {}
    rest = sorted(tries, key=lambda index: (tries[index], -index))
    try:
        while waiting or (rest and not lost):
            while rest and not lost and len(waiting) < _room(tries[rest[-1]], len(tasks)):
                index = rest.pop()
                try:
                    waiting[pool.submit(function, tasks[index])] = index
                except BrokenExecutor as broken:
                    lost.append((index, broken))
            done, _ = wait(waiting, return_when=FIRST_COMPLETED) if waiting else ((), ())
            for future in done:
                index, error = waiting.pop(future), future.exception()
                if error is None:
                    del tries[index]
                    keep(index, future.result())
                elif _lost_its_worker(error):
                    lost.append((index, error))
                else:
                    del tries[index]
                    failures[index] = error
    finally:
        for future in waiting:
            future.cancel()
    return lost
