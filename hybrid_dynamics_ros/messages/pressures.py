"""Measured pressures of hydraulic cylinders, as forces of drives."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.description.actuators import HydraulicCylinder
from hybrid_dynamics_core.dynamics.hydraulics import cylinder_force
from hybrid_dynamics_core.dynamics.pressure_check import (
    PEAKS,
    excess_text,
    is_above,
    is_faint,
    pressure_problem,
)

from .joint_samples import FloatArray, RejectedError, RejectionCode, nanoseconds, wrong_length

PRESSURES: Final = "hybrid_dynamics_msgs/msg/CylinderStates"  # only names and pressures are used
_MOST_LISTS: Final = 16  # cached lists of names
_LEAST: Final = 20  # messages that show more than a peak at a stop
_FADE: Final = 0.998  # of the numbers at each message, so that old ones fade


class PressureSample(NamedTuple):
    """Gauge pressures of some cylinders at one stamp.

    Attributes:
        stamp_ns: stamp [ns].
        names: joints of the cylinders (k,).
        cap_pressure: gauge pressures on the cap side (k,) [Pa].
        rod_pressure: gauge pressures on the rod side (k,) [Pa].
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
        forces: forces along each drive (d,) [N]; NaN for drives without pressures in the message.
        exchanged: forces (d,) if cap and rod side of each cylinder were exchanged [N].
    """

    stamp_ns: int
    names: tuple[str, ...]
    forces: FloatArray
    exchanged: FloatArray


def sample_of_pressures(message: Any) -> PressureSample:
    """A CylinderStates of rclpy or rosbags as a sample; only names and pressures are read."""
    return PressureSample(
        stamp_ns=nanoseconds(message.header.stamp.sec, message.header.stamp.nanosec),
        names=tuple(message.name),
        cap_pressure=np.array(message.cap_pressure, dtype=np.float64),
        rod_pressure=np.array(message.rod_pressure, dtype=np.float64),
    )


class SupplyCheck:
    """Finds cylinders whose pressures stay above those of their supply or relief valve."""

    def __init__(self, cylinders: Mapping[str, HydraulicCylinder], fade: float = _FADE) -> None:
        """Start without pressures.

        Args:
            cylinders: the cylinders by joint.
            fade: share that a message leaves of those before it; 1 for all alike.
        """
        self._cylinders = cylinders
        self._fade = fade
        self.clear()

    def clear(self) -> None:
        """Discard all pressures."""
        self._counts = dict.fromkeys(self._cylinders, 0)
        self._shares = dict.fromkeys(self._cylinders, 0.0)
        self._highest = dict.fromkeys(self._cylinders, 0.0)

    def take(self, sample: PressureSample) -> None:
        """Add the pressures of a message."""
        pressures = zip(sample.names, sample.cap_pressure, sample.rod_pressure, strict=True)
        for name, cap, rod in pressures:
            if name not in self._cylinders or not np.isfinite([cap, rod]).all():
                continue
            most = float(max(cap, rod))
            above = float(is_above(self._cylinders[name], most))
            self._counts[name] += 1
            fade = min(self._fade, 1.0 - 1.0 / self._counts[name])  # a mean at first
            self._shares[name] = fade * self._shares[name] + (1.0 - fade) * above
            self._highest[name] = max(above * most, self._fade * self._highest[name])

    @property
    def problem(self) -> str:
        """A text on these cylinders; "" if there are none."""
        texts: list[str] = []
        for name, cylinder in self._cylinders.items():
            if self._counts[name] >= _LEAST and self._shares[name] > PEAKS:
                texts.append(excess_text(cylinder, self._highest[name]))
        return "; ".join(texts)


class PressureInput:
    """Stores the newest pressures of each cylinder, as forces.

    Attributes:
        newest: the newest message of each list of names.
        sample: the newest message with its pressures; None before the first.
        supply: finds pressures above those of the supply.
        max_age: largest difference to the stamp of a joint state [s].
        drives: joints of the forces.
        cylinders: the cylinders by joint.
    """

    def __init__(self, robot: Robot, max_age: float) -> None:
        """Start without measurements."""
        self.newest: tuple[MeasuredForces, ...] = ()
        self.sample: PressureSample | None = None
        self.supply = SupplyCheck(robot.cylinders)
        self.max_age = max_age
        self.drives = tuple(robot.drives)
        self.cylinders = robot.cylinders

    def take(self, sample: PressureSample) -> None:
        """Store the pressures of a message.

        Raises:
            RejectedError: the stamp is negative, lengths differ, a cylinder is named twice, no
                cylinder of the robot is named, or pressures seem to have another unit.
        """
        names = tuple(sample.names)
        self._check(sample, names)
        forces = self._forces(names, sample.cap_pressure, sample.rod_pressure)
        exchanged = self._forces(names, sample.rod_pressure, sample.cap_pressure)
        others = [other for other in self.newest if other.names != names]
        measured = MeasuredForces(sample.stamp_ns, names, forces, exchanged)
        self.newest = (*others[-(_MOST_LISTS - 1) :], measured)
        self.sample = sample
        self.supply.take(sample)

    def at(self, stamp_ns: int, newest: tuple[MeasuredForces, ...]) -> FloatArray | None:
        """Forces along the drives (d,) [N] at a stamp [ns]; NaN where unknown.

        Args:
            stamp_ns: stamp of a joint state [ns].
            newest: value of `newest` when the joint state arrived.

        Returns:
            The forces, or None if no force is known.
        """
        forces = np.full(len(self.drives), np.nan)
        for measured in self._recent(stamp_ns, newest):  # later messages overwrite earlier ones
            forces = np.where(np.isnan(measured.forces), forces, measured.forces)
        return None if np.isnan(forces).all() else forces

    def exchanged_at(self, stamp_ns: int, newest: tuple[MeasuredForces, ...]) -> FloatArray:
        """The forces (d,) [N] of `at`, if cap and rod side of each cylinder were exchanged."""
        forces = np.full(len(self.drives), np.nan)
        for measured in self._recent(stamp_ns, newest):
            forces = np.where(np.isnan(measured.exchanged), forces, measured.exchanged)
        return forces

    def _recent(
        self, stamp_ns: int, newest: tuple[MeasuredForces, ...]
    ) -> Iterator[MeasuredForces]:
        """The messages near enough to a stamp [ns]."""
        for measured in newest:
            if abs(stamp_ns - measured.stamp_ns) * 1e-9 <= self.max_age:
                yield measured

    def _forces(self, names: tuple[str, ...], cap: FloatArray, rod: FloatArray) -> FloatArray:
        """Forces along the drives (d,) [N]; NaN for those without pressures."""
        forces = np.full(len(self.drives), np.nan)
        for name, on_cap, on_rod in zip(names, cap, rod, strict=True):
            if name in self.cylinders and name in self.drives:
                force = cylinder_force(self.cylinders[name], on_cap, on_rod)
                forces[self.drives.index(name)] = force if np.isfinite(force) else np.nan
        return forces

    def _check(self, sample: PressureSample, names: tuple[str, ...]) -> None:
        if sample.stamp_ns < 0:
            text = f"stamp is {sample.stamp_ns} ns, expected 0 or more"
            raise RejectedError(RejectionCode.BAD_STAMP, text)
        parts = (("cap_pressure", sample.cap_pressure), ("rod_pressure", sample.rod_pressure))
        for what, values in parts:
            if len(values) != len(names):
                text = wrong_length(what, len(values), len(names))
                raise RejectedError(RejectionCode.WRONG_LENGTH, text)
        ours = [name for name in names if name in self.cylinders]
        if not ours:
            listed = ", ".join(self.cylinders) or "none: the robot file gives no areas"
            text = f"no cylinder is named; cylinders of the robot: {listed}"
            raise RejectedError(RejectionCode.MISSING_JOINT, text)
        if len(set(ours)) < len(ours):
            text = "a cylinder is named twice"
            raise RejectedError(RejectionCode.DUPLICATE_JOINT, text)
        self._check_units(sample)

    def _check_units(self, sample: PressureSample) -> None:
        """Refuse pressures that a cylinder cannot have, and numbers that are rather in bar."""
        highest: list[float] = []
        pressures = zip(sample.names, sample.cap_pressure, sample.rod_pressure, strict=True)
        for name, cap, rod in pressures:
            if name not in self.cylinders or not np.isfinite([cap, rod]).all():
                continue
            problem = pressure_problem(self.cylinders[name], min(cap, rod), max(cap, rod))
            if problem:
                raise RejectedError(RejectionCode.BAD_PRESSURE, f"{name} has {problem}")
            highest.append(max(cap, rod))
        if highest and is_faint(*highest):
            text = f"no pressure is above {max(highest):.4g} Pa; are they in bar? expected Pa"
            raise RejectedError(RejectionCode.BAD_PRESSURE, text)
