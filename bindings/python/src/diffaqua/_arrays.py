# SPDX-License-Identifier: MIT
"""NumPy arrays on their way in and out. An array of the right type that lies contiguously is not copied; other real
numbers are converted; what cannot be is refused by name."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ._library import ffi
from .errors import ArgumentError

Array = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int32]
#: What is taken where numbers go in: arrays, nested sequences, anything with __array__.
ArrayLike = npt.ArrayLike

_C_TYPES = {np.dtype(np.float64): "double[]", np.dtype(np.int32): "int32_t[]"}


def _shape_text(shape: Sequence[int | None]) -> str:
    return "[" + ", ".join("any" if length is None else str(length) for length in shape) + "]"


def _fits(shape: tuple[int, ...], wanted: Sequence[int | None]) -> bool:
    return len(shape) == len(wanted) and all(w is None or w == s for s, w in zip(shape, wanted))


def numbers(name: str, value: Any, shape: Sequence[int | None], dtype: Any = np.float64) -> npt.NDArray[Any]:
    """`value` as a contiguous array of that shape (None: any length), without a copy where it is one already."""
    try:
        array = np.asarray(value)
    except ValueError as error:
        raise ArgumentError(f"{name}: expected numbers of shape {_shape_text(shape)}, got ragged rows") from error
    wanted = np.dtype(dtype)
    if array.size == 0 and array.dtype == np.float64:
        array = array.astype(wanted)  # an empty list has no type of its own
    kinds = "fiub" if wanted.kind == "f" else "iu"
    if array.dtype.kind not in kinds:
        what = "real numbers" if wanted.kind == "f" else "whole numbers"
        raise ArgumentError(f"{name}: expected {what}, got {array.dtype}")
    if not _fits(array.shape, shape):
        raise ArgumentError(f"{name}: expected shape {_shape_text(shape)}, got {_shape_text(array.shape)}")
    if wanted.kind == "i" and array.size and not (
            -2**31 <= int(array.min()) and int(array.max()) < 2**31):
        raise ArgumentError(f"{name}: expected numbers of 32 bits, got {int(array.min())} ... {int(array.max())}")
    return np.ascontiguousarray(array, dtype=wanted)


def output(name: str, out: npt.NDArray[Any] | None, shape: Sequence[int], dtype: Any = np.float64) -> npt.NDArray[Any]:
    """`out` if it can be written as it is, or a new array."""
    if out is None:
        return np.zeros(tuple(shape), dtype=dtype)
    if not isinstance(out, np.ndarray):
        raise ArgumentError(f"{name}: expected a NumPy array to write to, got {type(out).__name__}")
    wanted = np.dtype(dtype)
    if out.dtype != wanted or not _fits(out.shape, shape):
        raise ArgumentError(f"{name}: expected {wanted} of shape {_shape_text(shape)}, "
                            f"got {out.dtype} of shape {_shape_text(out.shape)}")
    if not out.flags.c_contiguous or not out.flags.writeable:
        raise ArgumentError(f"{name}: expected a C-contiguous, writeable array")
    return out


def pointer(array: npt.NDArray[Any] | None) -> Any:
    """What C takes for the array; NULL for None. Keeps the array alive as long as it lives itself."""
    if array is None:
        return ffi.NULL
    if not array.size:
        # An empty array has no address that C may rely on, yet it is not "not wanted".
        return ffi.new(_C_TYPES[array.dtype].replace("[]", "[1]"))
    return ffi.from_buffer(_C_TYPES[array.dtype], array.reshape(-1), require_writable=array.flags.writeable)


def view(pointer_: Any, n: int) -> Array:
    """The library's own memory as an array, without a copy; valid as long as the library says."""
    if n == 0 or pointer_ == ffi.NULL:
        return np.zeros(0)
    return np.frombuffer(ffi.buffer(pointer_, 8 * n), dtype=np.float64)
