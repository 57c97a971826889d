# SPDX-License-Identifier: MIT
"""Co-design of soft underwater swimmers: shape space, simulator, controllers, tapes, gradients.

Thin over the C interface of libdiffaqua, whose header diffaqua.h explains every quantity. Arrays are NumPy's, of
doubles, and lengths are SI units. Long calls take progress(done, total); a true result or an exception stops them, and
so does Ctrl-C. Objects are closed by close(), by `with`, or when nothing refers to them.

    diffaqua.torch, diffaqua.jax   a rollout, or a step, as a differentiable function
    diffaqua.gym                   an environment for reinforcement learning
    diffaqua.viz                   pictures
    diffaqua.sweep                 many tasks over the processes of any executor
"""
from __future__ import annotations

from collections.abc import Callable

from . import _callbacks, errors, rollout
from ._library import lib as _lib
from ._library import path as library_path
from ._library import text as _text
from .constants import (Actuator, ControllerKind, Faces, Integrator, Interpolation, LogLevel, Material, Method,
                        Objective, Peak, Precision, Preconditioner, Quadrature, Seed, Side, Up, Water, Wrt)
from .controller import CallbackController, Controller, Perceptron, Sinusoid
from .errors import (AccessError, ArgumentError, CancelledError, DiffaquaError, DivergedError, FileError, InternalError,
                     MeshError, NotConvergedError, OutOfMemoryError, StateError, UnsupportedError)
from .optimize import CmaEs, adam_step, project_simplex
from ._progress import ProgressBar
from ._sweep import SweepError, sweep
from .shape_space import CancelToken, ShapeSpace
from .simulator import Mesh, Muscles, Simulator, Surface
from .structs import ActuatorOptions
from .tape import Adjoint, ObjectiveTerm, Tape, check_gradient

#: Of the loaded library.
__version__ = _text(_lib.dqa_version())


def features() -> frozenset[str]:
    """What the library was built with, e.g. "stl", "openmp", "avx2"."""
    return frozenset(_text(_lib.dqa_features()).split())


def set_log_handler(handler: Callable[[int, str], object] | None, level: int = LogLevel.INFO) -> None:
    """handler(level, message) for the messages of the whole process, from any thread; None silences them. What it
    raises is printed and stops nothing."""
    _callbacks.set_log_handler(handler, level)


__all__ = [
    "AccessError", "Actuator", "ActuatorOptions", "Adjoint", "ArgumentError", "CallbackController", "CancelToken",
    "CancelledError", "CmaEs", "Controller", "ControllerKind", "DiffaquaError", "DivergedError", "Faces", "FileError",
    "Integrator", "InternalError", "Interpolation", "LogLevel", "Material", "Mesh", "MeshError", "Method", "Muscles",
    "NotConvergedError", "Objective", "ObjectiveTerm", "OutOfMemoryError", "Peak", "Perceptron", "Precision",
    "Preconditioner", "ProgressBar", "Quadrature", "Seed", "ShapeSpace", "Side", "Simulator", "Sinusoid",
    "StateError", "Surface", "SweepError", "Tape",
    "UnsupportedError", "Up", "Water", "Wrt", "adam_step", "check_gradient", "errors", "features", "library_path",
    "project_simplex", "set_log_handler", "sweep", "__version__",
]
