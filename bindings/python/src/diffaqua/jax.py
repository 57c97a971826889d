# SPDX-License-Identifier: MIT
"""JAX: a rollout, or a step, as a function that jax.grad, jax.jit and jax.vmap take; vmap runs one after another.
Results have the type of the first argument: enable jax_enable_x64 for doubles. Gradients are of first order and reverse
mode."""
from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from .controller import Controller
from .errors import UnsupportedError
from .rollout import Rollout, Step
from .simulator import Simulator
from .tape import Loss


def _call(function: Callable[..., tuple[Any, ...]], shapes: tuple[Any, ...], *arguments: Any) -> tuple[Any, ...]:
    """A NumPy function as an operation of JAX, whose results have the given shapes and types."""

    def in_doubles(*values: Any) -> tuple[Any, ...]:
        results = function(*(np.asarray(value, dtype=np.float64) for value in values))
        return tuple(np.asarray(result, dtype=shape.dtype) for result, shape in zip(results, shapes))

    outcome: tuple[Any, ...] = jax.pure_callback(in_doubles, shapes, *arguments, vmap_method="sequential")
    return outcome


def _first_order_only(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function, which says so clearly when it is to be differentiated."""
    wrapped: Any = jax.custom_vjp(function)

    def refuse(*_: Any) -> Any:
        raise UnsupportedError("second derivatives are not available: the gradient of a rollout or step cannot be "
                               "differentiated again")

    wrapped.defvjp(refuse, refuse)
    return lambda *arguments: wrapped(*arguments)


def _shape(value: Any) -> Any:
    return jax.ShapeDtypeStruct(jnp.shape(value), jnp.result_type(value))


def rollout_loss(simulator: Simulator, controller: Controller, n_steps: int, loss: Loss,
                 memory_bytes: int = 0) -> Callable[[Any, Any], Any]:
    """loss(w [n_bases], theta [n_parameters]) of n_steps from rest: see diffaqua.rollout.Rollout."""
    rollout = Rollout(simulator, controller, n_steps, loss, memory_bytes=memory_bytes)

    @_first_order_only
    def with_gradient(w: Any, theta: Any) -> Any:
        scalar = jax.ShapeDtypeStruct((), jnp.result_type(w))
        return _call(lambda *x: tuple(rollout.gradient(*x)), (scalar, _shape(w), _shape(theta)), w, theta)

    @jax.custom_vjp
    def value(w: Any, theta: Any) -> Any:
        return _call(lambda *x: (rollout(*x),), (jax.ShapeDtypeStruct((), jnp.result_type(w)),), w, theta)[0]

    def forward(w: Any, theta: Any) -> Any:
        # There is no tape to keep between two calls of a pure function: the gradient is what is kept.
        result, by_w, by_theta = with_gradient(w, theta)
        return result, (by_w, by_theta)

    def backward(kept: Any, loss_bar: Any) -> Any:
        by_w, by_theta = kept
        return (loss_bar * by_w).astype(by_w.dtype), (loss_bar * by_theta).astype(by_theta.dtype)

    value.defvjp(forward, backward)
    return lambda w, theta: value(_floats(w), _floats(theta))


def simulator_step(simulator: Simulator) -> Callable[[Any, Any, Any], tuple[Any, Any]]:
    """(q, v [n_nodes][dims], actuation [n_signals]) -> (q, v) after one step: see diffaqua.rollout.Step."""
    step = Step(simulator)

    @_first_order_only
    def pulled(q: Any, v: Any, actuation: Any, q_bar: Any, v_bar: Any) -> Any:
        return _call(lambda *x: step.pullback(*x[:3])[2](*x[3:]), (_shape(q), _shape(v), _shape(actuation)), q, v,
                     actuation, q_bar, v_bar)

    @jax.custom_vjp
    def value(q: Any, v: Any, actuation: Any) -> Any:
        return _call(step, (_shape(q), _shape(v)), q, v, actuation)

    value.defvjp(lambda *x: (value(*x), x), lambda x, bars: tuple(pulled(*x, *bars)))
    return lambda q, v, actuation: value(_floats(q), _floats(v), _floats(actuation))


def _floats(value: Any) -> Any:
    array = jnp.asarray(value)
    if jnp.issubdtype(array.dtype, jnp.complexfloating):
        raise TypeError(f"expected real numbers, got an array of {array.dtype}")
    return array if jnp.issubdtype(array.dtype, jnp.floating) else array.astype(jnp.result_type(float))
