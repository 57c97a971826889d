# SPDX-License-Identifier: MIT
"""A rollout as a function of unnormalised weights and control, and a step as a function of state and actuation: with
their pullbacks, in NumPy. What diffaqua.torch and diffaqua.jax hand to automatic differentiation."""
from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ._arrays import Array, ArrayLike, numbers
from ._callbacks import Progress
from .constants import Seed, Wrt
from .controller import Controller
from .errors import ArgumentError
from .simulator import Simulator
from .tape import Adjoint, Loss, Tape

#: (loss_bar) -> gradients with respect to w [n_bases] and theta [n_parameters].
RolloutPullback = Callable[[float], "tuple[Array, Array]"]
#: (q_bar, v_bar) -> gradients with respect to q, v [n_nodes][dims] and the actuation [n_signals].
StepPullback = Callable[[ArrayLike, ArrayLike], "tuple[Array, Array, Array]"]


class Gradient(NamedTuple):
    """A loss and its gradients."""

    loss: float
    weights: Array
    control: Array


class Rollout:
    """loss(w, theta) of n_steps from rest: the design is alpha = w / sum(w), with w [n_bases] >= 0, the controller has
    the parameters theta [n_parameters]. Uses simulator and controller for itself while it computes."""

    def __init__(self, simulator: Simulator, controller: Controller, n_steps: int, loss: Loss, *,
                 memory_bytes: int = 0, progress: Progress | None = None) -> None:
        self.simulator = simulator
        self.controller = controller
        self.n_steps = n_steps
        self.loss = loss
        self.memory_bytes = memory_bytes
        self.progress = progress
        self.n_weights = simulator.info().n_bases
        self.n_parameters = controller.info().n_parameters

    def _shares(self, w: ArrayLike) -> tuple[Array, float]:
        weights = numbers("w", w, (self.n_weights,))
        total = float(weights.sum())
        if not (np.all(weights >= 0.0) and 0.0 < total < np.inf):
            raise ArgumentError(f"w: expected numbers >= 0 with a positive sum, got {weights}")
        return weights / total, total

    def record(self, w: ArrayLike, theta: ArrayLike) -> Tape:
        """Runs the rollout; its record."""
        alpha, _ = self._shares(w)
        with self.simulator._use(), self.controller._use():
            self.controller.parameters = numbers("theta", theta, (self.n_parameters,))
            self.simulator.set_weights(alpha, self.progress)
            tape = Tape(self.simulator, memory_bytes=self.memory_bytes)
            self.simulator.rollout(self.controller, self.n_steps, tape, self.progress)
        return tape

    def __call__(self, w: ArrayLike, theta: ArrayLike) -> float:
        """The loss."""
        with self.record(w, theta) as tape:
            return tape.objective(self.loss)[0]

    def pullback(self, w: ArrayLike, theta: ArrayLike) -> tuple[float, RolloutPullback]:
        """(loss, its pullback), which may be called at any time later."""
        alpha, total = self._shares(w)
        tape = self.record(w, theta)

        def pull(loss_bar: float) -> tuple[Array, Array]:
            by_alpha, by_theta = tape.gradient(self.loss, Wrt.WEIGHTS, Wrt.CONTROL, progress=self.progress)
            # d alpha_i / d w_j = (delta_ij - alpha_i) / sum(w)
            return loss_bar * (by_alpha - by_alpha @ alpha) / total, loss_bar * by_theta

        return tape.objective(self.loss)[0], pull

    def gradient(self, w: ArrayLike, theta: ArrayLike) -> Gradient:
        """Loss and gradients at once."""
        loss, pull = self.pullback(w, theta)
        return Gradient(loss, *pull(1.0))

    def packed(self, x: ArrayLike) -> tuple[float, Array]:
        """(loss, gradient) of x = (w, theta) in one array, as scipy.optimize.minimize(..., jac=True) takes it."""
        values = numbers("x", x, (self.n_weights + self.n_parameters,))
        found = self.gradient(values[:self.n_weights], values[self.n_weights:])
        return found.loss, np.concatenate([found.weights, found.control])


class Step:
    """(q, v, actuation) -> (q, v) after one step of the simulator's present design, for a control loop that lives
    outside of the library. The clock stands at 0 in every step, so that currents over time do not pass; BDF2 starts
    anew."""

    def __init__(self, simulator: Simulator) -> None:
        self.simulator = simulator

    def __call__(self, q: ArrayLike, v: ArrayLike, actuation: ArrayLike) -> tuple[Array, Array]:
        """The state after the step."""
        with self.simulator._use():
            self.simulator.set_state(q, v)
            self.simulator.step(actuation)
            return self.simulator.state()

    def pullback(self, q: ArrayLike, v: ArrayLike, actuation: ArrayLike) -> tuple[Array, Array, StepPullback]:
        """(q, v after the step, the pullback), which may be called at any time later."""
        with self.simulator._use():
            tape = Tape(self.simulator)
            self.simulator.set_state(q, v)
            self.simulator.step(actuation, tape)
            after = self.simulator.state()

        def pull(q_bar: ArrayLike, v_bar: ArrayLike) -> tuple[Array, Array, Array]:
            with Adjoint(tape) as adjoint:
                adjoint.seed(1, Seed.POSITION, q_bar)
                adjoint.seed(1, Seed.VELOCITY, v_bar)
                adjoint.backward()
                return (adjoint.gradient(Wrt.INITIAL_POSITION), adjoint.gradient(Wrt.INITIAL_VELOCITY),
                        adjoint.gradient(Wrt.ACTUATION)[0])

        return (*after, pull)
