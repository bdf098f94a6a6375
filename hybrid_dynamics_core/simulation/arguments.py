"""Arguments of a simulation: efforts, times, and checks of both."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arguments import require_type
from ..ground.check_arrays import finite_vectors
from ..limits import Limits, saturated
from ..robot.robot import Robot
from .settings import Settings

Efforts = Callable[[float, ClosedState], ArrayLike]  # (t [s], state) -> tau (n,)
Span = tuple[float, float]  # start and end [s]
MOST_SAMPLES = 10_000_000


def check_order(du: object, tau: object, t_span: object, settings: object) -> None:
    """Raise a clear error if positional arguments are shifted because one was left out."""
    order = "simulate(robot, u, du, tau, t_span, settings)"
    if isinstance(t_span, Settings):
        raise InputError(f"t_span is of type Settings; the order is {order}: is `du` left out?")
    if callable(du) or isinstance(du, Settings):
        raise InputError(f"du is of type {type(du).__name__}; the order is {order}")
    if isinstance(tau, Settings):
        raise InputError(f"tau is of type Settings; the order is {order}")
    require_type("settings", settings, Settings, "Settings(rate=100.0)")


def check_takes(tau: Efforts, state: ClosedState) -> None:
    """Raise if a function of efforts does not take a time and a state."""
    try:
        inspect.signature(tau).bind(0.0, state)
    except TypeError as error:
        raise InputError(f"tau: expected a function of (t, state): {error}") from error
    except ValueError:  # a builtin has no signature
        return


def saturating(robot: Robot, tau: Array | Efforts) -> Efforts:
    """Efforts as a function, no more than the drives give."""
    limits = Limits(robot)

    def given(t: float, state: ClosedState) -> Array:
        asked = tau(t, state) if callable(tau) else tau
        checked = finite_vectors("tau", asked, robot.active, -1)
        return saturated(limits, state, checked)

    return given


def constant(tau: ArrayLike | None, robot: Robot) -> Array:
    """Constant efforts (n,), zero if None."""
    if tau is None:
        return np.zeros(len(robot.active))
    return finite_vectors("tau", tau, robot.active, -1)


def sample_times(span: Span, rate: float) -> Array:
    """Times at which samples are recorded [s], the end of the span included."""
    start, end = span
    count = int(np.floor((end - start) * rate + 1e-9)) + 1
    if count > MOST_SAMPLES:
        raise InputError(
            f"rate is {rate:g}: {count:.3g} samples in {end - start:g} s; expected at most"
            f" {MOST_SAMPLES:.0e}"
        )
    times = start + np.arange(count) / rate
    if times[-1] >= end - 1e-12 * abs(end):
        return times
    return np.append(times, end)


def periods(span: Span, hold: float) -> Iterator[Span]:
    """Start and end of each period of a digital controller [s]."""
    start, end = span
    count = int(np.ceil((end - start) / hold - 1e-9))
    for k in range(count):
        begin = start + k * hold
        until = min(end, start + (k + 1) * hold)
        yield begin, until
