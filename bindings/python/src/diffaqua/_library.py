# SPDX-License-Identifier: MIT
"""Finds and loads the shared library, reads its declarations (diffaqua.cdef), and turns a status into an exception.

The library is looked for in the environment variable's place only when the package has none of its own: in the package
(a wheel brings it), then at DIFFAQUA_LIBRARY, then where the system keeps libraries."""
from __future__ import annotations

import ctypes.util
import os
import threading
from pathlib import Path
from typing import Any

import cffi

from . import errors

_HERE = Path(__file__).resolve().parent


def _declarations() -> str:
    # In a wheel beside this file; in a checkout where the other languages have it too.
    for path in (_HERE / "diffaqua.cdef", _HERE.parents[2] / "diffaqua.cdef"):
        if path.is_file():
            return path.read_text(encoding="utf-8")
    raise ImportError(f"diffaqua.cdef is missing beside {__file__}: the installation is incomplete")


def _candidates() -> list[str]:
    own = _HERE / "libdiffaqua.so"
    if own.is_file():
        return [str(own)]
    named = os.environ.get("DIFFAQUA_LIBRARY")
    if named:
        return [named]
    found = ctypes.util.find_library("diffaqua")
    return [found] if found else ["libdiffaqua.so.0", "libdiffaqua.so"]


ffi = cffi.FFI()
ffi.cdef(_declarations())


def _load() -> tuple[Any, str]:
    tried = []
    for name in _candidates():
        try:
            return ffi.dlopen(name), name
        except OSError as error:
            tried.append(str(error))
    raise ImportError("cannot load libdiffaqua: " + "; ".join(tried) +
                      ". Install the wheel, or set DIFFAQUA_LIBRARY to the path of the shared library")


lib, path = _load()
if lib.dqa_abi_version() != lib.DQA_ABI_VERSION:
    raise ImportError(f"{path} has ABI {lib.dqa_abi_version()}; this package was made for {lib.DQA_ABI_VERSION}")


def text(pointer: Any) -> str:
    """A C string of the library's; file names in messages may be of any encoding."""
    return bytes(ffi.string(pointer)).decode("utf-8", "surrogateescape")


# ------------------------------------------------------------------ exceptions that callbacks raised
class _Raised(threading.local):
    exception: BaseException | None = None


_raised = _Raised()


def keep_exception(exception: BaseException) -> None:
    """Remembers, for this thread, what a callback raised; the first one counts. `check` raises it again."""
    if _raised.exception is None:
        _raised.exception = exception


def check(status: int) -> None:
    """Raises what a callback of the call raised, or the exception of a status that is not success."""
    exception, _raised.exception = _raised.exception, None
    if exception is not None:
        try:
            raise exception
        finally:
            del exception  # no cycle through this frame
    if status != 0:
        kind = errors.BY_STATUS.get(status, errors.DiffaquaError)
        raise kind(text(lib.dqa_last_error()), status, text(lib.dqa_status_name(status)))
