"""Derivatives of sampled values by a least-squares spline, without lag."""

from __future__ import annotations

import numpy as np

from ..ground.arrays import Array

DEGREE = 5  # gives cubic second derivatives


def spline_derivatives(
    time: Array, values: Array, bandwidth: float, orders: tuple[int, ...]
) -> tuple[Array, ...]:
    """Derivatives of a least-squares spline.

    The distance of knots is a quarter of the bandwidth's period, but at least three samples.

    Args:
        time: (N,) [s], ascending.
        values: (N, n) in any unit.
        bandwidth: of the motion [Hz].
        orders: orders of the derivatives; 0 is the smoothed value.

    Returns:
        Derivatives (N, n) for each order, in the unit of the values over s^order.
    """
    from scipy.interpolate import make_lsq_spline  # noqa: PLC0415  slow to import

    first, last = time[0], time[-1]
    interval = float(np.median(np.diff(time)))
    spacing = max(1.0 / (4.0 * bandwidth), 3.0 * interval)
    intervals = max(int((last - first) / spacing), 1)
    inner = np.linspace(first, last, intervals + 1)[1:-1]
    edges = np.concatenate([[first], inner, [last]])
    counts, _ = np.histogram(time, edges)
    # a knot next to an interval with at most one sample would be undetermined
    inner = inner[(counts[:-1] > 1) & (counts[1:] > 1)]
    ends = np.ones(DEGREE + 1)
    knots = np.concatenate([first * ends, inner, last * ends])
    spline = make_lsq_spline(time, values, knots, k=DEGREE)
    derivatives = []
    for order in orders:
        curve = spline.derivative(order) if order else spline
        derivatives.append(np.asarray(curve(time)))
    return tuple(derivatives)
