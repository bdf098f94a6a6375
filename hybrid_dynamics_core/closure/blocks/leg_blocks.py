"""Closed forms for legs: a stroke or a crank from a distance, two angles from a direction, a platform from three."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...algebra.linear import Inverse
from ...algebra.scalar import Scalar, sqrt
from ...algebra.vector import Vector, add, cross, dot, matvec, scale, sub, transposed_matvec
from ...mechanism.configuration import Configuration
from ...mechanism.tree import Body
from ..constraints.equations import Equation
from ..constraints.leg import Direction, Distance
from ..constraints.spatial import Chain, ChainState
from .block_solver import BlockSolver

SLIDES = ("extended", "retracted")
TURNS = ("counterclockwise", "clockwise")
SIDES = ("front", "back")


def _at_zero(configuration: Configuration, coordinates: Sequence[int]) -> Configuration:
    trial = configuration.copy()
    for k in coordinates:
        trial.q[k], trial.c[k], trial.s[k] = 0.0, 1.0, 0.0
    return trial


class DistanceBlock(BlockSolver):
    """One distance, one unknown joint."""

    def __init__(self, distance: Distance, unknown: int, near: Mapping[int, float]) -> None:
        self.distance = distance
        self.equations = (Equation(distance, 0),)
        self.unknowns = (unknown,)
        self.near = near

    def moved(self, configuration: Configuration) -> tuple[Vector, Vector, int, ChainState]:
        """(x, y, i, state): |x| = |y| must hold; the unknown is joint i of `state` and moves the end that x has.

        x is taken with the unknown at zero and grows with that end; y does not depend on it.
        """
        origin, leg, target = self.distance.ends(_at_zero(configuration, self.unknowns))
        gap = sub(target.end, origin.end)
        for x, y, state in (
            (leg.end, gap, leg),
            (gap, leg.end, target),
            (scale(-1.0, gap), leg.end, origin),
        ):
            for i, body in enumerate(state.chain.bodies):
                if body.coordinate == self.unknowns[0]:
                    return x, y, i, state
        raise AssertionError("the unknown is in one of the chains")


class SlideDistance(DistanceBlock):
    """The stroke of a leg: |x + q e| = |y|."""

    modes = SLIDES

    def solve(
        self,
        configuration: Configuration,
        branch: Scalar,
        guess: Sequence[Scalar],  # noqa: ARG002
    ) -> Scalar:
        """A quadratic; the margin is cos^2 of the angle between leg and slide."""
        x, y, i, state = self.moved(configuration)
        e = state.axes[i]
        along, squared = dot(x, e), dot(y, y)
        margin = 1.0 - (dot(x, x) - along * along) / squared
        configuration.set_length(self.unknowns[0], branch * sqrt(squared * margin) - along)
        return margin


class TurnDistance(DistanceBlock):
    """A crank from the length of its rod: |x| = |y| with x = h + R(q) v."""

    modes = TURNS

    def solve(
        self,
        configuration: Configuration,
        branch: Scalar,
        guess: Sequence[Scalar],  # noqa: ARG002
    ) -> Scalar:
        """A cos q + B sin q = C; the margin is sin^2 of the angle to the toggle point."""
        x, y, i, state = self.moved(configuration)
        axis = state.axes[i]
        v = sub(state.end, state.origins[i])
        h = sub(x, v)
        across = cross(axis, v)  # R(q) v = v_along + cos q v_off + sin q (axis x v)
        along = scale(dot(axis, v), axis)
        off = sub(v, along)
        a, b = dot(h, off), dot(h, across)
        c = 0.5 * (dot(y, y) - dot(h, h) - dot(v, v)) - dot(h, along)
        squared = a * a + b * b
        margin = 1.0 - c * c / squared
        root = branch * sqrt(squared * margin)
        k = self.unknowns[0]
        cosine, sine = (a * c - b * root) / squared, (b * c + a * root) / squared
        configuration.set_direction(k, cosine, sine, self.near.get(k, 0.0))
        return margin


class PivotDirection(BlockSolver):
    """The two angles of a universal joint from the direction in which its leg must point."""

    modes = SIDES
    modes_fixed = True

    def __init__(self, direction: Direction, near: Mapping[int, float]) -> None:
        self.direction = direction
        self.equations = (Equation(direction, 0), Equation(direction, 1))
        pivot = direction.pivot
        self.unknowns = (pivot.first.coordinate, pivot.second.coordinate)
        self.near = near

    def solve(
        self,
        configuration: Configuration,
        branch: Scalar,
        guess: Sequence[Scalar],  # noqa: ARG002
    ) -> Scalar:
        """R1(q1) R2(q2) leg = gap: the component along the first axis gives q2, the rest q1."""
        pivot = self.direction.pivot
        before, after = pivot.before.at(configuration), pivot.after.at(configuration)
        gap = sub(self.direction.target.at(configuration).end, before.end)
        leg = sub(after.end, pivot.centre)
        wanted = transposed_matvec(
            pivot.first.rotation, transposed_matvec(before.rotation, gap)
        )  # at q1 = 0
        axis = pivot.first.axis
        c2, s2, margin = _turn_to_height(pivot.second, leg, axis, dot(axis, wanted), branch)
        k1, k2 = self.unknowns
        configuration.set_direction(k2, c2, s2, self.near.get(k2, 0.0))
        reached = _turned(pivot.second, leg, c2, s2)
        flat, goal = (
            sub(reached, scale(dot(axis, reached), axis)),
            sub(wanted, scale(dot(axis, wanted), axis)),
        )
        squared = dot(goal, goal)
        configuration.set_direction(
            k1,
            dot(flat, goal) / squared,
            dot(axis, cross(flat, goal)) / squared,
            self.near.get(k1, 0.0),
        )
        return margin


def _turned(body: Body, v: Vector, c: Scalar, s: Scalar) -> Vector:
    """rotation R(axis, q) v: from the body's frame to its parent's, without the translation."""
    along = scale(dot(body.axis, v), body.axis)
    off = sub(v, along)
    return matvec(body.rotation, add(along, add(scale(c, off), scale(s, cross(body.axis, v)))))


def _turn_to_height(
    body: Body, v: Vector, axis: Vector, height: Scalar, branch: Scalar
) -> tuple[Scalar, Scalar, Scalar]:
    """(cos, sin) of the joint's angle at which v, carried by the body, has the given component along `axis`."""
    n = transposed_matvec(body.rotation, axis)
    along = dot(body.axis, v) * dot(body.axis, n)
    a, b = dot(n, v) - along, dot(n, cross(body.axis, v))
    c = height - along
    squared = a * a + b * b
    margin = 1.0 - c * c / squared
    root = branch * sqrt(squared * margin)
    return (a * c - b * root) / squared, (b * c + a * root) / squared, margin


class ThreeSpheres(BlockSolver):
    """A platform that only translates, on three legs of known length: the intersection of three spheres."""

    modes = SIDES

    def __init__(self, distances: Sequence[Distance], unknowns: tuple[int, ...]) -> None:
        self.distances = tuple(distances)
        self.equations = tuple(Equation(d, 0) for d in distances)
        self.unknowns = unknowns

    def solve(
        self,
        configuration: Configuration,
        branch: Scalar,
        guess: Sequence[Scalar],  # noqa: ARG002
    ) -> Scalar:
        """Centres where each leg alone would put the platform; the margin is sin^2 of the height over their plane."""
        at_zero = _at_zero(configuration, self.unknowns)
        centres: list[Vector] = []
        squares: list[Scalar] = []
        slides: list[Vector] = []
        for distance in self.distances:
            origin, leg, target = distance.ends(at_zero)
            centres.append(sub(origin.end, target.end))
            squares.append(dot(leg.end, leg.end))
            slides = [_axis(target, k) for k in self.unknowns]
        u, v = sub(centres[1], centres[0]), sub(centres[2], centres[0])
        n = cross(u, v)
        d1 = 0.5 * (dot(u, u) + squares[0] - squares[1])
        d2 = 0.5 * (dot(v, v) + squares[0] - squares[2])
        n2 = dot(n, n)
        flat = scale(1.0 / n2, add(scale(d1, cross(v, n)), scale(d2, cross(n, u))))
        margin = 1.0 - dot(flat, flat) / squares[0]
        moved = add(centres[0], add(flat, scale(branch * sqrt(squares[0] * margin / n2), n)))
        rows = [[slide[i] for slide in slides] for i in range(3)]
        for k, value in zip(self.unknowns, Inverse(rows).solve(list(moved)), strict=True):
            configuration.set_length(k, value)
        return margin


def _axis(state: ChainState, coordinate: int) -> Vector:
    return next(
        a for a, b in zip(state.axes, state.chain.bodies, strict=True) if b.coordinate == coordinate
    )


def slides_only(chain: Chain, unknowns: Sequence[int]) -> bool:
    """Whether the unknowns are prismatic joints of the chain that no unknown or later joint turns."""
    found = [b for b in chain.bodies if b.coordinate in unknowns]
    return len(found) == len(unknowns) and all(b.type == "prismatic" for b in found)
