"""Closed forms for legs: a stroke or a crank from a distance, two angles from a direction."""

from __future__ import annotations

from typing import NamedTuple

from ...algebra.scalar import Scalar, Scalars, sqrt
from ...algebra.vector import Vector, add, cross, dot, matvec, scale, sub, transposed_matvec
from ...mechanism.configuration import Configuration
from ...mechanism.joint_transform import zero_rotation
from ...mechanism.tree import Body
from ..constraints.equations import Equation
from ..constraints.leg import Direction, Distance
from ..constraints.spatial import ChainJoint
from .block_solver import ORIENTATIONS, SIDES, STROKES, BlockSolver

Turn = tuple[Scalar, Scalar, Scalar]  # cosine, sine, margin


class _OpenLeg(NamedTuple):
    """A leg with its unknown joint at zero, where |x| = |y| must hold.

    Attributes:
        x: the vector that the unknown joint moves.
        y: vector that does not depend on the unknown.
        end: end of the chain that has the unknown joint.
        joint: the unknown joint.
    """

    x: Vector
    y: Vector
    end: Vector
    joint: ChainJoint


class DistanceBlock(BlockSolver):
    """One distance, one unknown joint."""

    def __init__(self, distance: Distance, unknown: int) -> None:
        self.distance = distance
        self.equations = (Equation(distance, 0),)
        self.unknowns = (unknown,)

    def open_leg(self, configuration: Configuration) -> _OpenLeg:
        """The leg with the unknown at zero."""
        origin, leg, target = self.distance.ends(configuration.with_zeros(self.unknowns))
        gap = sub(target.end, origin.end)
        candidates = (
            (leg.end, gap, leg),
            (gap, leg.end, target),
            (scale(-1.0, gap), leg.end, origin),
        )
        (unknown,) = self.unknowns
        for x, y, state in candidates:
            joint = state.joint_of(unknown)
            if joint is not None:
                return _OpenLeg(x, y, state.end, joint)
        raise AssertionError("the unknown is in one of the chains")


class StrokeBlock(DistanceBlock):
    """The stroke q of a leg: |x + q e| = |y|."""

    modes = STROKES

    def solve(self, configuration: Configuration, branch: Scalar, guess: Scalars) -> Scalar:
        """A quadratic. The margin is cos^2 of the angle between leg and slide."""
        x, y, _, joint = self.open_leg(configuration)
        e = joint.axis
        along = dot(x, e)
        squared = dot(y, y)
        margin = 1.0 - (dot(x, x) - along * along) / squared
        configuration.set_length(self.unknowns[0], branch * sqrt(squared * margin) - along)
        return margin


class CrankBlock(DistanceBlock):
    """A crank from the length of its rod: |x| = |y| with x = h + R(q) v."""

    modes = ORIENTATIONS

    def solve(self, configuration: Configuration, branch: Scalar, guess: Scalars) -> Scalar:
        """A cos q + B sin q = C. The margin is sin^2 of the angle to the toggle point."""
        x, y, end, joint = self.open_leg(configuration)
        axis = joint.axis
        v = sub(end, joint.origin)
        h = sub(x, v)
        # R(q) v = v_along + cos q v_off + sin q (axis x v)
        v_across = cross(axis, v)
        v_along = scale(dot(axis, v), axis)
        v_off = sub(v, v_along)
        a = dot(h, v_off)
        b = dot(h, v_across)
        twice = dot(y, y) - dot(h, h) - dot(v, v)
        c = 0.5 * twice - dot(h, v_along)
        cosine, sine, margin = _solve_sum(a, b, c, branch)
        k = self.unknowns[0]
        configuration.set_direction(k, cosine, sine, guess[k])
        return margin


def _solve_sum(a: Scalar, b: Scalar, c: Scalar, branch: Scalar) -> Turn:
    """Solve a cos q + b sin q = c.

    Returns:
        Cosine, sine and the margin, sin^2 of the angle to the toggle point.
    """
    squared = a * a + b * b
    margin = 1.0 - c * c / squared
    root = branch * sqrt(squared * margin)
    cosine = (a * c - b * root) / squared
    sine = (b * c + a * root) / squared
    return cosine, sine, margin


class UniversalJointBlock(BlockSolver):
    """The two angles of a universal joint from the direction in which its leg must point."""

    modes = SIDES
    modes_fixed = True

    def __init__(self, direction: Direction) -> None:
        self.direction = direction
        self.equations = (Equation(direction, 0), Equation(direction, 1))
        self.unknowns = direction.pivot.coordinates

    def solve(self, configuration: Configuration, branch: Scalar, guess: Scalars) -> Scalar:
        """R1(q1) R2(q2) leg = gap: the part along the first axis gives q2, the other two q1."""
        pivot = self.direction.pivot
        before = pivot.before.at(configuration)
        after = pivot.after.at(configuration)
        gap = sub(self.direction.target.at(configuration).end, before.end)
        leg = sub(after.end, pivot.centre)
        # at q1 = 0
        zero = zero_rotation(pivot.first, configuration)
        wanted = transposed_matvec(zero, transposed_matvec(before.rotation, gap))
        axis = pivot.first.axis
        k1, k2 = self.unknowns
        height = dot(axis, wanted)
        c2, s2, margin = _turn_to_height(pivot.second, leg, axis, height, branch)
        configuration.set_direction(k2, c2, s2, guess[k2])
        reached = _turned(pivot.second, leg, c2, s2)
        flat = _across(axis, reached)
        goal = _across(axis, wanted)
        squared = dot(goal, goal)
        c1 = dot(flat, goal) / squared
        s1 = dot(axis, cross(flat, goal)) / squared
        configuration.set_direction(k1, c1, s1, guess[k1])
        return margin


def _across(axis: Vector, v: Vector) -> Vector:
    """The part of v at right angles to a unit axis."""
    return sub(v, scale(dot(axis, v), axis))


def _turned(body: Body, v: Vector, c: Scalar, s: Scalar) -> Vector:
    """rotation R(axis, q) v: from the body's frame to its parent's, without the translation."""
    along = scale(dot(body.axis, v), body.axis)
    off = sub(v, along)
    across = cross(body.axis, v)
    turned = add(along, add(scale(c, off), scale(s, across)))
    return matvec(body.rotation, turned)


def _turn_to_height(body: Body, v: Vector, axis: Vector, height: Scalar, branch: Scalar) -> Turn:
    """Solve for the joint angle at which v, fixed to the body, has a given component along `axis`.

    Returns:
        Its cosine, its sine and the margin.
    """
    n = transposed_matvec(body.rotation, axis)
    along = dot(body.axis, v) * dot(body.axis, n)
    a = dot(n, v) - along
    b = dot(n, cross(body.axis, v))
    return _solve_sum(a, b, height - along, branch)
