"""Curves that are zero, or constant, but for rounding: their axes do not show it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.axes import Axes

from ...ground.arrays import Array
from ...robot.robot import Robot
from ...scene.attach import mechanism_size
from ...scene.skeleton import place_skeleton

ROUNDING: Final = 1e-9  # of the natural size of a quantity: what differs less does not differ
_ROOM: Final = (
    0.05  # of a constant, on both sides of it: as Matplotlib has it, which knows no sizes
)
# [s] a natural rate goes through the natural size in this time, or in that of a longer motion
_SLOW: Final = 1.0


@dataclass(frozen=True)
class Sizes:
    """How large the quantities of a motion are by nature: `length` [m], `time` [s], `weight` [N] of the robot's links.

    A turn is of the size of one radian, a torque of the weight at the robot's length, an energy of
    the weight raised by that; a robot without weight has efforts as large as its largest one, and
    no other size for them.
    """

    length: float
    time: float
    weight: float

    def position(self, joint_type: str) -> float:
        """[rad or m]."""
        return 1.0 if joint_type == "revolute" else self.length

    def rate(self, joint_type: str) -> float:
        """[rad/s or m/s]."""
        return self.position(joint_type) / self.time

    def effort(self, joint_type: str) -> float:
        """[N m or N]."""
        return self.weight * (self.length if joint_type == "revolute" else 1.0)

    @property
    def energy(self) -> float:
        """[J]."""
        return self.weight * self.length


def sizes_of(robot: Robot, seconds: float) -> Sizes:
    """The natural sizes in a motion of a robot that lasts some seconds."""
    length = mechanism_size(place_skeleton(robot, robot.close(robot.reference)))
    mass = sum(link.mass for link in robot.description.links.values())
    gravity = float(np.linalg.norm(robot.description.gravity))
    return Sizes(length, max(seconds, _SLOW), mass * gravity)


def least(natural: float, values: Array) -> float:
    """What is rounding among values (N, ...) of a natural size; all of them zero: 0.

    NaN are passed over.
    """
    return ROUNDING * max(natural, float(np.nanmax(np.abs(values), initial=0.0)))


def suppress_rounding(axes: Axes, natural: float) -> bool:
    """Limits wide enough that rounding is a straight line, on axes whose curves are constant but for it.

    natural: size of what is drawn. Returns whether that is so; other axes stay as they are.
    """
    ends = np.asarray(axes.dataLim.intervaly, dtype=np.float64)
    if not np.isfinite(ends).all():
        return False
    small, middle = least(natural, ends), float(ends.mean())
    if float(np.ptp(ends)) > small:
        return False
    middle = 0.0 if abs(middle) <= small else middle
    half = max(_ROOM * (abs(middle) or 1.0), small)
    axes.set_ylim(middle - half, middle + half)
    return True
