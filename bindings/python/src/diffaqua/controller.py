# SPDX-License-Identifier: MIT
"""Controllers: a sine per signal, a perceptron that sees the sensors, and Python functions."""
from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ._arrays import Array, ArrayLike, numbers, output, pointer
from ._callbacks import control_callbacks
from ._handle import Handle, path_bytes
from ._library import check, ffi, lib
from .errors import ArgumentError
from .structs import ControllerInfo, options, told

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from .structs import PerceptronOptions


class Controller(Handle):
    """Parameters theta and the map (sensors, step) -> actuation, each signal in [-1, 1]."""

    _what = "controller"
    _keeps: tuple[Any, ...] = ()  # what the library calls into, for as long as controller or tapes live

    def __init__(self, create: Callable[[Any], int]) -> None:
        super().__init__(create, "dqa_controller", lib.dqa_controller_free)

    def info(self) -> ControllerInfo:
        """Kind and sizes."""
        with self._use() as controller:
            return told(ControllerInfo, lib.dqa_controller_get_info, controller)

    @property
    def parameters(self) -> Array:
        """A copy of theta [n_parameters]; assigning replaces all of them."""
        theta = np.zeros(self.info().n_parameters)
        with self._use() as controller:
            check(lib.dqa_controller_get_parameters(controller, pointer(theta), theta.size))
        return theta

    @parameters.setter
    def parameters(self, theta: ArrayLike) -> None:
        values = numbers("theta", theta, (None,))
        with self._use() as controller:
            check(lib.dqa_controller_set_parameters(controller, pointer(values), values.size))

    def evaluate(self, step: int, sensors: ArrayLike | None = None, out: Array | None = None) -> Array:
        """Actuation [n_signals] at a step index, from sensors [n_sensors] where it reads them."""
        info = self.info()
        actuation = output("out", out, (info.n_signals,))
        seen = None if sensors is None else numbers("sensors", sensors, (None,))
        with self._use() as controller:
            check(lib.dqa_controller_evaluate(controller, step, pointer(seen), 0 if seen is None else seen.size,
                                              pointer(actuation), actuation.size))
        return actuation

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes settings and parameters."""
        with self._use() as controller:
            check(lib.dqa_controller_save(controller, path_bytes(path)))

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Controller:
        """The controller of a file that save() wrote."""
        name = path_bytes(path)
        return Controller(lambda out: lib.dqa_controller_load(name, out))


class Sinusoid(Controller):
    """Open loop: a sin(omega t + phi) per signal; theta [n_signals][3] = (a in [0, 1], omega in rad/s, phi in rad)."""

    def __init__(self, n_signals: int, time_step: float = 1.0 / 30.0) -> None:
        super().__init__(lambda out: lib.dqa_controller_create_sinusoid(n_signals, time_step, out))


class Perceptron(Controller):
    """Closed loop: a multilayer perceptron with tanh; options as in PerceptronOptions, e.g. hidden=(64, 64)."""

    def __init__(self, **settings: Unpack[PerceptronOptions]) -> None:
        values: dict[str, Any] = dict(settings)
        if "n_hidden" in values:
            raise TypeError("unknown option 'n_hidden': give `hidden`, the neurons of each hidden layer")
        if "hidden" in values:
            hidden = [int(neurons) for neurons in values["hidden"]]
            room = dict(ffi.typeof("dqa_mlp_options").fields)["hidden"].type.length
            if len(hidden) > room:
                raise ArgumentError(f"hidden: expected at most {room} layers, got {len(hidden)}")
            values["n_hidden"] = len(hidden)
            values["hidden"] = hidden + [1] * (room - len(hidden))
        filled = options("dqa_mlp_options", lib.dqa_mlp_options_init, values)
        super().__init__(lambda out: lib.dqa_controller_create_mlp(filled, out))


class CallbackController(Controller):
    """A controller of Python functions, which must depend on their arguments alone:

    evaluate(step, time, sensors [n_sensors], theta [n_parameters]) -> actuation [n_signals], each in [-1, 1];
    pullback(step, time, sensors, theta, actuation_bar [n_signals]) -> (theta_bar [n_parameters], sensors_bar
    [n_sensors]): the transposed derivative times actuation_bar.

    n_sensors is 0 (open loop) or 5 dims. Without pullback an open loop still gives every gradient but CONTROL. What the
    functions raise stops the call and comes out of it."""

    def __init__(self, evaluate: Callable[[int, float, Array, Array], ArrayLike], *, n_signals: int, n_sensors: int = 0,
                 theta: ArrayLike = (), time_step: float = 1.0 / 30.0,
                 pullback: Callable[[int, float, Array, Array, Array], tuple[ArrayLike, ArrayLike]] | None = None
                 ) -> None:
        for name, function in (("evaluate", evaluate), ("pullback", pullback)):
            if function is not None and not callable(function):
                raise TypeError(f"{name}: expected a function, got {type(function).__name__}")
        values = numbers("theta", theta, (None,))
        run, pull = control_callbacks(evaluate, pullback)
        filled = options("dqa_callback_controller_options", lib.dqa_callback_controller_options_init,
                         {"n_signals": n_signals, "n_sensors": n_sensors, "time_step": time_step}, evaluate=run,
                         pullback=pull)
        super().__init__(lambda out: lib.dqa_controller_create_callback(
            filled, pointer(values) if values.size else ffi.NULL, values.size, out))
        self._keeps = (run, pull)
