# SPDX-License-Identifier: MIT
"""PyTorch: a rollout, or a step, as a differentiable function of tensors. Results have the floating type that PyTorch
promotes the arguments to (the default one for whole numbers), and the place of the first argument; the library computes
in doubles on the processor. Gradients are of first order: a second backward is
refused."""
from __future__ import annotations

import functools
from typing import Any

import numpy as np
import torch

from ._arrays import Array
from .controller import Controller
from .errors import ArgumentError, UnsupportedError
from .rollout import Rollout, Step
from .simulator import Simulator
from .tape import Loss


def _array(tensor: torch.Tensor) -> Array:
    if tensor.is_complex():
        raise ArgumentError(f"expected tensors of real numbers, got {tensor.dtype}")
    return np.asarray(tensor.detach().cpu().numpy(), dtype=np.float64)


def _like(values: Any, tensor: torch.Tensor) -> torch.Tensor:
    return torch.as_tensor(values, dtype=tensor.dtype, device=tensor.device)


def _result(values: Any, *tensors: torch.Tensor) -> torch.Tensor:
    """Of a function of these tensors, which may hold whole numbers."""
    dtype = functools.reduce(torch.promote_types, (tensor.dtype for tensor in tensors))
    if not dtype.is_floating_point:
        dtype = torch.get_default_dtype()
    return torch.as_tensor(values, dtype=dtype, device=tensors[0].device)


class _FirstOrder(torch.autograd.Function):
    """A gradient that came from the library and depends on tensors in a way that is not known to autograd."""

    @staticmethod
    def forward(ctx: Any, value: torch.Tensor, *_tensors: torch.Tensor) -> torch.Tensor:
        return value.clone()

    @staticmethod
    def backward(ctx: Any, *_bars: torch.Tensor) -> Any:
        raise UnsupportedError("second derivatives are not available: the gradient of a rollout or step cannot be "
                               "differentiated again")


class _Rollout(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, w: torch.Tensor, theta: torch.Tensor, rollout: Rollout) -> torch.Tensor:
        if any(ctx.needs_input_grad):
            loss, ctx.pull = rollout.pullback(_array(w), _array(theta))
        else:
            loss = rollout(_array(w), _array(theta))
        ctx.save_for_backward(w, theta)  # autograd then notices changes in place
        return _result(loss, w, theta)

    @staticmethod
    def backward(ctx: Any, loss_bar: torch.Tensor) -> tuple[Any, ...]:
        w, theta = ctx.saved_tensors
        by_w, by_theta = ctx.pull(float(loss_bar))
        known = (w, theta, loss_bar)
        return _FirstOrder.apply(_like(by_w, w), *known), _FirstOrder.apply(_like(by_theta, theta), *known), None


class _Step(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, q: torch.Tensor, v: torch.Tensor, actuation: torch.Tensor, step: Step) -> tuple[Any, ...]:
        arrays = _array(q), _array(v), _array(actuation)
        if any(ctx.needs_input_grad):
            q_after, v_after, ctx.pull = step.pullback(*arrays)
        else:
            q_after, v_after = step(*arrays)
        ctx.save_for_backward(q, v, actuation)
        return _result(q_after, q, v, actuation), _result(v_after, q, v, actuation)

    @staticmethod
    def backward(ctx: Any, q_bar: torch.Tensor, v_bar: torch.Tensor) -> tuple[Any, ...]:
        bars = ctx.pull(_array(q_bar), _array(v_bar))
        known = (*ctx.saved_tensors, q_bar, v_bar)
        return (*(_FirstOrder.apply(_like(bar, tensor), *known) for bar, tensor in zip(bars, ctx.saved_tensors)), None)


class RolloutLoss(torch.nn.Module):
    """loss(w [n_bases], theta [n_parameters]): the loss of n_steps from rest of the design w / sum(w), w >= 0, under a
    controller with parameters theta."""

    def __init__(self, simulator: Simulator, controller: Controller, n_steps: int, loss: Loss,
                 memory_bytes: int = 0) -> None:
        super().__init__()
        self.rollout = Rollout(simulator, controller, n_steps, loss, memory_bytes=memory_bytes)

    def forward(self, w: torch.Tensor, theta: torch.Tensor) -> torch.Tensor:
        """The loss, a tensor of no dimension."""
        result: torch.Tensor = _Rollout.apply(w, theta, self.rollout)
        return result


class SimulatorStep(torch.nn.Module):
    """(q, v [n_nodes][dims], actuation [n_signals]) -> (q, v) after one step of the simulator's design: see
    diffaqua.rollout.Step."""

    def __init__(self, simulator: Simulator) -> None:
        super().__init__()
        self.step = Step(simulator)

    def forward(self, q: torch.Tensor, v: torch.Tensor, actuation: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """The state after the step."""
        result: tuple[torch.Tensor, torch.Tensor] = _Step.apply(q, v, actuation, self.step)
        return result
