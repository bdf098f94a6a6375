"""Efforts that drives give within their limits."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..ground.arrays import Array
from .limits import Limits


def saturated(limits: Limits, state: ClosedState, tau: ArrayLike) -> Array:
    """The part of tau that the drives give at a state.

    Each drive gives what is asked of it up to its bounds. Near the largest flow the pressure of a
    filling chamber falls. Beyond it the other chamber brakes.

    Args:
        limits: the limits of the robot.
        state: closed state, or a batch of N.
        tau: efforts (n,) or (N, n) that are asked for [N m, N].

    Returns:
        Efforts of the same shape. Entries along idle coordinates stay.
    """
    asked = np.asarray(tau, dtype=float)
    wanted = limits.forces(state, asked)
    given = limits.clip(state, wanted)
    lost = np.einsum("...mi,...m->...i", limits.drive_rates(state), given - wanted)
    return np.asarray(asked + lost)
