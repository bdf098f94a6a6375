"""Closed forms for legs: a stroke or a crank from a distance, two angles from a direction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...algebra.independence import norm
from ...algebra.scalar import Scalar, Scalars, sqrt
from ...algebra.transform import IDENTITY
from ...algebra.vector import (
    Vector,
    add,
    constant,
    cross,
    dot,
    matmul,
    matvec,
    scale,
    sub,
    transpose,
    transposed_matvec,
)
from ...ground.arrays import Array
from ...mechanism.configuration import Configuration
from ...mechanism.joint_transform import through_joint, zero_rotation
from ...mechanism.tree import Body
from ..constraints.ball_cut import Orientation
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
        discriminant = squared - (dot(x, x) - along * along)
        configuration.set_length(self.unknowns[0], branch * sqrt(discriminant) - along)
        return discriminant / squared


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
    discriminant = squared - c * c
    margin = discriminant / squared
    root = branch * sqrt(discriminant)
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
        wanted = transposed_matvec(before.rotation, gap)
        joints = (pivot.first, pivot.second)
        return _point_along(joints, leg, wanted, configuration, branch, guess)


class BallJointBlock(BlockSolver):
    """The three angles of a ball joint from the orientation of its link."""

    modes = SIDES
    modes_fixed = True

    def __init__(self, orientation: Orientation) -> None:
        self.orientation = orientation
        self.equations = tuple(Equation(orientation, k) for k in range(orientation.size))
        self.unknowns = orientation.ball.coordinates

    def solve(self, configuration: Configuration, branch: Scalar, guess: Scalars) -> Scalar:
        """R1(q1) R2(q2) R3(q3) = W: the third axis gives q2 and q1; q3 is what remains."""
        loop = self.orientation
        first, second, third = loop.ball.joints
        target = loop.other.at(configuration)
        of_link = matmul(target.rotation, transpose(loop.chain.rotation))
        before = loop.ball.before.at(configuration)
        wanted = matmul(transpose(before.rotation), of_link)
        axis = third.axis
        last = matvec(third.rotation, axis)
        goal = matvec(wanted, axis)
        joints = (first, second)
        margin = _point_along(joints, last, goal, configuration, branch, guess)
        reached = IDENTITY
        for joint in joints:
            reached, _ = through_joint(reached, joint, configuration)
        parent, _ = reached
        parent = matmul(parent, third.rotation)
        mark = constant(_some_direction_across(axis))
        turned = transposed_matvec(parent, matvec(wanted, mark))
        cosine, sine = dot(mark, turned), dot(axis, cross(mark, turned))
        k = third.coordinate
        configuration.set_direction(k, cosine, sine, guess[k])
        return margin


def _some_direction_across(axis: Vector) -> Array:
    """A unit vector (3,) at right angles to a unit axis of floats."""
    direction = np.array(axis, dtype=float)
    side = np.eye(3)[int(np.argmin(np.abs(direction)))]
    across: Array = np.cross(direction, side)
    return across / norm(across)


def _point_along(
    joints: tuple[Body, Body],
    leg: Vector,
    goal: Vector,
    configuration: Configuration,
    branch: Scalar,
    guess: Scalars,
) -> Scalar:
    """Turn two joints so that a vector fixed to the second one points along a goal.

    Args:
        joints: bodies of the joints.
        leg: the vector, in the frame of the second body.
        goal: the goal, of the same length, in the frame before the first joint.
        configuration: receives the angles.
        branch: sign of the assembly mode.
        guess: all coordinates nearby [rad, m].

    Returns:
        The margin.
    """
    first, second = joints
    wanted = transposed_matvec(zero_rotation(first, configuration), goal)
    axis = first.axis
    height = dot(axis, wanted)
    c2, s2, margin = _turn_to_height(second, leg, axis, height, branch)
    configuration.set_direction(second.coordinate, c2, s2, guess[second.coordinate])
    reached = _turned(second, leg, c2, s2)
    flat = _across(axis, reached)
    flat_goal = _across(axis, wanted)
    squared = dot(flat_goal, flat_goal)
    c1 = dot(flat, flat_goal) / squared
    s1 = dot(axis, cross(flat, flat_goal)) / squared
    configuration.set_direction(first.coordinate, c1, s1, guess[first.coordinate])
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
