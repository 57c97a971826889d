# SPDX-License-Identifier: MIT
"""The record of a rollout, losses of it, and the backward sweep."""
from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from ._arrays import Array, ArrayLike, numbers, output, pointer
from ._callbacks import Progress, progress_callback
from ._handle import Handle
from ._library import check, ffi, lib
from .constants import Objective, Wrt
from .controller import Controller
from .errors import ArgumentError, StateError
from .shape_space import _optional
from .simulator import Design, Simulator
from .structs import GradientReport, TapeStatistics, options, record, told

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .structs import TermOptions


class ObjectiveTerm:
    """A term of a loss: ObjectiveTerm(Objective.TRAVEL, weight=1.0); options as in TermOptions. A PATH takes
    path [n][1 + dims], rows of (time in s, coordinates in m)."""

    def __init__(self, kind: int = Objective.TRAVEL, *, path: ArrayLike | None = None,
                 **settings: Unpack[TermOptions]) -> None:
        self.kind = int(kind)
        self.path = None if path is None else numbers("path", path, (None, None))
        self.settings = dict(settings)
        self._fill(None)  # names and shapes are checked where the term is written

    def _fill(self, keep: list[Any] | None) -> Any:
        filled = options("dqa_objective_term", lib.dqa_objective_term_init, {"kind": self.kind, **self.settings})
        if self.path is not None and keep is not None:
            buffer = pointer(self.path)
            keep.append(buffer)
            filled.path, filled.n_path = buffer, self.path.size
        return filled

    def __repr__(self) -> str:
        settings = "".join(f", {name}={value!r}" for name, value in self.settings.items())
        return f"ObjectiveTerm({self.kind}{settings}{'' if self.path is None else ', path=...'})"


#: A loss: one term or several, of which it is the weighted sum.
Loss = Union[ObjectiveTerm, Sequence[ObjectiveTerm]]


class _Terms:
    """The C array of a loss's terms and what it points to."""

    def __init__(self, loss: Loss) -> None:
        terms = [loss] if isinstance(loss, ObjectiveTerm) else list(loss)
        self.keep: list[Any] = []
        self.n = len(terms)
        self.array = ffi.new("dqa_objective_term[]", max(1, self.n))
        for index, term in enumerate(terms):
            if not isinstance(term, ObjectiveTerm):
                raise TypeError(f"loss: expected ObjectiveTerm, got {type(term).__name__}")
            self.array[index] = term._fill(self.keep)[0]


class Tape(Handle):
    """The record of one rollout. memory_bytes > 0 is a budget; what does not fit is computed again, to the same
    bits."""

    _what = "tape"

    def __init__(self, simulator: Simulator, *, memory_bytes: int = 0) -> None:
        filled = options("dqa_tape_options", lib.dqa_tape_options_init, {"memory_bytes": memory_bytes})
        with simulator._use() as parent:
            super().__init__(lambda out: lib.dqa_tape_create(parent, filled, out), "dqa_tape", lib.dqa_tape_free)
        info = simulator.info()
        self._simulator = simulator
        self._dims, self._n_bases, self._n_signals = info.dims, info.n_bases, info.n_signals
        self._n_cells = simulator._n_cells
        self._design: Design | None = None
        self._keeps: list[Any] = []
        self._n_parameters: int | None = None
        self._table_rows = 1

    @contextlib.contextmanager
    def _recording(self, design: Design | None, callbacks: tuple[Any, ...], table_rows: int,
                   n_parameters: int | None = None) -> Iterator[None]:
        # The callbacks of the steps must outlive the tape, even if recording fails half-way. A call that was refused has
        # changed nothing.
        self._keeps += [callback for callback in callbacks if callback not in self._keeps]
        before = self.n_steps
        try:
            yield
        finally:
            if self.n_steps > before:
                if before == 0:
                    self._design = design
                self._table_rows = table_rows
                if n_parameters is not None:
                    self._n_parameters = n_parameters

    def clear(self) -> None:
        """Empties the tape for another rollout; StateError while an adjoint of it lives."""
        with self._use() as tape:
            check(lib.dqa_tape_clear(tape))
            self._design, self._keeps, self._n_parameters = None, [], None

    @property
    def n_steps(self) -> int:
        """Recorded so far."""
        count = ffi.new("int64_t *")
        with self._use() as tape:
            check(lib.dqa_tape_n_steps(tape, count))
        return int(count[0])

    def _nodes(self) -> tuple[int, int]:
        if self._design is None:
            raise StateError("nothing is recorded on this tape")
        return self._design.n_nodes, self._design.dims

    def state(self, step: int, q: Array | None = None, v: Array | None = None) -> tuple[Array, Array]:
        """Positions and velocities after `step` steps, each [n_nodes][dims]; cheapest in order under a budget."""
        shape = self._nodes()
        positions, velocities = output("q", q, shape), output("v", v, shape)
        with self._use() as tape:
            check(lib.dqa_tape_get_state(tape, step, pointer(positions), positions.size, pointer(velocities),
                                         velocities.size))
        return positions, velocities

    def actuation(self, step: int) -> Array:
        """Used in step `step` [n_signals]."""
        values = np.zeros(self._n_signals)
        with self._use() as tape:
            check(lib.dqa_tape_get_actuation(tape, step, pointer(values), values.size))
        return values

    def current(self, step: int) -> Array:
        """Velocity of the water [dims] (m/s) during step `step`."""
        values = np.zeros(self._dims)
        with self._use() as tape:
            check(lib.dqa_tape_get_current(tape, step, pointer(values), values.size))
        return values

    def surface(self, step: int, n_vertices: int | None = None) -> Array:
        """Vertices [n_vertices][dims] of Simulator.surface after `step` steps; its elements are those of the simulator
        for the same design. Their number must be given once the simulator has another design."""
        if n_vertices is None:
            with self._simulator._use() as simulator:
                if self._simulator._design is not self._design:
                    raise StateError("the simulator has another design now: give n_vertices of that of the tape")
                n_vertices = self._simulator._surface_size(simulator)[0]
        vertices = np.zeros((n_vertices, self._dims))
        with self._use() as tape:
            check(lib.dqa_tape_get_surface(tape, step, pointer(vertices), vertices.size))
        return vertices

    def statistics(self) -> TapeStatistics:
        """Memory, iterations and residuals."""
        with self._use() as tape:
            return told(TapeStatistics, lib.dqa_tape_stats, tape)

    def objective(self, loss: Loss) -> tuple[float, Array]:
        """(loss, its unweighted terms [n_terms]) of the recorded rollout."""
        terms = _Terms(loss)
        value, each = ffi.new("double *"), np.zeros(terms.n)
        with self._use() as tape:
            check(lib.dqa_tape_objective(tape, terms.array, terms.n, value, pointer(each)))
        return float(value[0]), each

    def gradient(self, loss: Loss, *wrt: int, progress: Progress | None = None) -> tuple[Array, ...]:
        """Gradients of a loss with respect to each of `wrt` (Wrt.WEIGHTS, ...): a whole backward sweep."""
        with Adjoint(self) as adjoint:
            adjoint.seed_objective(loss)
            adjoint.backward(progress=progress)
            return tuple(adjoint.gradient(which) for which in wrt)


class Adjoint(Handle):
    """A cursor over a finished tape that walks back from its last step. Seeds add up."""

    _what = "adjoint"

    def __init__(self, tape: Tape) -> None:
        with tape._use() as parent:
            super().__init__(lambda out: lib.dqa_adjoint_create(parent, out), "dqa_adjoint", lib.dqa_adjoint_free)
            self._keeps = tuple(tape._keeps)
            self._nodes = tape._nodes()
            self._sizes = (tape._n_bases, tape.n_steps, tape._n_signals, tape._n_cells)
            self._n_parameters, self._table_rows = tape._n_parameters, tape._table_rows

    def seed(self, step: int, quantity: int, bar: ArrayLike) -> None:
        """Adds bar [n_nodes][dims] to dL/dq or dL/dv (Seed.POSITION, Seed.VELOCITY) of the state after `step` steps."""
        values = numbers("bar", bar, self._nodes)
        with self._use() as adjoint:
            check(lib.dqa_adjoint_seed(adjoint, step, quantity, pointer(values), values.size))

    def seed_objective(self, loss: Loss) -> None:
        """Adds the seeds of a loss; only before the sweep has begun."""
        terms = _Terms(loss)
        with self._use() as adjoint:
            check(lib.dqa_adjoint_seed_objective(adjoint, terms.array, terms.n))

    def backward(self, to_step: int = 0, progress: Progress | None = None) -> None:
        """Runs the sweep back to the state after `to_step` steps; goes on where it was stopped."""
        with self._use() as adjoint:
            check(lib.dqa_adjoint_backward(adjoint, to_step, progress_callback(progress), ffi.NULL))

    def gradient(self, wrt: int, out: Array | None = None) -> Array:
        """A gradient, in the shape that the header gives. All but ACTUATION and CURRENT need the whole sweep."""
        values = output("out", out, self._shape(wrt))
        with self._use() as adjoint:
            check(lib.dqa_adjoint_get(adjoint, wrt, pointer(values), values.size))
        return values

    def _shape(self, wrt: int) -> tuple[int, ...]:
        n_bases, n_steps, n_signals, n_cells = self._sizes
        dims = self._nodes[1]
        shapes: dict[int, tuple[int, ...]] = {
            Wrt.WEIGHTS: (n_bases,), Wrt.ACTUATION: (n_steps, n_signals), Wrt.INITIAL_POSITION: self._nodes,
            Wrt.INITIAL_VELOCITY: self._nodes, Wrt.WATER: (dims + 9,), Wrt.CURRENT: (n_steps, dims),
            Wrt.CURRENT_TABLE: (self._table_rows, dims), Wrt.YOUNGS_MODULUS: (n_cells,),
            Wrt.MUSCLE_STIFFNESS: (n_cells,), Wrt.MATERIAL: (4,), Wrt.LAME: (2,),
        }
        if self._n_parameters is not None:
            shapes[Wrt.CONTROL] = (self._n_parameters,)
        if wrt == Wrt.CONTROL and wrt not in shapes:
            raise StateError("wrt: no controller drove this tape; its steps have the gradient ACTUATION")
        if wrt not in shapes:
            raise ArgumentError(f"wrt: expected one of Wrt, got {wrt!r}")
        return shapes[wrt]


def check_gradient(simulator: Simulator, loss: Loss, *, controller: Controller | None = None,
                   wrt: int = Wrt.WEIGHTS, n_steps: int = 10, seed: int = 1, step: float = 0.0) -> GradientReport:
    """Proves (or refutes) a gradient by finite differences along a random direction; the simulator is unchanged."""
    terms = _Terms(loss)
    filled = options("dqa_gradient_check_options", lib.dqa_gradient_check_options_init,
                     {"with_respect_to": wrt, "n_steps": n_steps, "seed": seed, "step": step})
    report = ffi.new("dqa_gradient_check_report *")
    with simulator._use() as scene, _optional(controller, shared=False) as driver:
        check(lib.dqa_check_gradient(scene, driver, terms.array, terms.n, filled, report, ffi.sizeof(report[0])))
    return record(GradientReport, report)
