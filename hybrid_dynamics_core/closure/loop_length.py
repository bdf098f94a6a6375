"""Lengths of the mechanism that make loop equations dimensionless."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from ..algebra.independence import norm
from ..algebra.live import is_live
from ..algebra.scalar import Scalar
from ..description.model import RobotDescription
from ..mechanism.configuration import Configuration
from ..mechanism.tree import Tree
from .constraints.equations import LoopEquations
from .fixed_distances import FixedDistances

NO_LENGTH = 1e-9  # share of the longest loop below which a length is rounding
ROUNDING = 1e-12  # share of the farthest place in the file below which a length is rounding
Together = Sequence[Sequence[LoopEquations]]


def measure(
    tree: Tree,
    robot: RobotDescription,
    loops: Sequence[LoopEquations],
    together: Together,
    reference: Configuration,
) -> None:
    """Give each loop its length; loops that are solved together have one, the mean of theirs.

    It is the largest fixed distance of joints and pins of the loop. Where none of them has one, it
    is the first of these that there is: the largest between joints and pins of all loops, the
    longest stroke within limits of their slides, their largest extent at the reference, 1 m.

    Args:
        tree: the spanning tree.
        robot: its description.
        loops: the loops of a mechanism.
        together: those of them that are solved together, block by block.
        reference: a closed configuration, floats.
    """
    distances = FixedDistances(tree, robot)
    measurable = [loop for loop in loops if loop.has_length]
    groups = _joined(measurable, together)
    fixed = {loop.name: distances.largest([loop.name]) for loop in measurable}
    rounding = ROUNDING * _farthest(tree, robot)
    least = max(rounding, NO_LENGTH * max(fixed.values(), default=0.0))
    for group in groups:
        names = {loop.name for loop in group}
        lengths = [fixed[name] for name in names if fixed[name] > least]
        if lengths:
            length = _total(lengths) / len(lengths)
        else:
            length = _common_length(tree, distances, measurable, reference, rounding)
        for loop in group:
            loop.length = length


def _total(lengths: Sequence[Scalar]) -> Scalar:
    if is_live(lengths):
        return sum(lengths)
    return math.fsum(lengths)


def measured_at_reference(
    tree: Tree, robot: RobotDescription, loops: Sequence[LoopEquations]
) -> bool:
    """Whether the lengths of loops are those at the reference, for want of fixed ones."""
    measurable = [loop for loop in loops if loop.has_length]
    held = {k for loop in measurable for k in loop.coordinates}
    if not any(tree.is_revolute(k) for k in held):
        return False
    longest = max(FixedDistances(tree, robot).largest(), _longest_stroke(tree, measurable))
    return longest <= ROUNDING * _farthest(tree, robot)


def _farthest(tree: Tree, robot: RobotDescription) -> float:
    """The largest distance [m] in the file, whose rounding all lengths share."""
    places = [np.array(body.translation) for body in tree.bodies]
    for closure in robot.closures:
        places += [frame.translation for frame in closure.frames()]
    return max(map(norm, places), default=0.0)


def _joined(loops: Sequence[LoopEquations], together: Together) -> list[list[LoopEquations]]:
    """Groups of loops that share a block, or the closure whose equations they are."""
    groups: list[list[LoopEquations]] = []
    by_name: dict[str, list[LoopEquations]] = {}
    for loop in loops:
        by_name.setdefault(loop.name, []).append(loop)
    for block in (*together, *by_name.values()):
        joined = [loop for loop in block if loop in loops]
        apart: list[list[LoopEquations]] = []
        for group in groups:
            if any(loop in joined for loop in group):
                joined += [loop for loop in group if loop not in joined]
            else:
                apart.append(group)
        groups = [*apart, joined]
    return [group for group in groups if group]


def _common_length(
    tree: Tree,
    distances: FixedDistances,
    loops: Sequence[LoopEquations],
    reference: Configuration,
    least: float,
) -> float:
    """The length of loops that have none of their own [m], above a least one."""
    extent = max(loop.extent(reference) for loop in loops)
    for length in (distances.largest(), _longest_stroke(tree, loops), extent):
        if length > least:
            return length
    return 1.0


def _longest_stroke(tree: Tree, loops: Iterable[LoopEquations]) -> float:
    """The longest range between limits of the slides in loops [m]; 0 if none has limits."""
    held = {k for loop in loops for k in loop.coordinates}
    longest = 0.0
    for body in tree.bodies:
        lower, upper = body.limits
        if body.coordinate in held and not body.is_revolute and math.isfinite(upper - lower):
            longest = max(longest, upper - lower)
    return longest
