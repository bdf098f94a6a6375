"""Planar loops with two unknown joints: closed by a triangle (circle intersection) or, for two slides, linearly.

Notation of the module: the loop closes when  P1 + R1 (v + R2 w) = C  (both unknowns on one chain)
or
P1 + R1 w1 = P2 + R2 w2  (one on each). Directions are found as (cos, sin); angles only afterwards.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...algebra.scalar import Scalar, sqrt
from ...algebra.vector import Vector, add, cross2, dot, scale, sub, turn
from ...mechanism.configuration import Configuration
from ..constraints.equations import Equation
from ..constraints.planar import PlanarJoint, PlanarPin
from .block_solver import BlockSolver

TURNS = ("counterclockwise", "clockwise")
SLIDES = ("extended", "retracted")


class DyadBlock(BlockSolver):
    """Both equations of one planar pin, for two unknown joints."""

    needs_mode = True

    def __init__(
        self, pin: PlanarPin, unknowns: tuple[PlanarJoint, PlanarJoint], near: Mapping[int, float]
    ) -> None:
        self.pin = pin
        self.equations = (Equation(pin, 0), Equation(pin, 1))
        self.joints = unknowns
        self.unknowns = tuple(j.coordinate for j in unknowns)
        self.near = near

    def place(self, joint: PlanarJoint, c: Scalar, s: Scalar, configuration: Configuration) -> None:
        """Set an unknown revolute joint from its turn about the loop's normal."""
        configuration.set_direction(
            joint.coordinate, c, joint.sign * s, self.near.get(joint.coordinate, 0.0)
        )


class _Cut:
    """The loop with its unknown joints at zero: where each unknown stands, and the ends of both chains."""

    def __init__(self, step: DyadBlock, configuration: Configuration) -> None:
        at_zero = configuration.copy()
        for joint in step.joints:
            k = joint.coordinate
            at_zero.q[k], at_zero.c[k], at_zero.s[k] = 0.0, 1.0, 0.0
        a, b = step.pin.chains(at_zero)
        self.on_a = [j in step.pin.geometry.chain_a for j in step.joints]
        self.same_chain = self.on_a[0] == self.on_a[1]
        self.where: list[Vector] = []
        for joint in step.joints:
            chain = a if joint in step.pin.geometry.chain_a else b
            index = list(chain.joints).index(joint)
            self.where.append(chain.pivots[index] or chain.directions[index] or ())
        self.ends = [a.end if on_a else b.end for on_a in self.on_a]
        self.target = b.end if self.on_a[0] else a.end  # the end of the chain without unknowns


class TwoTurns(DyadBlock):
    """Two revolute unknowns: a triangle with known sides; two assembly modes."""

    modes = TURNS

    def solve(
        self,
        configuration: Configuration,
        branch: Scalar,
        guess: Sequence[Scalar],  # noqa: ARG002
    ) -> Scalar:
        """Circle intersection in (cos, sin)."""
        cut = _Cut(self, configuration)
        first, second = self.joints
        p1, p2 = cut.where
        if cut.same_chain:
            v, w, reach = sub(p2, p1), sub(cut.ends[1], p2), sub(cut.target, p1)
            c2, s2, margin = _triangle(v, w, dot(reach, reach) - dot(v, v) - dot(w, w), branch)
            c1, s1 = _between(add(v, turn(c2, s2, w)), reach)
        else:
            v, w1, w2 = sub(p2, p1), sub(cut.ends[0], p1), sub(cut.ends[1], p2)
            c1, s1, margin = _triangle(v, w1, dot(v, v) + dot(w1, w1) - dot(w2, w2), branch)
            c2, s2 = _between(w2, sub(turn(c1, s1, w1), v))
        self.place(first, c1, s1, configuration)
        self.place(second, c2, s2, configuration)
        return margin


def _triangle(v: Vector, w: Vector, twice: Scalar, branch: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """(cos, sin) of the turn of w for which 2 v . (turned w) = twice; v to turned w is counterclockwise if branch = 1.

    The margin is sin^2 of the angle between v and the turned w.
    """
    squared = dot(v, v) * dot(w, w)
    k = 0.5 * twice
    margin = 1.0 - k * k / squared
    height = branch * sqrt(squared * margin)  # v x (turned w)
    a, b = dot(v, w), cross2(v, w)
    return (a * k + b * height) / squared, (a * height - b * k) / squared, margin


def _between(a: Vector, b: Vector) -> tuple[Scalar, Scalar]:
    """(cos, sin) of the turn that takes a to b, equally long."""
    squared = dot(a, a)
    return dot(a, b) / squared, cross2(a, b) / squared


class TurnAndSlide(DyadBlock):
    """One revolute and one prismatic unknown: a circle cut by a line; two assembly modes."""

    modes = SLIDES

    def solve(
        self,
        configuration: Configuration,
        branch: Scalar,
        guess: Sequence[Scalar],  # noqa: ARG002
    ) -> Scalar:
        """The stroke from a quadratic, then the direction."""
        cut = _Cut(self, configuration)
        turn_index = 0 if self.joints[0].revolute else 1
        pivot, slide = cut.where[turn_index], cut.where[1 - turn_index]
        if (
            cut.same_chain and turn_index == 0
        ):  # |v + q e| = |C - P1|: the slide turns with the joint
            start, radius = sub(cut.ends[0], pivot), sub(cut.target, pivot)
        elif cut.same_chain:  # |C - P2 - q e| = |w|: the joint rides on the slide
            start, radius = sub(pivot, cut.target), sub(cut.ends[0], pivot)
        else:  # |P + q e - P2| = |w2|: slide and joint face each other
            start, radius = sub(cut.ends[1 - turn_index], pivot), sub(cut.ends[turn_index], pivot)
        along, across = dot(start, slide), cross2(slide, start)
        squared = dot(radius, radius)
        margin = 1.0 - across * across / squared
        stroke = branch * sqrt(squared * margin) - along
        reached = add(start, scale(stroke, slide))
        configuration.set_length(self.joints[1 - turn_index].coordinate, stroke)
        if cut.same_chain and turn_index == 1:
            reached = scale(-1.0, reached)
        c, s = (
            _between(reached, radius)
            if cut.same_chain and turn_index == 0
            else _between(radius, reached)
        )
        self.place(self.joints[turn_index], c, s, configuration)
        return margin


class TwoSlides(DyadBlock):
    """Two prismatic unknowns: two linear equations, one solution."""

    def solve(
        self,
        configuration: Configuration,
        branch: Scalar,  # noqa: ARG002
        guess: Sequence[Scalar],  # noqa: ARG002
    ) -> Scalar:
        """Cramer's rule."""
        cut = _Cut(self, configuration)
        e1, e2 = cut.where
        if cut.same_chain:
            gap = sub(cut.target, cut.ends[0])
        else:
            gap, e2 = sub(cut.ends[1], cut.ends[0]), scale(-1.0, e2)
        det = cross2(e1, e2)
        configuration.set_length(self.unknowns[0], cross2(gap, e2) / det)
        configuration.set_length(self.unknowns[1], cross2(e1, gap) / det)
        return det * det


def dyad(
    pin: PlanarPin, unknowns: tuple[PlanarJoint, PlanarJoint], near: Mapping[int, float]
) -> DyadBlock:
    """The block that closes a planar loop for two unknown joints."""
    turns = sum(j.revolute for j in unknowns)
    return (TwoSlides, TurnAndSlide, TwoTurns)[turns](pin, unknowns, near)
