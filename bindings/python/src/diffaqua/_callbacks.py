# SPDX-License-Identifier: MIT
"""Python functions that the library calls. What they raise never crosses the boundary: it is kept, the call is asked to
stop, and the exception is raised again where the call returns to Python."""
from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ._arrays import view
from ._library import check, ffi, keep_exception, lib, text

#: Called with (done, total); a true result, or an exception, stops the call.
Progress = Callable[[int, int], object]


def guarded(c_type: str, function: Callable[..., object]) -> Any:
    """A C function pointer of that type which returns 0, or 1 where the function returns something true or raises."""

    def call(*arguments: Any) -> int:
        return 1 if function(*arguments) else 0

    def keep(_kind: object, exception: BaseException, _traceback: object) -> None:
        keep_exception(exception)

    # Not a try of our own: an interrupt may come before its first line.
    return ffi.callback(c_type, call, error=1, onerror=keep)


def progress_callback(progress: Progress | None) -> Any:
    """For the time of one call. There is always one, so that Ctrl-C stops long calls."""
    if progress is None:
        return _IDLE
    if not callable(progress):
        raise TypeError(f"progress: expected a function of (done, total), got {type(progress).__name__}")
    return guarded("dqa_progress", lambda done, total, _data: progress(done, total))


# Its call is where Python gets to see a Ctrl-C.
_IDLE = guarded("dqa_progress", lambda _done, _total, _data: None)


def current_callbacks(current: Callable[[float], Any], pullback: Callable[[float, Any], object] | None,
                      dims: int) -> tuple[Any, Any]:
    """(dqa_current, dqa_current_pullback or NULL) of current(time) -> [dims] and pullback(time, current_bar)."""

    def evaluate(time: float, out: Any, _data: Any) -> int:
        view(out, dims)[:] = np.broadcast_to(np.asarray(current(time), dtype=np.float64), (dims,))
        return 0

    def receive(time: float, bar: Any, _data: Any) -> int:
        assert pullback is not None
        pullback(time, view(bar, dims).copy())
        return 0

    return (guarded("dqa_current", evaluate),
            ffi.NULL if pullback is None else guarded("dqa_current_pullback", receive))


def control_callbacks(evaluate: Callable[..., Any], pullback: Callable[..., Any] | None) -> tuple[Any, Any]:
    """(dqa_control_evaluate, dqa_control_pullback or NULL) of the functions that CallbackController describes."""

    def run(step: int, time: float, sensors: Any, n_sensors: int, theta: Any, n_parameters: int, actuation: Any,
            n_signals: int, _data: Any) -> int:
        value = np.asarray(evaluate(step, time, view(sensors, n_sensors).copy(), view(theta, n_parameters).copy()),
                           dtype=np.float64)
        if value.shape != (n_signals,):
            raise ValueError(f"evaluate: expected an actuation of shape [{n_signals}], got {list(value.shape)}")
        view(actuation, n_signals)[:] = value
        return 0

    def pull(step: int, time: float, sensors: Any, n_sensors: int, theta: Any, n_parameters: int, bar: Any,
             n_signals: int, theta_bar: Any, sensors_bar: Any, _data: Any) -> int:
        assert pullback is not None
        result = pullback(step, time, view(sensors, n_sensors).copy(), view(theta, n_parameters).copy(),
                          view(bar, n_signals).copy())
        try:
            by_theta, by_sensors = result
        except (TypeError, ValueError):
            raise ValueError("pullback: expected (theta_bar, sensors_bar)") from None
        for name, value, out, n in (("theta_bar", by_theta, theta_bar, n_parameters),
                                    ("sensors_bar", by_sensors, sensors_bar, n_sensors)):
            if n == 0:
                continue
            array = np.asarray(value, dtype=np.float64)
            if array.shape != (n,):
                raise ValueError(f"pullback: expected {name} of shape [{n}], got {list(array.shape)}")
            view(out, n)[:] = array
        return 0

    return (guarded("dqa_control_evaluate", run),
            ffi.NULL if pullback is None else guarded("dqa_control_pullback", pull))


# ------------------------------------------------------------------ log
_log_handler: list[Any] = []  # every one that was ever set: a message under way may still reach it


def set_log_handler(handler: Callable[[int, str], object] | None, level: int) -> None:
    """See diffaqua.set_log_handler."""
    if handler is None:
        check(lib.dqa_set_log_handler(ffi.NULL, 0, ffi.NULL))
        return

    def call(message_level: int, message: Any, _data: Any) -> None:
        # A message may come from any thread and stops nothing: cffi prints what the handler raises.
        handler(message_level, text(message))

    pointer = ffi.callback("dqa_log_handler", call)
    check(lib.dqa_set_log_handler(pointer, level, ffi.NULL))
    _log_handler.append(pointer)

