"""Parallelograms: opposite bars stay parallel, so the angles are linear in each other and regular everywhere.

Solved as a general four-bar the same loop has a change point where all bars are in line; Newton or
a circle intersection can leave it on the anti-parallelogram. The linear relations cannot.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...algebra.scalar import Scalar
from ...algebra.vector import Vector, constant, turn
from ...ground.arrays import Array
from ...mechanism.configuration import Configuration
from ..constraints.equations import Equation
from ..constraints.planar import AngleSum, PlanarGeometry, PlanarJoint, PlanarPin, Turns
from .block_solver import Step

EQUAL = 1e-9  # relative difference up to which two bars count as equal, two pivots as one
PARALLELOGRAM = "parallelogram"


class _Side(NamedTuple):
    """A side of the polygon of pivots: its vector at zero, and the joints that turn it with their signs."""

    vector: Array
    turns: Turns


def parallelogram_equations(pin: PlanarPin) -> list[AngleSum]:
    """Opposite bars are parallel, twice.

    ValueError with the reason where the loop is not a parallelogram.
    """
    if not all(j.revolute for j in pin.geometry.joints):
        raise ValueError("a parallelogram has revolute joints only")
    sides = [
        side for side in _sides(pin.geometry) if np.linalg.norm(side.vector) > EQUAL * pin.length
    ]
    if len(sides) != 4:
        raise ValueError(f"it has {len(sides)} bars, not four")
    return [_opposite(pin, sides[k], sides[k + 2]) for k in (0, 1)]


def _sides(geometry: PlanarGeometry) -> list[_Side]:
    """Around the loop: out along chain a to the pin, back along chain b, and across the link where they part."""
    out = _bars(geometry.chain_a, geometry.point_a)
    back = [
        _Side(-bar.vector, bar.turns) for bar in reversed(_bars(geometry.chain_b, geometry.point_b))
    ]
    starts = [
        np.array(chain[0].place if chain else point)
        for chain, point in (
            (geometry.chain_a, geometry.point_a),
            (geometry.chain_b, geometry.point_b),
        )
    ]
    return [*out, *back, _Side(starts[0] - starts[1], ())]


def _bars(chain: Sequence[PlanarJoint], point: Vector) -> list[_Side]:
    """From each pivot of a chain to the next, the last to the pin."""
    places = [np.array(j.place) for j in chain] + [np.array(point)]
    turns = [(j.coordinate, j.sign) for j in chain]
    return [_Side(places[k + 1] - places[k], tuple(turns[: k + 1])) for k in range(len(chain))]


def _opposite(pin: PlanarPin, one: _Side, other: _Side) -> AngleSum:
    """`one` stays parallel to `other`, against it."""
    lengths = float(np.linalg.norm(one.vector)), float(np.linalg.norm(other.vector))
    if abs(lengths[0] - lengths[1]) > EQUAL * pin.length:
        raise ValueError(f"its opposite bars are {lengths[0]:.9g} m and {lengths[1]:.9g} m long")
    offset = math.atan2(one.vector[1], one.vector[0]) - math.atan2(
        -other.vector[1], -other.vector[0]
    )
    return AngleSum(pin.name, (*one.turns, *((k, -sign) for k, sign in other.turns)), offset)


class AngleStep(Step):
    """One angle from the others of a sum: by addition; cosine and sine by the addition theorems."""

    def __init__(self, relation: AngleSum, unknown: int, mode: str) -> None:
        self.relation = relation
        self.equations = (Equation(relation, 0),)
        self.unknowns = (unknown,)
        self.modes = (mode,)
        self._sign = dict(relation.turns)[unknown]
        self._others = [(k, -sign * self._sign) for k, sign in relation.turns if k != unknown]
        self._offset = -relation.offset * self._sign

    def near(self, configuration: Configuration, near: Mapping[int, float]) -> None:
        """Shift the constant by whole turns so that the angle at this configuration (floats) lies within pi of `near`."""
        here = self._offset + sum(sign * configuration.q[k] for k, sign in self._others)
        self._offset -= (
            2.0 * math.pi * round((here - near.get(self.unknowns[0], 0.0)) / (2.0 * math.pi))
        )

    def solve(
        self,
        configuration: Configuration,
        branch: Scalar,  # noqa: ARG002
        guess: Sequence[Scalar],  # noqa: ARG002
    ) -> Scalar:
        """Always closes."""
        direction: Vector = constant((math.cos(self._offset), math.sin(self._offset)))
        angle: Scalar = self._offset
        for k, sign in self._others:
            direction = turn(configuration.c[k], sign * configuration.s[k], direction)
            angle = angle + sign * configuration.q[k]
        (unknown,) = self.unknowns
        configuration.q[unknown], (configuration.c[unknown], configuration.s[unknown]) = (
            angle,
            direction,
        )
        return 1.0
