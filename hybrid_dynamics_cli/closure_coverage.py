"""How much of the range that a file allows its loops close over: tried, and counted."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hybrid_dynamics_core import ClosureStatus, Robot
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.ground.wording import counted

HARDLY = 0.05  # share of the places
TRIED = 500  # places: one in a hundred that does not close is found in 993 of 1000 cases


@dataclass(frozen=True)
class Tried:
    """How many places were tried, and at how many of them the loops close."""

    places: int
    closed: int

    @property
    def everywhere(self) -> bool:
        """Whether they close wherever they were tried."""
        return self.closed == self.places

    @property
    def hardly(self) -> bool:
        """Whether they close so seldom that limits or lengths are hardly meant so."""
        return self.closed < HARDLY * self.places

    def told(self) -> str:
        """The sentence for people."""
        within = f"{counted(self.places, 'place')} tried within the limits of the active joints"
        return (
            f"loops close at all {within}"
            if self.everywhere
            else f"loops close at {self.closed} of {within}"
        )


def try_loops(machine: Robot) -> Tried:
    """Close the loops at places spread evenly over the file's limits, always the same ones.

    An angle without limits is tried all around, a slide without limits only where the reference has
    it.
    """
    if not machine.loops:
        return Tried(0, 0)
    box = np.array([_range(machine, k) for k in range(len(machine.active))])
    places = np.random.default_rng(0).uniform(box[:, 0], box[:, 1], (TRIED, len(box)))
    status = np.asarray(machine.close(places, check=False).status)
    return Tried(TRIED, int((status != ClosureStatus.UNREACHABLE).sum()))


def _range(machine: Robot, k: int) -> Array:
    """The limits that the file gives to an active joint."""
    name, near = machine.active[k], float(machine.reference[k])
    reach = math.pi if machine.joint_types[name] == "revolute" else 0.0
    lower, upper = machine.description.joints[name].limits
    return np.array(
        [
            lower if math.isfinite(lower) else near - reach,
            upper if math.isfinite(upper) else near + reach,
        ]
    )
