# SPDX-License-Identifier: MIT
"""A Gymnasium environment: one design, a policy that drives its muscles."""
from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np

from ._arrays import Array, ArrayLike, numbers
from .errors import ArgumentError, DivergedError, NotConvergedError
from .simulator import Simulator


class SwimmerEnv(gymnasium.Env[Any, Any]):
    """Swim ahead. Observation [5 dims]: Simulator.sensors. Action [n_signals] in [-1, 1], held for `frame_skip` steps.
    Reward: metres that the centre of mass moves along +x, minus effort_weight times the time integral of the squared
    action (s). Truncated after max_steps actions; terminated where the solver gives up.

    reset(seed=..., options={"weights": [n_bases]}) begins at rest with velocities that are noise of `noise` m/s, of the
    seed; weights choose another design. info has the time (s), the distance since reset (m) and the effort (s)."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"]}

    def __init__(self, simulator: Simulator, *, weights: ArrayLike | None = None, max_steps: int = 200,
                 frame_skip: int = 1, effort_weight: float = 0.0, noise: float = 1e-3,
                 render_mode: str | None = None) -> None:
        if max_steps < 1 or frame_skip < 1:
            raise ArgumentError(f"max_steps, frame_skip: expected numbers >= 1, got {max_steps}, {frame_skip}")
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ArgumentError(f"render_mode: expected None or 'rgb_array', got {render_mode!r}")
        self.simulator = simulator
        if weights is not None:
            simulator.set_weights(weights)
        info = simulator.info()
        if not info.has_design:
            raise ArgumentError("weights: the simulator has no design yet; give its weights")
        self.max_steps, self.frame_skip = max_steps, frame_skip
        self.effort_weight, self.noise, self.render_mode = effort_weight, noise, render_mode
        self.metadata = {**self.metadata, "render_fps": max(1, round(1.0 / (simulator.time_step * frame_skip)))}
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (5 * info.dims,), dtype=np.float64)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (info.n_signals,), dtype=np.float64)
        self._taken, self._effort, self._time = 0, 0.0, 0.0
        self._masses = self._node_masses()
        self._start = self._place()

    def _node_masses(self) -> Array:
        """Shares of the mass: a cell's goes to its nodes alike."""
        mesh = self.simulator.mesh()
        shares = np.zeros(self.simulator.info().n_nodes)
        np.add.at(shares, mesh.cell_nodes, mesh.occupancy[:, None])
        shares /= shares.sum()
        return shares

    def _place(self) -> float:
        q, _ = self.simulator.state()
        return float(self._masses @ q[:, 0])

    def _observation(self) -> Array:
        return self.simulator.sensors().ravel()

    def _info(self, place: float) -> dict[str, float]:
        return {"time": self._time, "distance": place - self._start, "effort": self._effort}

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        super().reset(seed=seed)
        if options and "weights" in options:
            self.simulator.set_weights(options["weights"])
            self._masses = self._node_masses()
        self.simulator.set_state()
        q, v = self.simulator.state()
        self.simulator.set_state(q, self.noise * self.np_random.standard_normal(v.shape))
        self._taken, self._effort, self._time = 0, 0.0, 0.0
        self._start = self._place()
        return self._observation(), self._info(self._start)

    def step(self, action: ArrayLike) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        values = numbers("action", action, self.action_space.shape)
        before, duration = self._place(), self.simulator.time_step * self.frame_skip
        terminated = False
        try:
            for _ in range(self.frame_skip):
                self.simulator.step(values)
        except (NotConvergedError, DivergedError):
            terminated = True  # the state is that before the step that failed
        self._taken += 1
        self._time += duration
        effort = duration * float(values @ values)
        self._effort += effort
        place = self._place()
        reward = place - before - self.effort_weight * effort
        return self._observation(), reward, terminated, self._taken >= self.max_steps, self._info(place)

    def render(self) -> Any:
        if self.render_mode is None:
            return None
        from . import viz
        return viz.picture(self.simulator)
