"""Parallelograms: opposite bars stay parallel, so the angles are linear in each other.

As a general four-bar, this loop has a change point where all bars are in line. There Newton's
method or a circle intersection can switch to the antiparallelogram. The linear equations cannot.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...algebra.independence import norm
from ...algebra.scalar import atan2
from ...algebra.vector import Vector
from ...ground.arrays import Array
from .angle_sum import AngleSum, Turns
from .planar import PlanarGeometry, PlanarJoint, PlanarPin

EQUAL = 1e-9  # relative difference up to which two bars count as equal, or two pivots as one
NO_BAR = 1e-6  # share of the loop's length below which two pivots differ by rounding only
PARALLELOGRAM = "parallelogram"


class _Side(NamedTuple):
    """A side of the polygon of pivots: its vector at zero, and the joints that turn it."""

    vector: Array
    turns: Turns

    @property
    def length(self) -> float:
        return norm(self.vector)


def parallelogram_equations(pin: PlanarPin) -> list[AngleSum]:
    """The two equations of a parallelogram: opposite bars are parallel.

    Raises:
        ValueError: the loop is not a parallelogram. The message says why.
    """
    if not all(joint.revolute for joint in pin.geometry.joints):
        raise ValueError("a parallelogram has revolute joints only")
    least = NO_BAR * pin.length
    bars = [side for side in _sides(pin.geometry) if side.length > least]
    if len(bars) != 4:
        raise ValueError(f"it has {len(bars)} bars, not four")
    first, second, third, fourth = bars
    return [_opposite(pin, first, third), _opposite(pin, second, fourth)]


def _sides(geometry: PlanarGeometry) -> list[_Side]:
    """Sides along chain a to the pin, back along chain b, then across the link where both start."""
    out = _bars(geometry.chain_a, geometry.point_a)
    bars = _bars(geometry.chain_b, geometry.point_b)
    back = [_Side(-bar.vector, bar.turns) for bar in bars]
    start_a = _first_pivot(geometry.chain_a, geometry.point_a)
    start_b = _first_pivot(geometry.chain_b, geometry.point_b)
    return [*out, *reversed(back), _Side(start_a - start_b, ())]


def _bars(chain: Sequence[PlanarJoint], point: Vector) -> list[_Side]:
    """Sides from each pivot of a chain to the next, and from the last one to the pin."""
    if not chain:
        return []
    pivots = [joint.place for joint in chain]
    turns: list[tuple[int, float]] = []
    bars: list[_Side] = []
    for joint, end in zip(chain, [*pivots[1:], point], strict=True):
        turns.append((joint.coordinate, joint.sign))
        bars.append(_Side(np.subtract(end, joint.place), tuple(turns)))
    return bars


def _first_pivot(chain: Sequence[PlanarJoint], point: Vector) -> Array:
    """The first pivot of a chain; the pin if the chain has no joints."""
    if chain:
        return np.array(chain[0].place)
    return np.array(point)


def _opposite(pin: PlanarPin, one: _Side, other: _Side) -> AngleSum:
    """The equation that `one` stays antiparallel to `other`."""
    if abs(one.length - other.length) > EQUAL * pin.length:
        raise ValueError(f"its opposite bars are {one.length:.9g} m and {other.length:.9g} m long")
    direction_one = atan2(one.vector[1], one.vector[0])
    direction_other = atan2(-other.vector[1], -other.vector[0])
    against = tuple((k, -sign) for k, sign in other.turns)
    return AngleSum(pin.name, (*one.turns, *against), direction_one - direction_other)
