"""Planar loops with two unknown joints: a dyad, closed by a triangle or, for two slides, linearly.

Notation: with both unknowns on one chain the loop closes if P1 + R1 (v + R2 w) = C. With one on
each chain it closes if P1 + R1 w1 = P2 + R2 w2. P are pivots, R plane rotations, C the end of the
chain without unknowns. Directions are solved as (cos, sin), and angles follow from them.
"""

from __future__ import annotations

from ...algebra.scalar import Scalar, Scalars, sqrt
from ...algebra.vector import Vector, add, cross2, dot, scale, sub, turn
from ...mechanism.configuration import Configuration
from ..constraints.equations import Equation
from ..constraints.planar import PlanarJoint, PlanarPin
from .block_solver import ORIENTATIONS, STROKES, BlockSolver

Joints = tuple[PlanarJoint, PlanarJoint]


class DyadBlock(BlockSolver):
    """Both equations of one planar pin, for two unknown joints."""

    needs_mode = True

    def __init__(self, pin: PlanarPin, joints: Joints) -> None:
        self.pin = pin
        self.equations = (Equation(pin, 0), Equation(pin, 1))
        self.joints = joints
        self.unknowns = tuple(joint.coordinate for joint in joints)


def _set_turn(
    configuration: Configuration, joint: PlanarJoint, c: Scalar, s: Scalar, guess: Scalars
) -> None:
    """Set an unknown revolute joint from its rotation about the loop's normal."""
    k = joint.coordinate
    configuration.set_direction(k, c, joint.sign * s, guess[k])


class _OpenLoop:
    """The loop with its unknown joints at zero.

    Attributes:
        same_chain: whether both unknowns are on one chain.
        places: pivot or direction of each unknown.
        ends: end point of the chain of each unknown.
        target: end point of the chain that does not have the first unknown.
    """

    def __init__(self, block: DyadBlock, configuration: Configuration) -> None:
        a, b = block.pin.chains(configuration.with_zeros(block.unknowns))
        on_a = [joint in a.joints for joint in block.joints]
        self.same_chain = on_a[0] == on_a[1]
        self.places: list[Vector] = []
        self.ends: list[Vector] = []
        for joint, is_on_a in zip(block.joints, on_a, strict=True):
            chain = b
            if is_on_a:
                chain = a
            index = list(chain.joints).index(joint)
            self.places.append(chain.places[index])
            self.ends.append(chain.end)
        self.target = a.end
        if on_a[0]:
            self.target = b.end


class TwoRevolute(DyadBlock):
    """Two revolute unknowns: a triangle with known sides and two assembly modes."""

    modes = ORIENTATIONS

    def solve(self, configuration: Configuration, branch: Scalar, guess: Scalars) -> Scalar:
        """Intersect two circles, in (cos, sin)."""
        loop = _OpenLoop(self, configuration)
        first, second = self.joints
        p1, p2 = loop.places
        v = sub(p2, p1)
        if loop.same_chain:
            w = sub(loop.ends[1], p2)
            reach = sub(loop.target, p1)
            twice = dot(reach, reach) - dot(v, v) - dot(w, w)
            c2, s2, margin = _triangle(v, w, twice, branch)
            c1, s1 = _turn_from(add(v, turn(c2, s2, w)), reach)
        else:
            w1 = sub(loop.ends[0], p1)
            w2 = sub(loop.ends[1], p2)
            twice = dot(v, v) + dot(w1, w1) - dot(w2, w2)
            c1, s1, margin = _triangle(v, w1, twice, branch)
            c2, s2 = _turn_from(w2, sub(turn(c1, s1, w1), v))
        _set_turn(configuration, first, c1, s1, guess)
        _set_turn(configuration, second, c2, s2, guess)
        return margin


def _triangle(v: Vector, w: Vector, twice: Scalar, branch: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """The rotation R with 2 v . (R w) = `twice`; branch 1 puts R w counterclockwise of v.

    Returns:
        Its cosine, its sine and the margin: sin^2 of the angle between v and R w.
    """
    squared = dot(v, v) * dot(w, w)
    k = 0.5 * twice
    left = squared - k * k
    margin = left / squared
    height = branch * sqrt(left)  # v x (R w)
    a = dot(v, w)
    b = cross2(v, w)
    cosine = (a * k + b * height) / squared
    sine = (a * height - b * k) / squared
    return cosine, sine, margin


def _turn_from(a: Vector, b: Vector) -> tuple[Scalar, Scalar]:
    """Cosine and sine of the rotation that takes a to b, two vectors of one length."""
    squared = dot(a, a)
    return dot(a, b) / squared, cross2(a, b) / squared


class RevoluteAndPrismatic(DyadBlock):
    """One revolute and one prismatic unknown: a circle cut by a line, and two assembly modes."""

    modes = STROKES

    def solve(self, configuration: Configuration, branch: Scalar, guess: Scalars) -> Scalar:
        """The stroke q from a quadratic, then the direction."""
        loop = _OpenLoop(self, configuration)
        revolute = 1
        if self.joints[0].revolute:
            revolute = 0
        prismatic = 1 - revolute
        pivot = loop.places[revolute]
        e = loop.places[prismatic]
        slide_turns = loop.same_chain and revolute == 0
        joint_rides = loop.same_chain and revolute == 1
        if slide_turns:  # |v + q e| = |C - P1|: the slide turns with the joint
            start = sub(loop.ends[0], pivot)
            radius = sub(loop.target, pivot)
        elif joint_rides:  # |C - P2 - q e| = |w|: the joint rides on the slide
            start = sub(pivot, loop.target)
            radius = sub(loop.ends[0], pivot)
        else:  # |P + q e - P2| = |w2|: slide and joint face each other
            start = sub(loop.ends[prismatic], pivot)
            radius = sub(loop.ends[revolute], pivot)
        along = dot(start, e)
        across = cross2(e, start)
        squared = dot(radius, radius)
        left = squared - across * across
        margin = left / squared
        stroke = branch * sqrt(left) - along
        reached = add(start, scale(stroke, e))
        configuration.set_length(self.joints[prismatic].coordinate, stroke)
        if slide_turns:
            c, s = _turn_from(reached, radius)
        elif joint_rides:
            c, s = _turn_from(radius, scale(-1.0, reached))
        else:
            c, s = _turn_from(radius, reached)
        _set_turn(configuration, self.joints[revolute], c, s, guess)
        return margin


class TwoPrismatic(DyadBlock):
    """Two prismatic unknowns: two linear equations, one solution."""

    def solve(self, configuration: Configuration, branch: Scalar, guess: Scalars) -> Scalar:
        """Cramer's rule."""
        loop = _OpenLoop(self, configuration)
        e1, e2 = loop.places
        if loop.same_chain:
            gap = sub(loop.target, loop.ends[0])
        else:
            gap = sub(loop.ends[1], loop.ends[0])
            e2 = scale(-1.0, e2)
        determinant = cross2(e1, e2)
        configuration.set_length(self.unknowns[0], cross2(gap, e2) / determinant)
        configuration.set_length(self.unknowns[1], cross2(e1, gap) / determinant)
        return determinant * determinant


def dyad(pin: PlanarPin, joints: Joints) -> DyadBlock:
    """The block that closes a planar loop for two unknown joints."""
    revolute = [joint.revolute for joint in joints]
    if all(revolute):
        return TwoRevolute(pin, joints)
    if any(revolute):
        return RevoluteAndPrismatic(pin, joints)
    return TwoPrismatic(pin, joints)
