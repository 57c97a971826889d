# SPDX-License-Identifier: MIT
"""One scene: shape space, material, water, solver; its present design and state."""
from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ._arrays import Array, ArrayLike, IntArray, numbers, output, pointer
from ._callbacks import Progress, current_callbacks, progress_callback
from ._handle import Handle
from ._library import check, ffi, lib
from .controller import Controller
from .shape_space import CancelToken, ShapeSpace, _optional
from .structs import ActuatorInfo, SimulatorInfo, options, told

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .structs import SimulatorOptions
    from .tape import Tape


class Surface(NamedTuple):
    """Where the density is half its peak: vertices [n][dims] (m), elements [m][dims] (triangles, or segments in
    2-D)."""

    vertices: Array
    elements: IntArray


class Mesh(NamedTuple):
    """The simulated cells: nodes [n_active_cells][2^dims], index in the box and occupancy of each."""

    cell_nodes: IntArray
    box_index: IntArray
    occupancy: Array


class Muscles(NamedTuple):
    """Fibres: cell, signal, sign [n], direction at rest [n][dims], stiffness [n] (Pa)."""

    cells: IntArray
    signals: IntArray
    signs: IntArray
    directions: Array
    stiffness: Array


class Design:
    """What stays the same until the next design: tapes remember it."""

    def __init__(self, dims: int, n_nodes: int) -> None:
        self.dims = dims
        self.n_nodes = n_nodes


class Simulator(Handle):
    """A scene in a built space. Options are keyword arguments (see SimulatorOptions), e.g. Simulator(space,
    water=Water.IMPLICIT, time_step=1 / 60). Call set_weights before anything that needs a body."""

    _what = "simulator"

    def __init__(self, space: ShapeSpace, *, cancel: CancelToken | None = None,
                 **settings: Unpack[SimulatorOptions]) -> None:
        with _optional(cancel) as token, space._use(shared=True) as parent:
            filled = options("dqa_simulator_options", lib.dqa_simulator_options_init, settings, cancel=token)
            super().__init__(lambda out: lib.dqa_simulator_create(parent, filled, out), "dqa_simulator",
                             lib.dqa_simulator_free)
            self._n_cells = space.info().n_cells
        self._currents: tuple[Any, ...] = ()
        self._design: Design | None = None
        self._table_rows = 1
        #: s, as the scene was made
        self.time_step: float = filled.time_step

    def info(self) -> SimulatorInfo:
        """Sizes, totals and the clock."""
        with self._use() as simulator:
            return told(SimulatorInfo, lib.dqa_simulator_get_info, simulator)

    # -------------------------------------------------------------- design
    def set_weights(self, weights: ArrayLike, progress: Progress | None = None) -> None:
        """New design from weights [n_bases] on the simplex; the state goes back to rest and the clock to 0."""
        share = numbers("weights", weights, (None,))
        with self._use() as simulator:
            check(lib.dqa_simulator_set_weights(simulator, pointer(share), share.size, progress_callback(progress),
                                                ffi.NULL))
            self._new_design()

    def _new_design(self) -> None:
        info = self.info()
        self._design = Design(info.dims, info.n_nodes) if info.has_design else None

    @property
    def weights(self) -> Array:
        """Of the present design [n_bases]."""
        share = np.zeros(self.info().n_bases)
        with self._use() as simulator:
            check(lib.dqa_simulator_get_weights(simulator, pointer(share), share.size))
        return share

    def set_material(self, young_modulus: ArrayLike | None = None, muscle_stiffness: ArrayLike | None = None) -> None:
        """Moduli (Pa) by cell of the full box [n_cells], or None for the uniform one of the options; state to rest."""
        solid = None if young_modulus is None else numbers("young_modulus", young_modulus, (self._n_cells,))
        muscle = None if muscle_stiffness is None else numbers("muscle_stiffness", muscle_stiffness, (self._n_cells,))
        with self._use() as simulator:
            check(lib.dqa_simulator_set_material(simulator, pointer(solid), pointer(muscle), self._n_cells))
            self._new_design()

    def set_fixed_nodes(self, nodes: ArrayLike) -> None:
        """Nodes of the full box that keep their place, by index; none frees all. State to rest."""
        held = numbers("nodes", nodes, (None,), np.int32)
        with self._use() as simulator:
            check(lib.dqa_simulator_set_fixed_nodes(simulator, pointer(held) if held.size else ffi.NULL, held.size))
            self._new_design()

    def node_box_index(self) -> IntArray:
        """Index in the full box of each node [n_nodes]."""
        with self._use() as simulator:
            nodes = np.zeros(self.info().n_nodes, dtype=np.int32)
            check(lib.dqa_simulator_node_box_index(simulator, pointer(nodes), nodes.size))
        return nodes

    def suggest_threshold(self, weights: ArrayLike, tolerance: float) -> tuple[float, float]:
        """(threshold, estimate): the option `threshold` that keeps the estimated error at or below `tolerance`."""
        share = numbers("weights", weights, (None,))
        threshold, estimate = ffi.new("double *"), ffi.new("double *")
        with self._use() as simulator:
            check(lib.dqa_simulator_suggest_threshold(simulator, pointer(share), share.size, tolerance, threshold,
                                                      estimate))
        return float(threshold[0]), float(estimate[0])

    # -------------------------------------------------------------- water
    def set_current_table(self, times: ArrayLike, velocities: ArrayLike) -> None:
        """Velocity of the water, linear between velocities [n_times][dims] (m/s) at times [n_times] (s); no times: back
        to the option `current`."""
        at = numbers("times", times, (None,))
        values = numbers("velocities", velocities, (at.size, self.info().dims) if at.size else (0,))
        with self._use() as simulator:
            check(lib.dqa_simulator_set_current_table(simulator, pointer(at), at.size, pointer(values), values.size))
            self._currents, self._table_rows = (), max(1, at.size)

    def set_current(self, current: Callable[[float], ArrayLike] | None,
                    pullback: Callable[[float, Array], object] | None = None) -> None:
        """Velocity of the water current(time) -> [dims] (m/s), asked once a step; backward sweeps give
        pullback(time, current_bar [dims]) the gradient of each step, last step first. None: back to the options."""
        for name, function in (("current", current), ("pullback", pullback)):
            if function is not None and not callable(function):
                raise TypeError(f"{name}: expected a function, got {type(function).__name__}")
        with self._use() as simulator:
            if current is None:
                check(lib.dqa_simulator_set_current_callback(simulator, ffi.NULL, ffi.NULL, ffi.NULL))
                self._currents, self._table_rows = (), 1
                return
            pair = current_callbacks(current, pullback, self.info().dims)
            check(lib.dqa_simulator_set_current_callback(simulator, *pair, ffi.NULL))
            self._currents, self._table_rows = pair, 1

    # -------------------------------------------------------------- motion
    def step(self, actuation: ArrayLike, tape: Tape | None = None) -> None:
        """One step with actuation [n_signals], each in [-1, 1]. On failure the state is that before the call."""
        signals = numbers("actuation", actuation, (None,))
        with self._use() as simulator, _optional(tape, shared=False) as record:
            recording: contextlib.AbstractContextManager[None] = contextlib.nullcontext()
            if tape is not None:
                recording = tape._recording(self._design, self._currents, self._table_rows)
            with recording:
                check(lib.dqa_simulator_step(simulator, pointer(signals), signals.size, record))

    def rollout(self, controller: Controller, n_steps: int, tape: Tape | None = None,
                progress: Progress | None = None) -> None:
        """n_steps steps driven by a controller. On failure or when stopped, the state is that after the last whole one,
        and the tape holds the whole ones."""
        with self._use() as simulator, controller._use() as driver, _optional(tape, shared=False) as record:
            recording: contextlib.AbstractContextManager[None] = contextlib.nullcontext()
            if tape is not None:
                recording = tape._recording(self._design, self._currents + controller._keeps, self._table_rows,
                                            controller.info().n_parameters)
            with recording:
                check(lib.dqa_simulator_rollout(simulator, driver, n_steps, record, progress_callback(progress),
                                                ffi.NULL))

    def state(self, q: Array | None = None, v: Array | None = None) -> tuple[Array, Array]:
        """Positions (m) and velocities (m/s), each [n_nodes][dims]; given arrays are written to."""
        with self._use() as simulator:
            info = self.info()
            positions = output("q", q, (info.n_nodes, info.dims))
            velocities = output("v", v, (info.n_nodes, info.dims))
            check(lib.dqa_simulator_get_state(simulator, pointer(positions), positions.size, pointer(velocities),
                                              velocities.size))
        return positions, velocities

    def set_state(self, q: ArrayLike | None = None, v: ArrayLike | None = None) -> None:
        """Sets the state, each [n_nodes][dims], and the clock to step 0. None: rest positions, zero velocities."""
        with self._use() as simulator:
            info = self.info()
            positions = None if q is None else numbers("q", q, (info.n_nodes, info.dims))
            velocities = None if v is None else numbers("v", v, (info.n_nodes, info.dims))
            check(lib.dqa_simulator_set_state(simulator, pointer(positions), 0 if positions is None else positions.size,
                                              pointer(velocities), 0 if velocities is None else velocities.size))

    def sensors(self, out: Array | None = None) -> Array:
        """[5][dims]: velocities of head, centre and tail (m/s), offsets of head and tail from the centre (m)."""
        with self._use() as simulator:
            dims = self.info().dims
            seen = output("out", out, (5, dims))
            check(lib.dqa_simulator_sensors(simulator, pointer(seen), seen.size))
        return seen

    def forces(self, out: Array | None = None) -> Array:
        """[4][dims]: drag and thrust of the last step (N), then their means over the wet surface (N/m^2)."""
        with self._use() as simulator:
            total = output("out", out, (4, self.info().dims))
            check(lib.dqa_simulator_forces(simulator, pointer(total), total.size))
        return total

    # -------------------------------------------------------------- geometry
    def surface(self) -> Surface:
        """The isosurface of the body, carried by the present state."""
        with self._use() as simulator:
            dims = self.info().dims
            n_vertices, n_elements = self._surface_size(simulator)
            vertices = np.zeros((n_vertices, dims))
            elements = np.zeros((n_elements, dims), dtype=np.int32)
            check(lib.dqa_simulator_surface(simulator, pointer(vertices), vertices.size, pointer(elements),
                                            elements.size, ffi.NULL, ffi.NULL))
        return Surface(vertices, elements)

    @staticmethod
    def _surface_size(simulator: Any) -> tuple[int, int]:
        rows = ffi.new("int64_t[2]")
        check(lib.dqa_simulator_surface(simulator, ffi.NULL, 0, ffi.NULL, 0, rows, rows + 1))
        return int(rows[0]), int(rows[1])

    def mesh(self) -> Mesh:
        """The simulated cells."""
        with self._use() as simulator:
            info = self.info()
            nodes = np.zeros((info.n_active_cells, 2**info.dims), dtype=np.int32)
            index = np.zeros(info.n_active_cells, dtype=np.int32)
            occupancy = np.zeros(info.n_active_cells)
            check(lib.dqa_simulator_mesh(simulator, pointer(nodes), nodes.size, pointer(index), index.size,
                                         pointer(occupancy), occupancy.size))
        return Mesh(nodes, index, occupancy)

    def actuator(self, category: int, side: int = 0) -> ActuatorInfo:
        """What the interpolation made of an actuator; side BOTH for caudal ones, LEFT or RIGHT for fins."""
        with self._use() as simulator:
            return told(ActuatorInfo, lib.dqa_simulator_actuator, simulator, category, side)

    def muscles(self) -> Muscles:
        """The fibres of the present design, one row per cell and fibre group."""
        with self._use() as simulator:
            count = ffi.new("int64_t *")
            null = ffi.NULL
            check(lib.dqa_simulator_muscles(simulator, null, null, null, 0, null, 0, null, 0, count))
            n = int(count[0])
            cells, signals, signs = (np.zeros(n, dtype=np.int32) for _ in range(3))
            directions, stiffness = np.zeros((n, self.info().dims)), np.zeros(n)
            check(lib.dqa_simulator_muscles(simulator, pointer(cells), pointer(signals), pointer(signs), n,
                                            pointer(directions), directions.size, pointer(stiffness), stiffness.size,
                                            null))
        return Muscles(cells, signals, signs, directions, stiffness)
