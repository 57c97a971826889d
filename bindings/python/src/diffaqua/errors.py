# SPDX-License-Identifier: MIT
"""Exceptions, one for each status of the library. All carry `status` (the code) and `name` (such as
"DQA_ERROR_MESH"); where Python has an exception of the same meaning they are also of that kind."""
from __future__ import annotations


class DiffaquaError(Exception):
    """Something the library refused or could not do. str() is the library's message."""

    status: int = 0
    name: str = ""

    def __init__(self, message: str, status: int | None = None, name: str | None = None) -> None:
        super().__init__(message)
        if status is not None:
            self.status = status
        if name is not None:
            self.name = name

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class ArgumentError(DiffaquaError, ValueError):
    """An argument is out of its range; the message names it, what was expected and what came."""

    status, name = -1, "DQA_ERROR_ARGUMENT"


class StateError(DiffaquaError, RuntimeError):
    """The call does not fit the state of the object: closed, not built, in use, or a step that is passed."""

    status, name = -2, "DQA_ERROR_STATE"


class FileError(DiffaquaError):
    """A file's content is not what was expected."""

    status, name = -3, "DQA_ERROR_FILE"


class AccessError(DiffaquaError, OSError):
    """A file could not be opened, read or written."""

    status, name = -4, "DQA_ERROR_IO"


class MeshError(DiffaquaError, ValueError):
    """A mesh is open, inconsistently oriented, empty or not finite."""

    status, name = -5, "DQA_ERROR_MESH"


class OutOfMemoryError(DiffaquaError, MemoryError):
    """Out of memory, or beyond the memory budget that was given."""

    status, name = -6, "DQA_ERROR_MEMORY"


class UnsupportedError(DiffaquaError, NotImplementedError):
    """This build or version cannot do it."""

    status, name = -7, "DQA_ERROR_UNSUPPORTED"


class NotConvergedError(DiffaquaError, ArithmeticError):
    """An iteration stopped above its tolerance."""

    status, name = -8, "DQA_NOT_CONVERGED"


class DivergedError(DiffaquaError, ArithmeticError):
    """A state became non-finite; the message names the step."""

    status, name = -9, "DQA_DIVERGED"


class CancelledError(DiffaquaError):
    """A progress function or a cancel token asked to stop; the object is still usable."""

    status, name = -10, "DQA_CANCELLED"


class InternalError(DiffaquaError):
    """A defect of the library: please report it."""

    status, name = -11, "DQA_ERROR_INTERNAL"


BY_STATUS: dict[int, type[DiffaquaError]] = {
    kind.status: kind
    for kind in (ArgumentError, StateError, FileError, AccessError, MeshError, OutOfMemoryError, UnsupportedError,
                 NotConvergedError, DivergedError, CancelledError, InternalError)
}
