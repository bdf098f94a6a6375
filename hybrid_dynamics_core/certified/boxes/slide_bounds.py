"""Bounds of the strokes of slides in closed loops, from the triangle inequality.

The slides of a loop that follow each other without a joint that turns between them displace the end
of their chain by D q, where the columns of D are their directions. All other parts of the loop
together span it, so that |D q| is at most the sum of their lengths.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...algebra.independence import norm
from ...algebra.vector import sub
from ...closure.blocks.block_solver import BlockSolver
from ...closure.constraints.equations import LoopEquations, loops_of
from ...closure.constraints.leg import Distance
from ...closure.constraints.planar import ORIGIN, PlanarJoint, PlanarPin
from ...closure.constraints.spatial import Chain, SpatialClosure
from ...ground.arrays import Array
from ..enclosed import SOLVED
from ..setting import Setting

ROUNDED = 1.001  # more than what rounding takes from a bound
INDEPENDENT = 1e-6  # least singular value of D


class _Link(NamedTuple):
    """A joint of a chain.

    Attributes:
        coordinate: its index.
        turns: whether it is revolute.
        offset: distance [m] from the joint before, at zero.
        direction: of a slide, relative to the joint before, at zero; and the rotation to the next.
    """

    coordinate: int
    turns: bool
    offset: float
    direction: Array


Chains = Sequence[tuple[Sequence[_Link], float]]


def slide_bounds(block: BlockSolver, setting: Setting) -> Mapping[int, float] | None:
    """Largest strokes [m] of the unknown slides of a block by coordinate; None if unbounded."""
    slides = {k for k in block.unknowns if not setting.tree.is_revolute(k)}
    if not slides:
        return {}
    bounds: dict[int, float] = {}
    for loop in loops_of(block.equations):
        run = _run(_chains(loop), slides)
        if run is None:
            continue
        directions = np.array([link.direction for link in run]).T
        least = float(np.linalg.svd(directions, compute_uv=False)[-1])
        if least < INDEPENDENT:
            continue
        bound = ROUNDED * _span(_chains(loop), slides, setting) / least
        for link in run:
            bounds[link.coordinate] = min(bound, bounds.get(link.coordinate, math.inf))
    if slides - set(bounds):
        return None
    return bounds


def _chains(loop: LoopEquations) -> Chains:
    """The chains of a loop, each with the distance [m] from its last joint to its end."""
    if isinstance(loop, PlanarPin):
        g = loop.geometry
        return [_planar(g.chain_a, g.point_a), _planar(g.chain_b, g.point_b)]
    if isinstance(loop, SpatialClosure):
        return [_spatial(loop.a), _spatial(loop.b)]
    if isinstance(loop, Distance):
        links, end = _spatial(loop.pivot.after)
        leg = (links, end + norm(loop.pivot.centre))
        return [_spatial(loop.pivot.before), leg, _spatial(loop.target)]
    return []


def _planar(joints: Sequence[PlanarJoint], point: Sequence[float]) -> tuple[list[_Link], float]:
    links = []
    last: Sequence[float] = ORIGIN
    for joint in joints:
        offset = 0.0
        if joint.revolute:
            offset = norm(sub(joint.place, last))
            last = joint.place
        links.append(_Link(joint.coordinate, joint.revolute, offset, np.array(joint.place)))
    return links, norm(sub(point, last))


def _spatial(chain: Chain) -> tuple[list[_Link], float]:
    links = []
    rotation = np.eye(3)
    for body in chain.bodies:
        rotation = rotation @ np.array(body.rotation)
        direction = rotation @ np.array(body.axis)
        links.append(_Link(body.coordinate, body.is_revolute, norm(body.translation), direction))
    return links, norm(chain.point)


def _run(chains: Chains, slides: set[int]) -> list[_Link] | None:
    """The unknown slides of a loop if no joint turns between them; else None."""
    runs = []
    for links, _ in chains:
        places = [k for k, link in enumerate(links) if link.coordinate in slides]
        if places:
            runs.append((links, places))
    if len(runs) != 1:
        return None
    links, places = runs[0]
    between = links[places[0] : places[-1] + 1]
    if any(link.turns for link in between):
        return None
    return [links[k] for k in places]


def _span(chains: Chains, slides: set[int], setting: Setting) -> float:
    """Sum of the lengths [m] of all parts but the unknown slides."""
    total = 0.0
    for links, end in chains:
        total += end
        for link in links:
            total += link.offset
            if not link.turns and link.coordinate not in slides:
                total += abs(float(setting.configuration.q[link.coordinate])) + SOLVED
    return total
