"""Paths of the active joints: smooth curves through points, without times."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arrays import real_array

SAMPLES = 8  # of a trajectory between two of its times
SAME = 1e-12  # share of the path's extent within which two points are one


class Trajectory(Protocol):
    """A motion through points at times, such as a JointTrajectory."""

    @property
    def times(self) -> Array:
        """Times of its points [s]."""

    def __call__(self, t: ArrayLike) -> Any:
        """What has `u`, positions (N, n) at times (N,) [rad or m]."""


class Curve:
    """The cubic spline through points, over the sum of chords.

    Each coordinate counts in shares of its extent, so that metres and radians go together.

    Attributes:
        s: (N,) parameters of the points, from 0 up; without a unit.
        points: (N, n) [rad or m].
        boundary: condition of the spline at its ends, in the words of SciPy.
    """

    def __init__(self, points: Array) -> None:
        """The curve through two or more points that are apart."""
        from scipy.interpolate import CubicSpline  # noqa: PLC0415  slow to import

        extent = np.ptp(points, axis=0)
        moving = extent > 0.0
        if not moving.any():
            raise InputError("the path has one point only; expected two or more that are apart")
        steps = (
            np.diff(
                points[:, moving],
                axis=0,
            )
            / extent[moving]
        )
        chords = np.linalg.norm(steps, axis=1)
        apart = np.append(True, chords > SAME)
        self.points = points[apart]
        self.s = np.append(
            0.0,
            np.cumsum(chords[apart[1:]]),
        )
        kind = "not-a-knot"
        if len(self.s) < 4:
            kind = "natural"
        self.boundary = kind
        self._spline = CubicSpline(
            self.s,
            self.points,
            axis=0,
            bc_type=kind,
        )

    @property
    def end(self) -> float:
        """The last parameter."""
        return float(self.s[-1])

    def at(self, s: Array, order: int = 0) -> Array:
        """Positions (M, n) at parameters (M,), or derivatives by s."""
        return np.asarray(self._spline(s, order))

    def between(self, s: float) -> str:
        """The place of a parameter as text."""
        number = int(np.searchsorted(self.s, s))
        return f"at {s / self.end:.1%} of the path, before its point {min(number, len(self.s) - 1)}"


def curve_of(path: ArrayLike | Trajectory, names: tuple[str, ...]) -> Curve:
    """The curve of points, or of a trajectory whose times do not matter.

    Args:
        path: (N, n) positions of the active joints [rad or m], or a trajectory.
        names: names of the n active joints.

    Raises:
        InputError: a shape is wrong, a number is not finite, or all points are one.
    """
    points = _sampled(path) if callable(path) else real_array("path", path)
    if points.ndim != 2 or points.shape[1] != len(names) or len(points) < 2:
        joints = ", ".join(names)
        raise InputError(
            f"path has shape {points.shape}; expected two or more rows of {len(names)} ({joints})"
        )
    if not np.isfinite(points).all():
        raise InputError("path has an entry that is not finite")
    return Curve(points)


def _sampled(trajectory: Trajectory) -> Array:
    """Positions (N, n) of a trajectory at its times and between them."""
    times = np.asarray(trajectory.times, dtype=float)
    count = SAMPLES * (len(times) - 1) + 1
    places = np.linspace(0.0, 1.0, count)
    given = np.linspace(0.0, 1.0, len(times))
    dense = np.interp(places, given, times)
    return np.asarray(trajectory(dense).u, dtype=float)
