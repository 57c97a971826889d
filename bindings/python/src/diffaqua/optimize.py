# SPDX-License-Identifier: MIT
"""Stateless helpers for optimisers, and a search without gradients."""
from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np

from ._arrays import Array, ArrayLike, numbers, output, pointer
from ._handle import Handle, path_bytes
from ._library import check, ffi, lib
from .structs import SearchInfo, options, told

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .structs import SearchOptions


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


class CmaEs(Handle):
    """CMA-ES: minimises a function of n numbers from its values alone. Options as in SearchOptions, e.g. CmaEs([0.5,
    15.0], scales=[0.3, 5.0], seed=1). The same options, seed and values give the same candidates to the bit. Unknowns
    are free; the header says how bounds are kept."""

    _what = "search"

    def __init__(self, mean: ArrayLike, scales: ArrayLike | None = None, **settings: Unpack[SearchOptions]) -> None:
        start = numbers("mean", mean, (None,))
        units = None if scales is None else numbers("scales", scales, (start.size,))
        filled = options("dqa_cma_es_options", lib.dqa_cma_es_options_init, settings)
        super().__init__(lambda out: lib.dqa_cma_es_create(filled, pointer(start), pointer(units), start.size, out),
                         "dqa_cma_es", lib.dqa_cma_es_free)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> CmaEs:
        """The search of a file that save() wrote."""
        search, name = cls.__new__(cls), path_bytes(path)
        Handle.__init__(search, lambda out: lib.dqa_cma_es_load(name, out), "dqa_cma_es", lib.dqa_cma_es_free)
        return search

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the state, which goes on with the same bits."""
        with self._use() as search:
            check(lib.dqa_cma_es_save(search, path_bytes(path)))

    def info(self) -> SearchInfo:
        """Sizes, generation, and how wide the search still is."""
        with self._use() as search:
            return told(SearchInfo, lib.dqa_cma_es_get_info, search)

    def ask(self, out: Array | None = None) -> Array:
        """Candidates [population][n] of this generation."""
        info = self.info()
        candidates = output("out", out, (info.population, info.n))
        with self._use() as search:
            check(lib.dqa_cma_es_ask(search, pointer(candidates), candidates.size))
        return candidates

    def tell(self, values: ArrayLike) -> None:
        """Values [population] of the candidates in their order, +infinity for what could not be evaluated."""
        found = numbers("values", values, (None,))
        with self._use() as search:
            check(lib.dqa_cma_es_tell(search, pointer(found), found.size))

    def best(self) -> tuple[Array, float]:
        """(candidate [n] of the lowest value so far, that value)."""
        x, value = np.zeros(self.info().n), ffi.new("double *")
        with self._use() as search:
            check(lib.dqa_cma_es_best(search, pointer(x), x.size, value))
        return x, float(value[0])

    @property
    def mean(self) -> Array:
        """Centre of the distribution [n]: often better than any candidate."""
        x = np.zeros(self.info().n)
        with self._use() as search:
            check(lib.dqa_cma_es_mean(search, pointer(x), x.size))
        return x
