"""Which block closes in closed form: the known patterns, tried in order; Newton for the rest.

A new closed form is a Step and one function here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ...description.model import Closure
from ...mechanism.tree import Tree
from ..constraints.joint_coupling import CoordinateRelation, RelationStep
from ..constraints.leg import Direction, Distance
from ..constraints.planar import AngleSum, PlanarPin
from ..matching import Block
from .block_solver import Step
from .dyad import dyad
from .leg_blocks import PivotDirection, SlideDistance, ThreeSpheres, TurnDistance, slides_only
from .newton import NewtonStep
from .parallelogram import PARALLELOGRAM, AngleStep


@dataclass(frozen=True)
class Context:
    """What patterns need to know of the robot: its tree, its closures by name, and angles to stay near to [rad]."""

    tree: Tree
    closures: Mapping[str, Closure]
    near: Mapping[int, float]
    named: bool = (
        True  # whether the modes that the file names are meant: for the active coordinates only
    )

    def revolute(self, coordinate: int) -> bool:
        """Whether a coordinate is an angle."""
        return self.tree.is_revolute(coordinate)


def make_step(block: Block, context: Context) -> Step:
    """The step that solves a block."""
    for pattern in _PATTERNS:
        step = pattern(block, context)
        if step is not None:
            return step
    revolute = {k: context.revolute(k) for e in block.equations for k in e.involved}
    return NewtonStep(block.equations, block.unknowns, revolute)


def _planar_pin(block: Block, context: Context) -> Step | None:
    pins = {e.loop for e in block.equations}
    if len(pins) != 1 or len(block.equations) != 2:
        return None
    pin = pins.pop()
    if not isinstance(pin, PlanarPin):
        return None
    first, second = (j for j in pin.geometry.joints if j.coordinate in block.unknowns)
    return dyad(pin, (first, second), context.near)


def _angle_sum(block: Block, context: Context) -> Step | None:
    loop = block.equations[0].loop
    if len(block.equations) != 1 or not isinstance(loop, AngleSum):
        return None
    parallelogram = context.closures[loop.name].assembly == PARALLELOGRAM
    return AngleStep(loop, block.unknowns[0], PARALLELOGRAM if parallelogram else "only")


def _relation(block: Block, context: Context) -> Step | None:
    loop, unknown = block.equations[0].loop, block.unknowns[0]
    if len(block.equations) != 1 or not isinstance(loop, CoordinateRelation):
        return None
    return RelationStep(loop, unknown, context.revolute(unknown))


def _one_distance(block: Block, context: Context) -> Step | None:
    loop = block.equations[0].loop
    if len(block.equations) != 1 or not isinstance(loop, Distance):
        return None
    unknown = block.unknowns[0]
    form = TurnDistance if context.revolute(unknown) else SlideDistance
    return form(loop, unknown, context.near)


def _direction(block: Block, context: Context) -> Step | None:
    loop = block.equations[0].loop
    if len(block.equations) != 2 or not isinstance(loop, Direction):
        return None
    if set(block.unknowns) != {loop.pivot.first.coordinate, loop.pivot.second.coordinate}:
        return None
    return PivotDirection(loop, context.near)


def _three_spheres(block: Block, context: Context) -> Step | None:  # noqa: ARG001  one signature for all patterns
    distances = [e.loop for e in block.equations if isinstance(e.loop, Distance)]
    if len(distances) != 3 or len(block.equations) != 3:
        return None
    if not all(slides_only(d.target, block.unknowns) for d in distances):
        return None
    return ThreeSpheres(distances, block.unknowns)


_PATTERNS: tuple[Callable[[Block, Context], Step | None], ...] = (
    _planar_pin,
    _angle_sum,
    _relation,
    _one_distance,
    _direction,
    _three_spheres,
)
