"""Measured pressures of hydraulic cylinders: forces of the drives, joined with joint states."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.dynamics.hydraulics import cylinder_force

from .joint_samples import FloatArray, RejectedError, RejectionCode, nanoseconds, wrong_length

PRESSURES: Final = "hybrid_dynamics_msgs/msg/CylinderStates"  # of which names and pressures count
_MOST_LISTS: Final = 16  # lists of names that are remembered


class PressureSample(NamedTuple):
    """Gauge pressures of some cylinders at one stamp.

    Attributes:
        stamp_ns: stamp [ns].
        names: joints that the cylinders move, (k,).
        cap_pressure: in the chambers on the side of the cap (k,) [Pa].
        rod_pressure: in the chambers on the side of the rod (k,) [Pa].
    """

    stamp_ns: int
    names: Sequence[str]
    cap_pressure: FloatArray
    rod_pressure: FloatArray


class MeasuredForces(NamedTuple):
    """Forces of the drives from one message.

    Attributes:
        stamp_ns: its stamp [ns].
        names: its names.
        forces: along each drive (d,) [N]; NaN where the message has no pressures of it.
    """

    stamp_ns: int
    names: tuple[str, ...]
    forces: FloatArray


def sample_of_pressures(message: Any) -> PressureSample:
    """A CylinderStates of rclpy or rosbags as a sample; other fields are not read."""
    return PressureSample(
        stamp_ns=nanoseconds(message.header.stamp.sec, message.header.stamp.nanosec),
        names=tuple(message.name),
        cap_pressure=np.array(message.cap_pressure, dtype=np.float64),
        rod_pressure=np.array(message.rod_pressure, dtype=np.float64),
    )


class PressureInput:
    """Remembers the newest pressures of each cylinder, as forces.

    Attributes:
        newest: the newest message of each list of names.
        max_age: how far stamps may be from that of a joint state [s].
        drives: joints that the forces are along.
    """

    def __init__(self, robot: Robot, max_age: float) -> None:
        """Nothing was measured yet."""
        self.newest: tuple[MeasuredForces, ...] = ()
        self.max_age = max_age
        self.drives = tuple(robot.drives)
        self._cylinders = robot.cylinders

    def take(self, sample: PressureSample) -> None:
        """Take the pressures of a message.

        Raises:
            RejectedError: the stamp is negative, lengths differ, a cylinder is named twice, or none
                of the robot's is named.
        """
        names = tuple(sample.names)
        self._check(sample, names)
        forces = np.full(len(self.drives), np.nan)
        pressures = zip(names, sample.cap_pressure, sample.rod_pressure, strict=True)
        for name, cap, rod in pressures:
            if name in self._cylinders and name in self.drives:
                force = cylinder_force(self._cylinders[name], cap, rod)
                forces[self.drives.index(name)] = force if np.isfinite(force) else np.nan
        others = [other for other in self.newest if other.names != names]
        measured = MeasuredForces(sample.stamp_ns, names, forces)
        self.newest = (*others[-(_MOST_LISTS - 1) :], measured)

    def at(self, stamp_ns: int, newest: tuple[MeasuredForces, ...]) -> FloatArray | None:
        """Forces along the drives (d,) [N] at a stamp [ns]; NaN where none was measured.

        Args:
            stamp_ns: of a joint state [ns].
            newest: what `newest` was when the joint state came.

        Returns:
            None where no force was measured.
        """
        forces = np.full(len(self.drives), np.nan)
        for measured in newest:  # the last one that came counts
            if abs(stamp_ns - measured.stamp_ns) * 1e-9 <= self.max_age:
                forces = np.where(np.isnan(measured.forces), forces, measured.forces)
        return None if np.isnan(forces).all() else forces

    def _check(self, sample: PressureSample, names: tuple[str, ...]) -> None:
        if sample.stamp_ns < 0:
            text = f"stamp is {sample.stamp_ns} ns, expected 0 or more"
            raise RejectedError(RejectionCode.BAD_STAMP, text)
        parts = (("cap_pressure", sample.cap_pressure), ("rod_pressure", sample.rod_pressure))
        for what, values in parts:
            if len(values) != len(names):
                text = wrong_length(what, len(values), len(names))
                raise RejectedError(RejectionCode.WRONG_LENGTH, text)
        ours = [name for name in names if name in self._cylinders]
        if not ours:
            listed = ", ".join(self._cylinders) or "none: the robot file gives no areas"
            text = f"no cylinder is named; cylinders of the robot: {listed}"
            raise RejectedError(RejectionCode.MISSING_JOINT, text)
        if len(set(ours)) < len(ours):
            text = "a cylinder is named twice"
            raise RejectedError(RejectionCode.DUPLICATE_JOINT, text)
