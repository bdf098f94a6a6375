"""The share of the joint ranges in which the loops close, by random sampling."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hybrid_dynamics_core import ClosureStatus, Robot
from hybrid_dynamics_core.ground.wording import counted

RARE_SHARE = 0.05  # of the samples
PLACES = 500  # a share of 1 % that does not close is found with probability 0.993


@dataclass(frozen=True)
class ClosureCoverage:
    """Counts of random configurations within the limits whose loops close.

    Attributes:
        places: number of samples; 0 for a robot without loops.
        closed: number of samples at which all loops close.
        singular: number of other samples, at which the loops close but are singular.
    """

    places: int
    closed: int
    singular: int

    @property
    def is_complete(self) -> bool:
        """Whether the loops close at every sample."""
        return self.closed == self.places

    @property
    def is_rare(self) -> bool:
        """Whether the loops close so rarely that limits or lengths are probably wrong."""
        return self.closed < RARE_SHARE * self.places

    def describe(self) -> str:
        """The coverage as a sentence."""
        places = f"{counted(self.places, 'place')} tried within the limits of the active joints"
        if self.is_complete:
            return f"loops close at all {places}"
        sentence = f"loops close at {self.closed} of {places}, as the file gives them"
        if self.singular:
            return f"{sentence}; {self.singular} more are singular"
        return sentence


def closure_coverage(machine: Robot) -> ClosureCoverage:
    """Close the loops at random configurations within the limits of the file, always the same ones.

    An angle without limits is sampled over a whole turn. A slide without limits stays at its
    reference.
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
    """The limits [rad or m] of an active joint in the file."""
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
