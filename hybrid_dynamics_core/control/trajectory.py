"""Motions of the active joints over time, through given points."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..ground.arrays import Array, frozen
from ..ground.check_arrays import real_array


class Reference(NamedTuple):
    """Desired motion of the active joints.

    Attributes:
        u: (n,) or (N, n) coordinates [rad or m].
        du: rates of the same shape [rad/s or m/s].
        ddu: accelerations of the same shape [rad/s^2 or m/s^2].
    """

    u: Array
    du: Array
    ddu: Array


class JointTrajectory:
    """A motion through points at ascending times, as in trajectory_msgs/JointTrajectory.

    * Positions alone: a cubic spline whose acceleration is continuous. It starts and ends at rest.
      With `at_rest` false, as for a piece of a longer motion, the first two and the last two pieces
      are one cubic each (not-a-knot), so that samples of a cubic give that cubic.
    * Positions and velocities: a cubic between each two points. The acceleration jumps at points.
    * Accelerations too: a quintic between each two points. The acceleration is continuous.

    The joints rest at the first point before it, and at the last point after it.

    Args:
        times: (N,) ascending [s], N at least 2.
        positions: (N, n) [rad or m].
        velocities: (N, n) [rad/s or m/s], or None.
        accelerations: (N, n) [rad/s^2 or m/s^2], or None.
        at_rest: whether a spline through positions starts and ends at rest.

    Raises:
        InputError: times do not ascend, the rows of an array are not finite or not one for each
            time, or accelerations are given without velocities.
    """

    def __init__(
        self,
        times: ArrayLike,
        positions: ArrayLike,
        velocities: ArrayLike | None = None,
        accelerations: ArrayLike | None = None,
        *,
        at_rest: bool = True,
    ) -> None:
        self.times = frozen(real_array("times", times))
        points = [frozen(real_array("positions", positions))]
        if velocities is not None:
            points.append(frozen(real_array("velocities", velocities)))
        if accelerations is not None:
            points.append(frozen(real_array("accelerations", accelerations)))
        if velocities is None and accelerations is not None:
            raise InputError("accelerations are given without velocities")
        _check_times(self.times)
        _check_points(points, len(self.times))
        self.positions = points[0]
        times = self.times.copy()  # SciPy 1.11 wants arrays that could be written
        if len(points) == 1:
            self._curve = _spline(times, points[0].copy(), at_rest)
        else:
            self._curve = _polynomials(times, np.stack(points, axis=1))

    @classmethod
    def between(
        cls, start: ArrayLike, end: ArrayLike, duration: float, begin: float = 0.0
    ) -> JointTrajectory:
        """A quintic whose rates and accelerations begin and end at zero.

        Args:
            start: (n,) coordinates [rad or m].
            end: (n,) coordinates [rad or m].
            duration: [s].
            begin: time of the start [s].

        Returns:
            The trajectory.
        """
        first = real_array("start", start)
        last = real_array("end", end)
        if first.shape != last.shape:
            raise InputError(f"start has shape {first.shape}, end {last.shape}; expected (n,) each")
        positions = np.stack([first, last])
        zero = np.zeros_like(positions)
        return cls([begin, begin + duration], positions, zero, zero)

    @property
    def duration(self) -> float:
        """Time from the first to the last point [s]."""
        return float(self.times[-1] - self.times[0])

    def __call__(self, t: ArrayLike) -> Reference:
        """The reference at a time [s], (n,) each, or at times (N,), (N, n) each."""
        t = real_array("t", t)
        first, last = self.times[0], self.times[-1]
        within = np.clip(t, first, last)
        moving = ((t >= first) & (t <= last))[..., None]
        u = np.asarray(self._curve(within))
        du = np.where(moving, self._curve(within, 1), 0.0)
        ddu = np.where(moving, self._curve(within, 2), 0.0)
        return Reference(u, du, ddu)


def _check_times(times: Array) -> None:
    """Raise InputError for times that are not two or more ascending numbers."""
    ascending = times.ndim == 1 and (np.diff(times) > 0.0).all()
    if not ascending or len(times) < 2:
        raise InputError("times has to be two or more ascending numbers")


def _check_points(points: list[Array], count: int) -> None:
    """Raise InputError for arrays that do not have a finite row for each of `count` times."""
    names = ("positions", "velocities", "accelerations")
    expected = (count, *points[0].shape[-1:])
    for name, values in zip(names, points, strict=False):
        if values.shape != expected:
            raise InputError(
                f"{name} has shape {values.shape}; expected one row for each of {count} times"
            )
        if not np.isfinite(values).all():
            raise InputError(f"{name} has an entry that is not finite")


def _spline(times: Array, positions: Array, at_rest: bool) -> Any:
    """The cubic spline through positions (N, n), at rest at both ends or not-a-knot there."""
    from scipy.interpolate import CubicSpline  # noqa: PLC0415  slow to import

    ends = "not-a-knot"
    if at_rest:
        ends = "clamped"
    return CubicSpline(times, positions, axis=0, bc_type=ends)


def _polynomials(times: Array, points: Array) -> Any:
    """Polynomials through points (N, k, n) of positions and k - 1 derivatives."""
    from scipy.interpolate import BPoly  # noqa: PLC0415  slow to import

    return BPoly.from_derivatives(times, points)
