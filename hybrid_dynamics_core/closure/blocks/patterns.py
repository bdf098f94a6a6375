"""The choice of a solver for each block: closed forms in order, then Newton for all others.

A new closed form is a BlockSolver and one function here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ...description.model import Closure
from ...mechanism.tree import Tree
from ..constraints.angle_sum import AngleSum
from ..constraints.ball_cut import Orientation
from ..constraints.joint_coupling import JointCoupling
from ..constraints.leg import Direction, Distance
from ..constraints.parallelogram import PARALLELOGRAM
from ..constraints.planar import PlanarPin
from ..matching import EquationBlock
from .angle_sum import AngleBlock
from .block_solver import ONLY, BlockSolver
from .couplings import CouplingsBlock
from .dyad import dyad
from .joint_coupling import JointCouplingBlock
from .leg_blocks import BallJointBlock, CrankBlock, StrokeBlock, UniversalJointBlock
from .newton import NewtonBlock
from .three_spheres import ThreeSpheresBlock, slides_only


@dataclass(frozen=True)
class Context:
    """The data of a robot that the patterns read.

    Attributes:
        tree: its spanning tree.
        closures: its closures by name.
        near: values of the reference, by coordinate [rad, m].
        named: whether modes named in the file are used. True only if the given coordinates are the
            active ones.
    """

    tree: Tree
    closures: Mapping[str, Closure]
    near: Mapping[int, float]
    named: bool = True

    def revolute(self, coordinate: int) -> bool:
        """Whether a coordinate is an angle."""
        return self.tree.is_revolute(coordinate)


def solver_for(block: EquationBlock, context: Context) -> BlockSolver:
    """The solver of a block of equations."""
    if len(block.equations) == len(block.unknowns):
        for pattern in _PATTERNS:
            solver = pattern(block, context)
            if solver is not None:
                return solver
    involved = frozenset().union(*(equation.involved for equation in block.equations))
    revolute = {k: context.revolute(k) for k in involved}
    return NewtonBlock(block.equations, block.unknowns, revolute)


def _planar_pin(block: EquationBlock, context: Context) -> BlockSolver | None:
    pins = {equation.loop for equation in block.equations}
    if len(pins) != 1 or len(block.equations) != 2:
        return None
    pin = pins.pop()
    if not isinstance(pin, PlanarPin):
        return None
    joints = pin.geometry.joints
    first, second = (joint for joint in joints if joint.coordinate in block.unknowns)
    return dyad(pin, (first, second))


def _angle_sum(block: EquationBlock, context: Context) -> BlockSolver | None:
    loop = block.equations[0].loop
    if len(block.equations) != 1 or not isinstance(loop, AngleSum):
        return None
    (mode,) = ONLY
    if context.closures[loop.name].assembly == PARALLELOGRAM:
        mode = PARALLELOGRAM
    return AngleBlock(loop, block.unknowns[0], mode)


def _joint_coupling(block: EquationBlock, context: Context) -> BlockSolver | None:
    loop = block.equations[0].loop
    unknown = block.unknowns[0]
    if len(block.equations) != 1 or not isinstance(loop, JointCoupling):
        return None
    return JointCouplingBlock(loop, unknown, context.revolute(unknown))


def _couplings(block: EquationBlock, context: Context) -> BlockSolver | None:
    couplings: list[JointCoupling] = []
    for equation in block.equations:
        if not isinstance(equation.loop, JointCoupling):
            return None
        couplings.append(equation.loop)
    revolute = {k: context.revolute(k) for k in block.unknowns}
    try:
        return CouplingsBlock(couplings, block.unknowns, revolute)
    except ValueError:
        return None


def _one_distance(block: EquationBlock, context: Context) -> BlockSolver | None:
    loop = block.equations[0].loop
    unknown = block.unknowns[0]
    if len(block.equations) != 1 or not isinstance(loop, Distance):
        return None
    if context.revolute(unknown):
        return CrankBlock(loop, unknown)
    return StrokeBlock(loop, unknown)


def _direction(block: EquationBlock, context: Context) -> BlockSolver | None:
    loop = block.equations[0].loop
    if len(block.equations) != 2 or not isinstance(loop, Direction):
        return None
    if set(block.unknowns) != set(loop.pivot.coordinates):
        return None
    return UniversalJointBlock(loop)


def _orientation(block: EquationBlock, context: Context) -> BlockSolver | None:
    loop = block.equations[0].loop
    if len(block.equations) != 3 or not isinstance(loop, Orientation):
        return None
    if set(block.unknowns) != set(loop.ball.coordinates):
        return None
    return BallJointBlock(loop)


def _three_spheres(block: EquationBlock, context: Context) -> BlockSolver | None:
    distances = [e.loop for e in block.equations if isinstance(e.loop, Distance)]
    if len(distances) != 3 or len(block.equations) != 3:
        return None
    if not all(slides_only(distance.target, block.unknowns) for distance in distances):
        return None
    return ThreeSpheresBlock(distances, block.unknowns)


_PATTERNS: tuple[Callable[[EquationBlock, Context], BlockSolver | None], ...] = (
    _planar_pin,
    _angle_sum,
    _joint_coupling,
    _couplings,
    _one_distance,
    _direction,
    _orientation,
    _three_spheres,
)
