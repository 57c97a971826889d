# SPDX-License-Identifier: MIT
"""The library's constants as enumerations; wherever one is taken, its plain number is taken too."""
from __future__ import annotations

from enum import IntEnum


class Peak(IntEnum):
    """What the density is divided by. SMOOTH is differentiable."""

    SMOOTH = 0
    PAPER = 1


class Up(IntEnum):
    """Which way meshes stand."""

    AUTO = 0
    Z = 1
    Y = 2


class Interpolation(IntEnum):
    """Of actuators between the bases: linear as in the paper, or Bures-Wasserstein."""

    LINEAR = 0
    BURES = 1


class Actuator(IntEnum):
    """Kinds of actuator."""

    CAUDAL = 0
    FINS = 1


class Side(IntEnum):
    """Sides of an actuator."""

    BOTH = 0
    LEFT = 1
    RIGHT = 2


class Method(IntEnum):
    """How the equations of a step are solved."""

    NEWTON_PCG = 0
    NEWTON_DIRECT = 1
    PROJECTIVE = 2


class Preconditioner(IntEnum):
    """Of conjugate gradients: speed only."""

    MULTILEVEL = 0
    FACTOR = 1


class Precision(IntEnum):
    """Of the preconditioner alone."""

    SINGLE = 0
    DOUBLE = 1


class Integrator(IntEnum):
    """First order, or second order at the same cost."""

    IMPLICIT_EULER = 0
    BDF2 = 1


class Material(IntEnum):
    """Elastic energy densities."""

    COROTATED = 0
    COROTATED_VOLUME = 1
    NEO_HOOKEAN = 2


class Quadrature(IntEnum):
    """Points a cell at which elastic energies are integrated: 2^dims, or one with hourglass control."""

    FULL = 0
    REDUCED = 1


class Water(IntEnum):
    """Inside the implicit step, explicit for comparison, or none."""

    NONE = 0
    IMPLICIT = 1
    EXPLICIT = 2


class Faces(IntEnum):
    """Which faces of the surface the water acts on."""

    BOTH = 0
    WINDWARD = 1


class ControllerKind(IntEnum):
    """Kinds of controller; in the header DQA_CONTROLLER_*."""

    SINUSOID = 0
    MLP = 1
    CALLBACK = 2


class Objective(IntEnum):
    """Terms of a loss; the header has their formulas."""

    TRAVEL = 0
    POSITION_KEEPING = 1
    EFFICIENCY = 2
    EFFORT = 3
    PATH = 4


class Seed(IntEnum):
    """What Adjoint.seed adds to: dL/dq or dL/dv of a state."""

    POSITION = 0
    VELOCITY = 1


class Wrt(IntEnum):
    """What Adjoint.gradient reads and check_gradient proves, with the shapes that the header gives."""

    WEIGHTS = 0
    CONTROL = 1
    ACTUATION = 2
    INITIAL_POSITION = 3
    INITIAL_VELOCITY = 4
    WATER = 5
    CURRENT = 6
    CURRENT_TABLE = 7
    YOUNGS_MODULUS = 8
    MUSCLE_STIFFNESS = 9
    MATERIAL = 10
    LAME = 11


class LogLevel(IntEnum):
    """Of messages; in the header DQA_LOG_*."""

    ERROR = 1
    WARNING = 2
    INFO = 3
    DEBUG = 4


#: The header's prefix of each enumeration: a test compares the two.
PREFIXES: dict[type[IntEnum], str] = {
    Peak: "DQA_PEAK_", Up: "DQA_UP_", Interpolation: "DQA_INTERPOLATION_", Actuator: "DQA_ACTUATOR_",
    Side: "DQA_SIDE_", Method: "DQA_METHOD_", Preconditioner: "DQA_PRECONDITIONER_", Precision: "DQA_PRECISION_",
    Integrator: "DQA_INTEGRATOR_", Material: "DQA_MATERIAL_", Quadrature: "DQA_QUADRATURE_", Water: "DQA_WATER_",
    Faces: "DQA_FACES_",
    ControllerKind: "DQA_CONTROLLER_", Objective: "DQA_OBJECTIVE_", Seed: "DQA_SEED_", Wrt: "DQA_WRT_",
    LogLevel: "DQA_LOG_",
}
