"""Parallelograms: opposite bars stay parallel, so the angles are linear in each other and regular everywhere.

Solved as a general four-bar the same loop has a change point where all bars are in line; Newton or a circle
intersection can leave it on the anti-parallelogram. The linear relation cannot.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ..algebra.scalar import Scalar
from ..algebra.vector import Vector, constant, turn
from .equations import Equation, Linearised, LoopEquations, Row
from .planar import PlanarJoint, PlanarPin
from .posture import Posture
from .step import Step

EQUAL = 1e-9  # relative difference up to which two bars count as equal
PARALLELOGRAM = "parallelogram"
Relation = tuple[dict[int, float], float]  # coefficients of known angles, constant [rad]


class AngleRelations(LoopEquations):
    """Each of two angles = constant + sum of +-known angles: linear rows, no bias, regular everywhere."""

    length = 1.0

    def __init__(self, name: str, relations: dict[int, Relation]) -> None:
        self.name, self.relations = name, relations
        self.involved = tuple(frozenset({k, *terms}) for k, (terms, _) in relations.items())

    def linearise(self, posture: Posture) -> Linearised:
        """Constant rows, residual of the linear relations."""
        rows: list[Row] = []
        residual: list[Scalar] = []
        for k, (terms, offset) in self.relations.items():
            rows.append({k: 1.0, **{i: -factor for i, factor in terms.items()}})
            known = sum((factor * posture.q[i] for i, factor in terms.items()), offset)
            residual.append(posture.q[k] - known)
        return Linearised(rows, residual)

    def bias(self, posture: Posture, rates: Sequence[Scalar]) -> list[Scalar]:  # noqa: ARG002
        """Linear relations have none."""
        return [0.0 for _ in self.relations]


class Parallelogram(Step):
    """Angles by addition; cosines and sines by the addition theorems."""

    modes = (PARALLELOGRAM,)

    def __init__(self, pin: PlanarPin, unknowns: tuple[PlanarJoint, PlanarJoint]) -> None:
        self.pin = pin
        self.relations = AngleRelations(pin.name, _relations(pin, unknowns))
        self.equations = (Equation(self.relations, 0), Equation(self.relations, 1))
        self.unknowns = tuple(j.coordinate for j in unknowns)

    def near(self, posture: Posture, near: Mapping[int, float]) -> None:
        """Shift the constants by whole turns so that the angles at this posture (floats) lie within pi of `near`."""
        relations = self.relations.relations
        for k, (terms, offset) in list(relations.items()):
            here = offset + sum(f * posture.q[i] for i, f in terms.items())
            turns = round((here - near.get(k, 0.0)) / (2.0 * math.pi))
            relations[k] = (terms, offset - 2.0 * math.pi * turns)

    def solve(self, posture: Posture, branch: Scalar, guess: Sequence[Scalar]) -> Scalar:  # noqa: ARG002
        """Always closes."""
        for k, (terms, offset) in self.relations.relations.items():
            direction: Vector = constant((math.cos(offset), math.sin(offset)))
            angle: Scalar = offset
            for i, factor in terms.items():
                direction = turn(posture.c[i], factor * posture.s[i], direction)
                angle = angle + factor * posture.q[i]
            posture.q[k], (posture.c[k], posture.s[k]) = angle, direction
        return 1.0


def _relations(pin: PlanarPin, unknowns: tuple[PlanarJoint, PlanarJoint]) -> dict[int, Relation]:
    """The relations, or ValueError with the reason why the loop is not a parallelogram."""
    loop = pin.geometry
    if not all(j.revolute for j in loop.joints):
        raise ValueError("a parallelogram has revolute joints only")
    known_a, known_b = (_known(chain, unknowns) for chain in (loop.chain_a, loop.chain_b))
    pivots = [np.array(j.place) for j in (*known_a, *known_b)]
    if not pivots or (len(pivots) == 2 and np.linalg.norm(pivots[0] - pivots[1]) > EQUAL * pin.length):
        raise ValueError("its two known bars do not meet in one pivot")
    centre = pivots[0]
    turn_a, turn_b = (_turn(known) for known in (known_a, known_b))
    first, second = unknowns
    on_a = [j in loop.chain_a for j in unknowns]
    p1, p2 = np.array(first.place), np.array(second.place)
    ends = [np.array(loop.point_a if a else loop.point_b) for a in on_a]
    if on_a[0] != on_a[1]:
        own, other = (turn_a, turn_b) if on_a[0] else (turn_b, turn_a)
        bars = [(ends[0] - p1, p2 - centre), (ends[1] - p2, p1 - centre)]
        offsets = [_parallel(pin, *bar) for bar in bars]
        return {
            first.coordinate: _relation(first, offsets[0], own, other),
            second.coordinate: _relation(second, offsets[1], other, own),
        }
    own, other = (turn_a, turn_b) if on_a[0] else (turn_b, turn_a)
    target = np.array(loop.point_b if on_a[0] else loop.point_a)
    offset = _parallel(pin, p2 - p1, target - centre)
    back = _parallel(pin, ends[1] - p2, centre - p1)
    return {
        first.coordinate: _relation(first, offset, own, other),
        second.coordinate: _relation(second, back - offset, other, own),
    }


def _known(chain: Sequence[PlanarJoint], unknowns: Sequence[PlanarJoint]) -> list[PlanarJoint]:
    known = [j for j in chain if j not in unknowns]
    if len(known) > 1 or any(j not in unknowns for j in chain[len(known) :]):
        raise ValueError("it has more than one known bar in a chain")
    return known


def _turn(known: list[PlanarJoint]) -> dict[int, float]:
    return {j.coordinate: j.sign for j in known}


def _parallel(pin: PlanarPin, bar: np.ndarray, to: np.ndarray) -> float:
    """Angle [rad] from `bar` to `to` at zero; ValueError if they differ in length."""
    lengths = float(np.linalg.norm(bar)), float(np.linalg.norm(to))
    if abs(lengths[0] - lengths[1]) > EQUAL * pin.length:
        raise ValueError(f"its opposite bars are {lengths[0]:.9g} m and {lengths[1]:.9g} m long")
    return math.atan2(bar[0] * to[1] - bar[1] * to[0], float(bar @ to))


def _relation(joint: PlanarJoint, offset: float, own: dict[int, float], other: dict[int, float]) -> Relation:
    """sign q = offset + turns of the other chain - turns of the own chain."""
    terms = {**{k: s * joint.sign for k, s in other.items()}, **{k: -s * joint.sign for k, s in own.items()}}
    return terms, offset * joint.sign
