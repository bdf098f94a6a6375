"""Axis limits that do not magnify rounding of zero or constant curves."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.axes import Axes

from ...ground.arrays import Array
from ...robot.robot import Robot
from ...scene.attach import mechanism_size
from ...scene.skeleton import place_skeleton

ROUNDING: Final = 1e-9  # share of a quantity's natural size; smaller differences are rounding
# Margin on both sides of a constant, as a share of it; Matplotlib's default.
_ROOM: Final = 0.05
# [s] natural rate = natural size over this time, or over a longer motion's duration
_SLOW: Final = 1.0


@dataclass(frozen=True)
class Sizes:
    """Natural sizes of the quantities of a motion.

    They are one radian for angles, weight times length for torques and energies. Without weight,
    the size of efforts is their largest value.

    Attributes:
        length: length of the robot [m].
        time: time of the motion [s].
        weight: weight of the robot's links [N].
    """

    length: float
    time: float
    weight: float

    def position(self, joint_type: str) -> float:
        """Natural size of a coordinate [rad or m]."""
        return 1.0 if joint_type == "revolute" else self.length

    def rate(self, joint_type: str) -> float:
        """Natural size of a rate [rad/s or m/s]."""
        return self.position(joint_type) / self.time

    def effort(self, joint_type: str) -> float:
        """Natural size of an effort [N m or N]."""
        arm = self.length if joint_type == "revolute" else 1.0
        return self.weight * arm

    @property
    def energy(self) -> float:
        """Natural size of an energy [J]."""
        return self.weight * self.length


def sizes_of(robot: Robot, seconds: float) -> Sizes:
    """The natural sizes in a motion of a robot that lasts some seconds."""
    skeleton = place_skeleton(robot, robot.close(robot.reference))
    mass = sum(link.mass for link in robot.description.links.values())
    gravity = float(np.linalg.norm(robot.description.gravity))
    return Sizes(mechanism_size(skeleton), max(seconds, _SLOW), mass * gravity)


def rounding_of(natural: float, values: Array) -> float:
    """The largest difference that is rounding; 0 if all values are zero.

    Args:
        natural: size of the values.
        values: (N, ...); NaN are ignored.

    Returns:
        The largest difference that is rounding.
    """
    largest = np.nanmax(np.abs(values), initial=0.0)
    return ROUNDING * max(natural, float(largest))


def suppress_rounding(axes: Axes, natural: float) -> bool:
    """Widen the limits of axes whose curves are constant up to rounding.

    Such curves then are straight lines. Other axes are not changed.

    Args:
        axes: axes with their curves.
        natural: natural size of the curves.

    Returns:
        Whether the curves are constant up to rounding.
    """
    ends = np.asarray(axes.dataLim.intervaly, dtype=np.float64)
    if not np.isfinite(ends).all():
        return False
    rounding = rounding_of(natural, ends)
    if float(np.ptp(ends)) > rounding:
        return False
    middle = float(ends.mean())
    if abs(middle) <= rounding:
        middle = 0.0
    half = max(_ROOM * (abs(middle) or 1.0), rounding)
    axes.set_ylim(middle - half, middle + half)
    return True
