"""A platform that only translates, on three legs: the intersection of three spheres."""

from __future__ import annotations

from collections.abc import Sequence

from ...algebra.linear import Inverse, transposed
from ...algebra.scalar import Scalar, Scalars, sqrt
from ...algebra.vector import Vector, add, cross, dot, scale, sub
from ...mechanism.configuration import Configuration
from ..constraints.equations import Equation
from ..constraints.leg import Distance
from ..constraints.spatial import Chain, ChainState
from .block_solver import SIDES, BlockSolver


class ThreeSpheresBlock(BlockSolver):
    """Three slides that move a platform, from three legs of known length."""

    modes = SIDES

    def __init__(self, distances: Sequence[Distance], unknowns: tuple[int, ...]) -> None:
        self.distances = tuple(distances)
        self.equations = tuple(Equation(distance, 0) for distance in distances)
        self.unknowns = unknowns

    def solve(self, configuration: Configuration, branch: Scalar, guess: Scalars) -> Scalar:
        """Intersect three spheres about the displacements at which one leg has no length.

        The margin is the squared sine of the elevation above the plane of the centres.
        """
        start = configuration.with_zeros(self.unknowns)
        centres: list[Vector] = []
        squares: list[Scalar] = []
        slides: list[Vector] = []
        for distance in self.distances:
            origin, leg, target = distance.ends(start)
            centres.append(sub(origin.end, target.end))
            squares.append(dot(leg.end, leg.end))
            slides = _axes(target, self.unknowns)
        u = sub(centres[1], centres[0])
        v = sub(centres[2], centres[0])
        n = cross(u, v)
        r0, r1, r2 = squares
        d1 = 0.5 * (dot(u, u) + r0 - r1)
        d2 = 0.5 * (dot(v, v) + r0 - r2)
        n2 = dot(n, n)
        in_plane = add(scale(d1, cross(v, n)), scale(d2, cross(n, u)))
        flat = scale(1.0 / n2, in_plane)
        margin = 1.0 - dot(flat, flat) / r0
        height = scale(branch * sqrt(r0 * margin / n2), n)
        moved = add(centres[0], add(flat, height))
        strokes = Inverse(transposed(slides)).solve(moved)
        for k, stroke in zip(self.unknowns, strokes, strict=True):
            configuration.set_length(k, stroke)
        return margin


def _axes(state: ChainState, unknowns: Sequence[int]) -> list[Vector]:
    """Axes of some joints of a chain."""
    axes = {joint.body.coordinate: joint.axis for joint in state.joints}
    return [axes[k] for k in unknowns]


def slides_only(chain: Chain, unknowns: Sequence[int]) -> bool:
    """Whether all unknowns are prismatic joints of the chain."""
    joints = [body for body in chain.bodies if body.coordinate in unknowns]
    return len(joints) == len(unknowns) and not any(body.is_revolute for body in joints)
