# SPDX-License-Identifier: MIT
"""Stateless helpers for optimisers."""
from __future__ import annotations

from ._arrays import Array, ArrayLike, numbers, output, pointer
from ._library import check, lib


def adam_step(x: Array, gradient: ArrayLike, rates: ArrayLike, first_moment: Array, second_moment: Array,
              iteration: int) -> None:
    """One step of Adam (Kingma & Ba 2015), all [n]; x and the moments are updated in place; iterations count from 1."""
    n = len(output("x", x, getattr(x, "shape", ())))
    output("first_moment", first_moment, (n,))
    output("second_moment", second_moment, (n,))
    slope, rate = numbers("gradient", gradient, (n,)), numbers("rates", rates, (n,))
    check(lib.dqa_adam_step(pointer(x), pointer(slope), pointer(rate), pointer(first_moment), pointer(second_moment),
                            n, iteration))


def project_simplex(x: ArrayLike) -> Array:
    """The point of the simplex (>= 0, sum 1) that is nearest to x [n]."""
    point = numbers("x", x, (None,)).copy()
    check(lib.dqa_project_simplex(pointer(point), point.size))
    return point
