# SPDX-License-Identifier: MIT
"""Objects of the library as Python objects: closed by close(), by leaving a `with` block, or when nothing refers to
them any more, in any order. Calls on one object take turns, so that threads cannot break it."""
from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

from ._library import check, ffi
from .errors import StateError

Self = TypeVar("Self", bound="Handle")


class Handle:
    """Owns one handle of the library."""

    _what = "object"

    def __init__(self, create: Callable[[Any], int], type_name: str, free: Any) -> None:
        self._pointer: Any = None
        self._guard = threading.RLock()  # a signal handler may come in between
        self._turn = threading.RLock()
        self._users = 0
        out = ffi.new(f"{type_name} **")
        check(create(out))
        self._pointer = ffi.gc(out[0], free)

    @contextmanager
    def _use(self, shared: bool = False) -> Iterator[Any]:
        """The handle for the time of one call. `shared` ones may overlap; the others take turns, and may nest in one
        thread, as when a callback asks the object that calls it."""
        if not shared:
            self._turn.acquire()
        try:
            with self._guard:
                if self._pointer is None:
                    raise StateError(f"this {self._what} is closed")
                handle = self._pointer
                self._users += 1
            try:
                yield handle
            finally:
                with self._guard:
                    self._users -= 1
        finally:
            if not shared:
                self._turn.release()

    @property
    def closed(self) -> bool:
        """Whether close() was called."""
        return self._pointer is None

    def close(self) -> None:
        """Gives its memory back; further use raises StateError. Again: nothing happens. What was made from it stays."""
        if getattr(self, "_pointer", None) is None:
            return
        with self._guard:
            if self._users:
                raise StateError(f"this {self._what} cannot be closed while a call uses it")
            handle, self._pointer = self._pointer, None
        if handle is not None:
            ffi.release(handle)

    def __enter__(self: Self) -> Self:
        return self

    def __exit__(self, *unused: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<diffaqua {self._what}{', closed' if self.closed else ''}>"

    def __reduce__(self) -> Any:
        raise TypeError(f"a {self._what} lives in its own process and cannot be pickled; build it again there")


def path_bytes(path: Any) -> bytes:
    """A path as the library takes it."""
    return os.fsencode(path)
