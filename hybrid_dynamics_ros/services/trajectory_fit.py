"""Estimation of missing velocities and accelerations of points. It does not depend on ROS.

If all are missing, a cubic spline through the positions is used, at rest at both ends. Otherwise a
polynomial is fitted to the given values of a point and its neighbours.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..messages.joint_samples import FloatArray

Mask = NDArray[np.bool_]
_WINDOW: Final = 3  # points per polynomial
# The degree is reduced if the smallest over the largest singular value is below this.
_INDEPENDENT: Final = 1e-4


def completed(
    time: FloatArray, position: FloatArray, velocity: FloatArray, acceleration: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Velocities and accelerations of all points.

    Args:
        time: (N,) [s], increasing; N is 2 or more.
        position: (N, n) [rad or m].
        velocity: (N, n) [rad/s or m/s]; NaN in missing rows.
        acceleration: (N, n) [rad/s^2 or m/s^2]; NaN in missing rows.

    Returns:
        Two arrays (N, n), with given rows unchanged.
    """
    has_velocity, has_acceleration = _is_given(velocity), _is_given(acceleration)
    if not has_velocity.any() and not has_acceleration.any():
        spline = _interpolate().CubicSpline(time, position, bc_type="clamped")
        return spline(time, 1), spline(time, 2)
    fit = _Fit(time, position, velocity, acceleration)
    rates, rates_of_change = fit.derivatives(~(has_velocity & has_acceleration))
    velocity = np.where(has_velocity[:, None], velocity, rates)
    acceleration = np.where(has_acceleration[:, None], acceleration, rates_of_change)
    return velocity, acceleration


class _Fit:
    """Polynomials through the given values of points and their neighbours."""

    def __init__(
        self,
        time: FloatArray,
        position: FloatArray,
        velocity: FloatArray,
        acceleration: FloatArray,
    ) -> None:
        self._time = time
        self._values = np.stack([position, velocity, acceleration])
        self._given = _is_given(self._values)

    def derivatives(self, wanted: Mask) -> tuple[FloatArray, FloatArray]:
        """First and second derivatives (N, n) at the points of a mask, NaN elsewhere."""
        first = np.full(self._values.shape[1:], np.nan)
        second = first.copy()
        for points, windows, given in self._groups(np.flatnonzero(wanted)):
            self._solve(points, windows, given, first, second)
        return first, second

    def _groups(
        self, points: NDArray[np.intp]
    ) -> Iterator[tuple[NDArray[np.intp], NDArray[np.intp], Mask]]:
        """Groups of points with the same given values: points, windows (K, w), mask (3, w)."""
        count = self._time.size
        width = min(_WINDOW, count)
        starts = np.clip(points - 1, 0, count - width)
        windows = starts[:, None] + np.arange(width)
        given = self._given[:, windows].swapaxes(0, 1).reshape(len(points), 3 * width)
        kinds, members = np.unique(given, axis=0, return_inverse=True)
        members = members.reshape(-1)
        for kind, mask in enumerate(kinds):
            chosen = members == kind
            yield points[chosen], windows[chosen], mask.reshape(3, width)

    def _solve(
        self,
        points: NDArray[np.intp],
        windows: NDArray[np.intp],
        given: Mask,
        first: FloatArray,
        second: FloatArray,
    ) -> None:
        """Set the derivatives at the points, from the highest determined degree."""
        offsets = self._time[windows] - self._time[points][:, None]
        spans = np.abs(offsets).max(axis=1)
        values = self._values[:, windows].swapaxes(0, 1)
        powers = spans[:, None] ** np.arange(3)
        scaled = values * powers[:, :, None, None]
        data = scaled[:, given]
        unsolved = np.ones(len(points), dtype=bool)
        for degree in range(data.shape[1] - 1, 0, -1):
            matrix = _rows(offsets / spans[:, None], degree)[:, given]
            sizes = np.linalg.svd(matrix, compute_uv=False)
            solved = unsolved & (sizes[:, -1] > _INDEPENDENT * sizes[:, 0])
            if solved.any():
                inverse = np.linalg.pinv(matrix[solved])
                coefficients = inverse @ data[solved]
                span = spans[solved, None]
                first[points[solved]] = coefficients[:, 1] / span
                curvature = coefficients[:, 2] if degree > 1 else 0.0 * coefficients[:, 1]
                second[points[solved]] = 2.0 * curvature / span**2
                unsolved &= ~solved
            if not unsolved.any():
                return


def _is_given(values: FloatArray) -> Mask:
    """Mask of rows with numbers."""
    return np.asarray(np.isfinite(values).all(axis=-1))


def _rows(x: FloatArray, degree: int) -> FloatArray:
    """Values, first and second derivatives of the powers of x: (K, 3, w, degree + 1)."""
    powers = np.arange(degree + 1)
    value = x[..., None] ** powers
    slope = np.zeros_like(value)
    slope[..., 1:] = value[..., :-1] * powers[1:]
    curvature = np.zeros_like(value)
    curvature[..., 2:] = value[..., :-2] * (powers[2:] * powers[1:-1])
    return np.stack([value, slope, curvature], axis=1)


def _interpolate() -> Any:
    from scipy import interpolate  # noqa: PLC0415  slow to import, and only this needs it

    return interpolate
