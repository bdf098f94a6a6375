"""Four-bars whose coupler point goes along a straight line, and how straight it goes.

Chebyshev's lambda mechanism, and the symmetric four-bars of Hoecken's kind beside it: coupler and
rocker have one length, and the point is as far beyond their pin. Norton, Design of Machinery,
Chapter 3, has a table of their proportions by the span of the crank.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arguments import real_number
from ..ground.check_arrays import real_array
from .four_bar import FourBar

_SAMPLES = 181  # of a span
_START = (2.5, 3.25)  # ground and coupler in cranks, in the middle of the table
_LONGEST_SPAN = math.pi
_FLAT = 1e-12  # width of points on a line, in their length


class Straightness(NamedTuple):
    """How straight a curve is.

    Attributes:
        length: its extent along the line [m].
        deviation: least distance of two parallel lines that hold it [m] (ISO 1101).
    """

    length: float
    deviation: float

    @property
    def ratio(self) -> float:
        """The deviation in lengths."""
        return self.deviation / self.length


class StraightLine(NamedTuple):
    """A four-bar with a point of its coupler that goes along a line.

    Attributes:
        bar: the four-bar.
        point: the point from the pin of the crank, along the coupler and across (2,) [m].
        crank: angles of the crank over which it does (k,) [rad].
    """

    bar: FourBar
    point: Array
    crank: Array

    def straightness(self) -> Straightness:
        """How straight it goes."""
        return straightness(self.bar.coupler_path(self.point, self.crank))


def straightness(points: ArrayLike) -> Straightness:
    """Extent and deviation of points (N, 2) from their straightest line.

    Raises:
        InputError: the points are fewer than two different ones.
    """
    from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415  slow to import

    array = real_array("points", points)
    if array.ndim != 2 or array.shape[1] != 2 or not np.ptp(array):
        raise InputError(f"points have shape {array.shape}; expected (N, 2), not all the same")
    centred = array - array.mean(axis=0)
    _, _, directions = np.linalg.svd(centred)
    along = centred @ directions.T
    length, width = np.ptp(along, axis=0).tolist()
    if width <= _FLAT * length:
        return Straightness(length, width)
    try:
        corners = along[ConvexHull(along).vertices]
    except QhullError:  # flat to rounding
        return Straightness(length, width)
    edges = np.roll(corners, -1, axis=0) - corners
    normals = np.column_stack([-edges[:, 1], edges[:, 0]])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    widths = np.ptp(corners @ normals.T, axis=0)
    return Straightness(length, float(widths.min()))


def chebyshev_lambda(crank: float = 1.0, span: float = math.pi) -> StraightLine:
    """Chebyshev's lambda mechanism: ground 2, coupler and rocker 2.5, point at 5 cranks.

    Args:
        crank: length of its crank [m].
        span: angle of the crank over which the point is looked at [rad].
    """
    return _symmetric(crank, 2.0, 2.5, _checked(span))


def straight_line(span: float, crank: float = 1.0) -> StraightLine:
    """The symmetric four-bar whose point goes straightest while the crank turns over a span.

    Args:
        span: angle of the crank [rad], up to half a turn, about the place where it points away from
            the rocker's pivot.
        crank: length of the crank [m].

    Raises:
        InputError: the span is not above 0 and up to half a turn.
    """
    from scipy.optimize import minimize  # noqa: PLC0415  slow to import

    checked = _checked(span)

    def ratio(proportions: Array) -> float:
        ground, coupler = proportions.tolist()
        if ground <= 1.0 or 2.0 * coupler <= ground + 1.0:
            return math.inf  # the crank does not turn
        return _symmetric(1.0, ground, coupler, checked).straightness().ratio

    options = {"xatol": 1e-9, "fatol": 1e-14, "maxiter": 2000}
    ended = minimize(ratio, _START, method="Nelder-Mead", options=options)
    ground, coupler = ended.x.tolist()
    return _symmetric(crank, ground, coupler, checked)


def _checked(span: float) -> float:
    value = real_number("span", span)
    if not 0.0 < value <= _LONGEST_SPAN:
        raise InputError(f"span is {value:g} rad; expected more than 0, up to half a turn")
    return value


def _symmetric(crank: float, ground: float, coupler: float, span: float) -> StraightLine:
    """The four-bar of proportions in cranks, with its crank turned away from the rocker."""
    half = 0.5 * span
    angles = math.pi + np.linspace(-half, half, _SAMPLES)
    reach = 0.5 * (ground + 1.0) / coupler  # cosine of the rocker's angle at the middle
    bar = FourBar(
        ground=crank * ground,
        crank=crank,
        coupler=crank * coupler,
        rocker=crank * coupler,
        crank_angle=math.pi,
        rocker_angle=math.pi - math.acos(reach),
    )
    return StraightLine(bar, np.array([2.0 * bar.coupler, 0.0]), angles)
