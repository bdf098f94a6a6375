"""Over how much of the range that a file allows its loops close: sampled, and counted."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hybrid_dynamics_core import ClosureStatus, Robot
from hybrid_dynamics_core.ground.wording import counted

RARE_SHARE = 0.05  # of the places
PLACES = 500  # one in a hundred that does not close is met in 993 of 1000 cases


@dataclass(frozen=True)
class ClosureCoverage:
    """At how many places within the limits the loops close.

    Attributes:
        places: how many were sampled; none for a robot without loops.
        closed: at how many of them all loops close.
        singular: at how many more they close, but are singular.
    """

    places: int
    closed: int
    singular: int

    @property
    def is_complete(self) -> bool:
        """Whether the loops close at every place."""
        return self.closed == self.places

    @property
    def is_rare(self) -> bool:
        """Whether they close so seldom that limits or lengths are hardly meant so."""
        return self.closed < RARE_SHARE * self.places

    def describe(self) -> str:
        """The sentence for people."""
        places = f"{counted(self.places, 'place')} tried within the limits of the active joints"
        if self.is_complete:
            return f"loops close at all {places}"
        sentence = f"loops close at {self.closed} of {places}, as the file gives them"
        if self.singular:
            return f"{sentence}; {self.singular} more are singular"
        return sentence


def closure_coverage(machine: Robot) -> ClosureCoverage:
    """Close the loops at random places within the file's limits, the same ones at every call.

    An angle without limits is sampled all around. A slide without limits stays at its reference.
    """
    if not machine.loops:
        return ClosureCoverage(0, 0, 0)
    ranges = np.array([_range(machine, k) for k in range(len(machine.active))])
    shape = (PLACES, len(ranges))
    places = np.random.default_rng(0).uniform(ranges[:, 0], ranges[:, 1], shape)
    status = np.asarray(machine.close(places, check=False).status)
    closed = int((status == ClosureStatus.OK).sum())
    singular = int((status == ClosureStatus.SINGULAR).sum())
    return ClosureCoverage(PLACES, closed, singular)


def _range(machine: Robot, k: int) -> tuple[float, float]:
    """The limits [rad or m] that the file gives to an active joint."""
    name = machine.active[k]
    reference = float(machine.reference[k])
    reach = 0.0
    if machine.joint_types[name] == "revolute":
        reach = math.pi
    lower, upper = machine.description.joints[name].limits
    if not math.isfinite(lower):
        lower = reference - reach
    if not math.isfinite(upper):
        upper = reference + reach
    return lower, upper
