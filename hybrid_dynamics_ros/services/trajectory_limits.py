"""Bounds of a motion: limits, singularities, drives, cylinders and pumps.

This module does not depend on ROS.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from hybrid_dynamics_core import ClosedState, Robot
from hybrid_dynamics_core.limits import Limits
from hybrid_dynamics_core.limits.rows import Row

from ..messages.joint_samples import FloatArray, Rejection, RejectionCode

_ROUNDING: Final = 1e-9  # [rad or m], or share of a limit, by which it may be exceeded
# kinds of quantities that may pass a limit and come back between samples
_QUICK: Final = ("power", "flow", "pump_flow", "pump_power")


class MotionLimits:
    """Margins of a state to all bounds of the motion; each is zero at its bound."""

    def __init__(self, robot: Robot, least: float) -> None:
        """Collect the bounds of a robot.

        Args:
            robot: the robot.
            least: least allowed distance to a singularity, 0 singular, 1 best.
        """
        self._least = least
        self._limits = Limits(robot)

    @property
    def has_powers(self) -> bool:
        """Whether the power of a drive, or what a pump gives, is limited."""
        return any(row.kind in _QUICK for row in self._limits.rows)

    def margins(
        self, state: ClosedState, efforts: FloatArray, acceleration: FloatArray | None = None
    ) -> FloatArray:
        """Margin to each bound (k,), negative beyond it, in the order of `problem`.

        Args:
            state: closed state.
            efforts: efforts of the active joints (n,) [N m or N].
            acceleration: their accelerations (n,) [rad/s^2 or m/s^2]; zero if None.

        Raises:
            SingularityError: the drives cannot give these efforts.
        """
        values = self._limits.values(state, efforts, acceleration)
        lower, upper = self._bounds(state)
        margins = np.minimum(values - lower, upper - values)
        return np.append(margins, float(state.singularity) - self._least)

    def problem(
        self, state: ClosedState, efforts: FloatArray, acceleration: FloatArray | None = None
    ) -> Rejection | None:
        """The rejection for the first exceeded bound, or None."""
        beyond = np.flatnonzero(self.margins(state, efforts, acceleration) < 0.0)
        if not beyond.size:
            return None
        first = int(beyond[0])
        if first == len(self._limits.rows):
            return self._singular(state)
        row = self._limits.rows[first]
        value = self._limits.values(state, efforts, acceleration)[first]
        most = self._limits.bounds(state)[1][first]
        text = f"{row.words} {value:.6g} {row.unit}, expected {_expected(row, float(most))}"
        return Rejection(RejectionCode.LIMIT, text)

    def excess(self, number: int, margin: float) -> str:
        """The excess of a negative margin over its bound, with its unit.

        Args:
            number: number of the bound, its place in `margins`.
            margin: negative.
        """
        unit = ""
        if number < len(self._limits.rows):
            unit = f" {self._limits.rows[number].unit}"
        return f"{-margin:.6g}{unit}"

    def _bounds(self, state: ClosedState) -> tuple[FloatArray, FloatArray]:
        """Lower and upper bounds (k,), widened by rounding."""
        lower, upper = self._limits.bounds(state)
        for k, row in enumerate(self._limits.rows):
            slack = _ROUNDING
            if row.kind != "position":
                slack *= upper[k]
            lower[k] -= slack
            upper[k] += slack
        return lower, upper

    def _singular(self, state: ClosedState) -> Rejection:
        place = f"at a distance of {state.singularity:.3g} (of at most 1) from a singularity"
        text = f"loop {state.singular_loop} is {place}, expected {self._least:g} or more"
        return Rejection(RejectionCode.SINGULAR, text)


def _expected(row: Row, most: float) -> str:
    """The range of a quantity as text."""
    if row.kind == "position":
        return f"{row.lower:.6g} to {row.upper:.6g} {row.unit}"
    what = ""
    if row.kind == "pressure":
        what = f"{row.bound}, "
    return f"no more than {what}{most:.6g} {row.unit}"
