"""Margins of states to all limits, by name."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..dynamics.loads import Loads
from ..ground.arrays import Array
from .limits import Limits
from .robot_interfaces import LimitedRobot
from .rows import Row

ROUNDING = 1e-9  # [rad or m], or share of a limit, by which it may be exceeded


@dataclass(frozen=True)
class Margin:
    """The margin of one quantity to its nearer bound.

    Attributes:
        kind: position, rate, acceleration, effort, pressure, flow, power, pump_flow or pump_power.
        name: joint, drive or pump.
        value: the quantity, in `unit`.
        limit: the nearer bound, in `unit`.
        margin: what is left to it, in `unit`; negative beyond it.
        unit: SI unit.
        index: the state in the batch; 0 for one state.
        text: a sentence on it.
    """

    kind: str
    name: str
    value: float
    limit: float
    margin: float
    unit: str
    index: int
    text: str


@dataclass(frozen=True, eq=False)
class LimitMargins:
    """Values, bounds and margins of all limited quantities.

    Attributes:
        rows: the k quantities.
        values: (k,) or (N, k).
        lower: least values of the same shape.
        upper: greatest values of the same shape.
    """

    rows: tuple[Row, ...]
    values: Array
    lower: Array
    upper: Array

    @property
    def margins(self) -> Array:
        """Margins (k,) or (N, k) to the nearer bound, negative beyond it."""
        return np.asarray(
            np.minimum(
                self.values - self.lower,
                self.upper - self.values,
            )
        )

    @property
    def shares(self) -> Array:
        """Margins over half the range between the bounds, or over the size of a single bound."""
        is_upper = self.upper - self.values <= self.values - self.lower
        nearer = np.where(is_upper, self.upper, self.lower)
        half = 0.5 * (self.upper - self.lower)
        sizes = np.where(np.isfinite(half), half, np.abs(nearer))
        return np.asarray(self.margins / np.maximum(sizes, ROUNDING))

    @property
    def beyond(self) -> tuple[Margin, ...]:
        """Each quantity that is beyond its bound, where it is furthest; the worst first."""
        ranked = sorted(self._smallest(), key=_share)
        return tuple(margin for _, margin in ranked if self._is_beyond(margin))

    @property
    def nearest(self) -> Margin | None:
        """The quantity with the least of `shares` left; None without limits."""
        ranked = sorted(self._smallest(), key=_share)
        if not ranked:
            return None
        _, margin = ranked[0]
        return margin

    def _is_beyond(self, margin: Margin) -> bool:
        slack = ROUNDING
        if margin.kind != "position":
            slack *= abs(margin.limit)
        return margin.margin < -slack

    def _smallest(self) -> list[tuple[float, Margin]]:
        """The smallest margin of each quantity over the batch, after its share."""
        margins, shares = np.atleast_2d(self.margins), np.atleast_2d(self.shares)
        values, lower, upper = map(
            np.atleast_2d,
            (self.values, self.lower, self.upper),
        )
        result: list[tuple[float, Margin]] = []
        for k, row in enumerate(self.rows):
            if not np.isfinite(margins[:, k]).any():
                continue
            index = int(np.nanargmin(margins[:, k]))
            low, high = float(lower[index, k]), float(upper[index, k])
            value = float(values[index, k])
            margin = _margin(row, value, (low, high), index)
            result.append((float(shares[index, k]), margin))
        return result


def limit_margins(
    robot: LimitedRobot,
    state: ClosedState,
    ddu: ArrayLike | None = None,
    tau: ArrayLike | None = None,
    loads: Loads | None = None,
) -> LimitMargins:
    """Margins of a state, or of a motion, to all limits of joints, drives, cylinders and pumps.

    Args:
        robot: the robot.
        state: closed state, or a batch of N.
        ddu: active accelerations (n,) or (N, n) [rad/s^2, m/s^2]; zero if None.
        tau: active efforts (n,) or (N, n) [N m, N]; those of inverse dynamics if None.
        loads: loads besides the actuators; those of the description if None.

    Returns:
        The margins; `beyond` names what is beyond.

    Raises:
        SingularityError: the drives cannot give these efforts.
        InputError: a shape is wrong, or a value is not finite.
    """
    limits = Limits(robot)
    if ddu is None:
        ddu = np.zeros_like(state.u)
    if tau is None:
        tau = robot.inverse_dynamics(state, ddu, loads)
    return margins_of(limits, state, tau, ddu)


def margins_of(
    limits: Limits,
    state: ClosedState,
    tau: ArrayLike,
    ddu: ArrayLike | None = None,
) -> LimitMargins:
    """`limit_margins` with limits that are collected already."""
    values = limits.values(state, tau, ddu)
    return LimitMargins(
        tuple(limits.rows),
        values,
        *limits.bounds(state),
    )


def _share(ranked: tuple[float, Margin]) -> float:
    share, _ = ranked
    return share


def _margin(
    row: Row,
    value: float,
    bounds: tuple[float, float],
    index: int,
) -> Margin:
    """The margin of a value to the nearer one of two bounds."""
    lower, upper = bounds
    limit, margin = upper, upper - value
    if value - lower < margin:
        limit, margin = lower, value - lower
    what = "left to"
    if margin < 0.0:
        what = "beyond"
    amounts = f"{value:.6g} {row.unit}, {abs(margin):.4g} {row.unit} {what} {row.bound}"
    text = f"{row.words} {amounts} of {limit:.6g} {row.unit}"
    return Margin(
        row.kind,
        row.name,
        value,
        limit,
        margin,
        row.unit,
        index,
        text,
    )
