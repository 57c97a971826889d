# SPDX-License-Identifier: MIT
"""The library's structs: options as keyword arguments, what calls tell as frozen records. Names, units and defaults are
those of the header; a test compares the fields."""
from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypedDict, TypeVar

import numpy as np

from ._library import check, ffi, lib
from .errors import ArgumentError

Record = TypeVar("Record")
_HIDDEN = {"struct_size", "flags", "padding"}


class SpaceOptions(TypedDict, total=False):
    """Keyword arguments of ShapeSpace, besides `cancel`: dqa_shape_space_options."""

    dims: int
    cells_x: int
    cells_y: int
    cells_z: int
    margin: int
    margin_across: int
    up: int
    subsamples: int
    peak: int
    max_iterations: int
    threads: int
    body_length: float
    cell_size: float
    sigma: float
    tolerance: float
    interpolation: int
    automatic_fins: int
    refinement: int


class SimulatorOptions(TypedDict, total=False):
    """Keyword arguments of Simulator, besides `cancel`: dqa_simulator_options."""

    threads: int
    method: int
    water: int
    max_newton: int
    max_linear: int
    instruction_set: int
    integrator: int
    material: int
    planar: int
    preconditioner: int
    time_step: float
    young_modulus: float
    poisson_ratio: float
    density: float
    muscle_stiffness: float
    contraction: float
    threshold: float
    occupancy_floor: float
    tolerance: float
    adjoint_tolerance: float
    water_density: float
    current: Sequence[float]
    drag_coefficients: Sequence[float]
    thrust_coefficients: Sequence[float]
    speed_smoothing: float
    angle_smoothing: float
    surface_smoothing: float
    water_faces: int
    linear_precision: int
    quadrature: int
    max_products: int


class PerceptronOptions(TypedDict, total=False):
    """Keyword arguments of Perceptron: dqa_mlp_options, with `hidden` a sequence of neurons in place of n_hidden."""

    n_signals: int
    dims: int
    hidden: Sequence[int]
    temporal_encoding: int
    period_steps: int
    seed: int
    scale: float


class TermOptions(TypedDict, total=False):
    """Keyword arguments of ObjectiveTerm besides kind and path: dqa_objective_term."""

    weight: float
    target: Sequence[float]
    gamma: float
    epsilon: float


class SearchOptions(TypedDict, total=False):
    """Keyword arguments of CmaEs: dqa_cma_es_options."""

    population: int
    seed: int
    sigma: float


@dataclass(frozen=True)
class ActuatorOptions:
    """A muscle region as a Gaussian: mean (m), variance (m^2), euler (rad), each [3]. dqa_actuator_options."""

    category: int = 0
    kind: int = 0
    mean: tuple[float, float, float] = (0.0, 0.0, 0.0)
    variance: tuple[float, float, float] = (1.0, 1.0, 1.0)
    euler: tuple[float, float, float] = (0.0, 0.0, 0.0)
    side: int = 0
    layers: int = 4


@dataclass(frozen=True)
class SpaceInfo:
    """dqa_shape_space_info; cell_size in m."""

    dims: int
    cells_x: int
    cells_y: int
    cells_z: int
    n_bases: int
    n_signals: int
    is_built: int
    n_cells: int
    cell_size: float


@dataclass(frozen=True)
class SignalInfo:
    """What one actuation signal drives: dqa_signal_info."""

    category: int
    kind: int
    layer: int
    group: int


@dataclass(frozen=True)
class SimulatorInfo:
    """dqa_simulator_info; time in s, masses in kg, volume in m^3, cell_size in m."""

    dims: int
    n_bases: int
    n_signals: int
    n_sensors: int
    has_design: int
    n_nodes: int
    n_active_cells: int
    n_body_cells: int
    n_faces: int
    n_muscle_cells: int
    factor_entries: int
    steps: int
    newton_iterations: int
    linear_iterations: int
    adjoint_iterations: int
    time: float
    total_mass: float
    volume: float
    cell_size: float
    last_residual: float
    setup_seconds: float
    barycenter_seconds: float


@dataclass(frozen=True)
class ActuatorInfo:
    """An actuator of the current design: dqa_actuator_info; lengths in m, covariance in m^2, matrices by rows."""

    category: int
    kind: int
    side: int
    layers: int
    n_signals: int
    first_signal: int
    mean: tuple[float, ...]
    covariance: tuple[float, ...]
    half: tuple[float, ...]
    normal: tuple[float, ...]
    edge: tuple[float, ...]
    share: float
    strength: float


@dataclass(frozen=True)
class ControllerInfo:
    """dqa_controller_info."""

    kind: int
    n_signals: int
    n_sensors: int
    has_pullback: int
    n_parameters: int


@dataclass(frozen=True)
class TapeStatistics:
    """dqa_tape_statistics."""

    steps: int
    bytes: int
    newton_iterations: int
    linear_iterations: int
    adjoint_iterations: int
    worst_residual: float
    worst_adjoint_residual: float
    checkpoints: int
    recomputed_steps: int
    rescued_steps: int
    indefinite_steps: int


@dataclass(frozen=True)
class GradientReport:
    """What check_gradient found: dqa_gradient_check_report."""

    one_sided: int
    adjoint: float
    finite_difference: float
    relative_error: float
    taylor_slope: float
    gradient_norm: float
    step: float


@dataclass(frozen=True)
class SearchInfo:
    """dqa_cma_es_info."""

    asked: int
    n: int
    population: int
    generation: int
    evaluations: int
    sigma: float
    widest: float
    axis_ratio: float


#: The struct of the header that each record or set of options stands for.
STRUCTS: dict[type, str] = {
    SpaceOptions: "dqa_shape_space_options", SimulatorOptions: "dqa_simulator_options",
    PerceptronOptions: "dqa_mlp_options", TermOptions: "dqa_objective_term", ActuatorOptions: "dqa_actuator_options",
    SpaceInfo: "dqa_shape_space_info", SignalInfo: "dqa_signal_info", SimulatorInfo: "dqa_simulator_info",
    ActuatorInfo: "dqa_actuator_info", ControllerInfo: "dqa_controller_info", TapeStatistics: "dqa_tape_statistics",
    GradientReport: "dqa_gradient_check_report", SearchOptions: "dqa_cma_es_options", SearchInfo: "dqa_cma_es_info",
}


def visible_fields(struct: str) -> list[str]:
    """Names of a struct's fields that mean something to a caller."""
    return [name for name, _ in ffi.typeof(struct).fields if name not in _HIDDEN]


def _assign(struct: Any, name: str, kind: Any, value: Any) -> None:
    if kind.kind == "array":
        values = np.asarray(value)
        if values.shape != (kind.length,):
            raise ArgumentError(f"{name}: expected {kind.length} numbers, got shape {list(values.shape)}")
        setattr(struct, name, values.tolist())
    else:
        setattr(struct, name, value)


def options(struct: str, init: Any, values: Any, **pointers: Any) -> Any:
    """A struct filled by its _init function, then with `values` by name; `pointers` go in as they are."""
    filled = ffi.new(f"{struct} *")
    check(init(filled, ffi.sizeof(struct)))
    kinds = {name: field_.type for name, field_ in ffi.typeof(struct).fields if name not in _HIDDEN}
    for name, value in values.items():
        if name not in kinds or kinds[name].kind == "pointer":
            known = ", ".join(sorted(key for key, kind in kinds.items() if kind.kind != "pointer"))
            raise TypeError(f"unknown option {name!r}; expected one of {known}")
        try:
            _assign(filled[0], name, kinds[name], value)
        except (TypeError, OverflowError) as error:
            raise ArgumentError(f"{name}: {error}") from None
    for name, value in pointers.items():
        setattr(filled[0], name, value)
    return filled


def _plain(value: Any) -> Any:
    return tuple(value) if isinstance(value, ffi.CData) else value


def record(kind: type[Record], filled: Any) -> Record:
    """The Python record of a filled struct."""
    names = [entry.name for entry in dataclasses.fields(kind)]  # type: ignore[arg-type]
    return kind(**{name: _plain(getattr(filled, name)) for name in names})


def told(kind: type[Record], function: Any, *arguments: Any) -> Record:
    """Calls function(*arguments, struct *, size) and returns the record of what it filled."""
    struct = STRUCTS[kind]
    filled = ffi.new(f"{struct} *")
    check(function(*arguments, filled, ffi.sizeof(struct)))
    return record(kind, filled)


def actuator_options(values: ActuatorOptions) -> Any:
    """The struct of an actuator."""
    return options("dqa_actuator_options", lib.dqa_actuator_options_init, dataclasses.asdict(values))
