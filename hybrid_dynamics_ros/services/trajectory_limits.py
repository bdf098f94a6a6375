"""Bounds of a motion: limits, singularities, rates, efforts, pressures, power.

This module does not depend on ROS.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from hybrid_dynamics_core import ClosedState, Robot
from hybrid_dynamics_core.description.actuators import HydraulicCylinder
from hybrid_dynamics_core.dynamics.hydraulics import chamber_pressures
from hybrid_dynamics_core.ground.units import coordinate_unit, effort_unit

from ..messages.joint_samples import FloatArray, Rejection, RejectionCode
from ..stream.stroke_margins import StrokeMargins

_ROUNDING: Final = 1e-9  # [rad or m], or share of a limit, by which it may be exceeded


class _Bound(NamedTuple):
    """One quantity that must stay within a range.

    `words` are the beginning of a sentence that ends with the value. `expected` is a text on the
    range.
    """

    words: str
    unit: str
    lower: float
    upper: float
    expected: str


class MotionLimits:
    """Margins of a state to all bounds of the motion; each is zero at its bound."""

    def __init__(self, robot: Robot, least: float) -> None:
        """Collect the bounds of a robot.

        Args:
            robot: the robot.
            least: least allowed distance to a singularity, 0 singular, 1 best.
        """
        self._robot, self._least = robot, least
        self._bounds: list[_Bound] = []
        self._limited = self._bound_coordinates()
        self._fast = self._bound_rates()
        self._efforts = self._bound_efforts()
        self._cylinders = self._bound_pressures()
        self._powers = self._bound_powers()
        lowest = [bound.lower for bound in self._bounds]
        highest = [bound.upper for bound in self._bounds]
        self._lower = np.array([*lowest, least])
        self._upper = np.array([*highest, np.inf])

    @property
    def has_powers(self) -> bool:
        """Whether the power of a drive is limited."""
        return bool(self._powers)

    def margins(self, state: ClosedState, efforts: FloatArray) -> FloatArray:
        """Margin to each bound (k,), negative beyond it, in the order of `problem`.

        Args:
            state: closed state.
            efforts: efforts of the active joints (n,) [N m or N].

        Raises:
            SingularityError: the drives cannot give these efforts.
        """
        values = self._values(state, efforts)
        return np.asarray(np.minimum(values - self._lower, self._upper - values))

    def problem(self, state: ClosedState, efforts: FloatArray) -> Rejection | None:
        """The rejection for the first exceeded bound, or None."""
        values = self._values(state, efforts)
        beyond = np.flatnonzero((values < self._lower) | (values > self._upper))
        if not beyond.size:
            return None
        first = int(beyond[0])
        if first == len(self._bounds):
            return self._singular(state)
        bound = self._bounds[first]
        text = f"{bound.words} {values[first]:.6g} {bound.unit}, expected {bound.expected}"
        return Rejection(RejectionCode.LIMIT, text)

    def excess(self, number: int, margin: float) -> str:
        """The excess of a negative margin over its bound, with its unit.

        Args:
            number: number of the bound, its place in `margins`.
            margin: negative.
        """
        unit = ""
        if number < len(self._bounds):
            unit = f" {self._bounds[number].unit}"
        return f"{-margin:.6g}{unit}"

    def _values(self, state: ClosedState, efforts: FloatArray) -> FloatArray:
        """The bounded quantities (k,)."""
        forces, pressures, powers = self._drive_values(state, efforts)
        return np.concatenate(
            [
                state.s[self._limited],
                state.ds[self._fast],
                forces,
                pressures,
                powers,
                [float(state.singularity)],
            ]
        )

    def _bound_coordinates(self) -> list[int]:
        """Add bounds of coordinates with limits; returns their indices."""
        strokes, limited = StrokeMargins(self._robot), []
        for name, unit in zip(strokes.joints, strokes.units, strict=True):
            place = self._robot.coordinates.index(name)
            low, high = float(strokes.lower[place]), float(strokes.upper[place])
            expected = f"{low:.6g} to {high:.6g} {unit}"
            bound = _Bound(f"{name} is", unit, low - _ROUNDING, high + _ROUNDING, expected)
            self._bounds.append(bound)
            limited.append(place)
        return limited

    def _bound_rates(self) -> list[int]:
        """Add bounds of rates; returns the indices of their coordinates."""
        robot = self._robot
        fast = []
        for place, name in enumerate(robot.coordinates):
            most = robot.description.joints[name].velocity_limit
            unit = f"{coordinate_unit(robot.joint_types[name])}/s"
            if self._bound_size(f"{name} moves at", unit, most):
                fast.append(place)
        return fast

    def _bound_efforts(self) -> list[str]:
        """Add bounds of efforts; returns the names of their drives."""
        robot = self._robot
        limited = []
        for name in robot.drives:
            most = robot.description.joints[name].effort_limit
            if self._bound_size(f"{name} needs", effort_unit(robot.joint_types[name]), most):
                limited.append(name)
        return limited

    def _bound_pressures(self) -> dict[str, HydraulicCylinder]:
        """Add bounds of pressures; returns cylinders with a supply pressure, by joint."""
        cylinders = {}
        for name in self._robot.drives:
            cylinder = self._robot.cylinders.get(name)
            if cylinder is None:
                continue
            words, supply = f"the cylinder of {name} needs", cylinder.supply_pressure
            if self._bound_size(words, "Pa", supply, "its supply, "):
                cylinders[name] = cylinder
        return cylinders

    def _bound_powers(self) -> dict[str, int]:
        """Add bounds of power; returns the indices of their drives."""
        robot = self._robot
        places = {}
        for name in robot.drives:
            most = robot.description.joints[name].power_limit
            if self._bound_size(f"the drive of {name} has a power of", "W", most):
                places[name] = robot.coordinates.index(name)
        return places

    def _bound_size(self, words: str, unit: str, most: float, what: str = "") -> bool:
        """Add a bound of an absolute value; returns False if it is infinite."""
        if not np.isfinite(most):
            return False
        upper = (1.0 + _ROUNDING) * most
        expected = f"no more than {what}{most:.6g} {unit}"
        self._bounds.append(_Bound(words, unit, -upper, upper, expected))
        return True

    def _singular(self, state: ClosedState) -> Rejection:
        place = f"at a distance of {state.singularity:.3g} (of at most 1) from a singularity"
        text = f"loop {state.singular_loop} is {place}, expected {self._least:g} or more"
        return Rejection(RejectionCode.SINGULAR, text)

    def _drive_values(
        self, state: ClosedState, efforts: FloatArray
    ) -> tuple[list[float], list[float], list[float]]:
        """Bounded quantities of drives: forces, highest pressure of each cylinder [Pa], power [W].

        A drive gives power where its force and its rate have the same sign, else it takes power.
        """
        if not self._efforts and not self._cylinders and not self._powers:
            return [], [], []
        forces = self._robot.drive_forces(state, efforts)
        limited = [float(forces[name]) for name in self._efforts]
        highest = []
        for name, cylinder in self._cylinders.items():
            cap, rod = chamber_pressures(cylinder, forces[name])
            highest.append(max(float(cap), float(rod)))
        powers = [float(forces[name] * state.ds[place]) for name, place in self._powers.items()]
        return limited, highest, powers
