"""What a robot must not pass on its way: limits, singular places, rates, efforts, pressures.

Knows no ROS.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from hybrid_dynamics_core import ClosedState, Robot
from hybrid_dynamics_core.dynamics.hydraulics import chamber_pressures
from hybrid_dynamics_core.ground.units import coordinate_unit, effort_unit

from ..messages.joint_samples import FloatArray, Rejection, RejectionCode
from ..stream.stroke_margins import StrokeMargins

_ROUNDING: Final = 1e-9  # [rad or m], or share of a limit, that it may be passed by


class MotionLimits:
    """Margins of a state to all that bounds the motion; each is zero at its bound."""

    def __init__(self, robot: Robot, least: float) -> None:
        """Bounds of a robot.

        Args:
            robot: the robot.
            least: nearest distance to a singularity, 0 singular, 1 best.
        """
        self._robot, self._least = robot, least
        self._strokes = StrokeMargins(robot)
        joints = robot.description.joints
        rates = np.array([joints[name].velocity_limit for name in robot.coordinates])
        self._fast = np.flatnonzero(np.isfinite(rates))
        self._rates = rates[self._fast]
        efforts = {name: joints[name].effort_limit for name in robot.drives}
        self._efforts = {name: limit for name, limit in efforts.items() if np.isfinite(limit)}
        cylinders = {
            name: robot.cylinders[name] for name in robot.drives if name in robot.cylinders
        }
        self._cylinders = {
            name: cylinder
            for name, cylinder in cylinders.items()
            if np.isfinite(cylinder.supply_pressure)
        }

    def margins(self, state: ClosedState, efforts: FloatArray) -> FloatArray:
        """To each bound (k,), negative beyond it; in the order of `problem`.

        Args:
            state: closed state.
            efforts: of the active joints (n,) [N m or N].

        Raises:
            SingularityError: the drives cannot give these efforts.
        """
        lower, upper = self._strokes.margins(state.s)
        ends = np.concatenate([lower, upper])
        ends = ends[np.isfinite(ends)] + _ROUNDING
        rates = (1.0 + _ROUNDING) * self._rates - np.abs(state.ds[self._fast])
        forces, pressures = self._drive_values(state, efforts)
        most = (1.0 + _ROUNDING) * np.array(list(self._efforts.values()))
        supplies = np.array([entry.supply_pressure for entry in self._cylinders.values()])
        highest = (1.0 + _ROUNDING) * supplies
        distance = [float(state.singularity) - self._least]
        return np.concatenate([ends, rates, most - np.abs(forces), highest - pressures, distance])

    def problem(self, state: ClosedState, efforts: FloatArray) -> Rejection | None:
        """The first bound that is passed, in words, or None."""
        texts = self._passed_limits(state)
        forces, pressures = self._drive_values(state, efforts)
        for (name, most), force in zip(self._efforts.items(), forces.tolist(), strict=True):
            if abs(force) > (1.0 + _ROUNDING) * most:
                unit = effort_unit(self._robot.joint_types[name])
                texts.append(
                    f"{name} needs {force:.6g} {unit}, expected no more than {most:.6g} {unit}"
                )
        for name, pressure in zip(self._cylinders, pressures.tolist(), strict=True):
            supply = self._cylinders[name].supply_pressure
            if pressure > (1.0 + _ROUNDING) * supply:
                expected = f"expected no more than its supply, {supply:.6g} Pa"
                texts.append(f"the cylinder of {name} needs {pressure:.6g} Pa, {expected}")
        if texts:
            return Rejection(RejectionCode.LIMIT, texts[0])
        return self._singular(state)

    def _passed_limits(self, state: ClosedState) -> list[str]:
        robot, strokes, texts = self._robot, self._strokes, []
        bounds = zip(
            robot.coordinates,
            strokes.lower.tolist(),
            state.s.tolist(),
            strokes.upper.tolist(),
            strict=True,
        )
        for name, low, value, high in bounds:
            if not low - _ROUNDING <= value <= high + _ROUNDING:
                unit = coordinate_unit(robot.joint_types[name])
                expected = f"expected {low:.6g} to {high:.6g} {unit}"
                texts.append(f"{name} is {value:.6g} {unit}, {expected}")
        for k, most in zip(self._fast.tolist(), self._rates.tolist(), strict=True):
            rate, name = float(state.ds[k]), robot.coordinates[k]
            if abs(rate) > (1.0 + _ROUNDING) * most:
                unit = f"{coordinate_unit(robot.joint_types[name])}/s"
                expected = f"expected no more than {most:.6g} {unit}"
                texts.append(f"{name} moves at {rate:.6g} {unit}, {expected}")
        return texts

    def _singular(self, state: ClosedState) -> Rejection | None:
        if float(state.singularity) >= self._least:
            return None
        place = f"at a distance of {state.singularity:.3g} (of at most 1) from a singularity"
        text = f"loop {state.singular_loop} is {place}, expected {self._least:g} or more"
        return Rejection(RejectionCode.SINGULAR, text)

    def _drive_values(
        self, state: ClosedState, efforts: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Forces of the drives with limits, and the highest pressure of each cylinder [Pa]."""
        if not self._efforts and not self._cylinders:
            return np.zeros(0), np.zeros(0)
        forces = self._robot.drive_forces(state, efforts)
        limited = np.array([float(forces[name]) for name in self._efforts])
        highest = []
        for name, cylinder in self._cylinders.items():
            cap, rod = chamber_pressures(cylinder, forces[name])
            highest.append(max(float(cap), float(rod)))
        return limited, np.array(highest)
