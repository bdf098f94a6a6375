"""From the closures of a description to equations."""

from __future__ import annotations

from collections.abc import Sequence

from ...description.model import Closure, RobotDescription
from ...mechanism.tree import Tree
from .equations import LoopEquations
from .joint_coupling import JointCoupling
from .leg import Direction, Distance, find_pivot
from .parallelogram import PARALLELOGRAM, parallelogram_equations
from .planar import PlanarPin, planar_equations
from .spatial import Chain, SpatialClosure, closure_chains


def loop_equations(
    tree: Tree, robot: RobotDescription, unknowns: frozenset[int]
) -> list[LoopEquations]:
    """Every closure and every follower as equations, in the form that splits best for the unknown coordinates."""
    seen: dict[int, int] = {}
    chains = {c.name: closure_chains(tree, c) for c in robot.closures}
    for a, b in chains.values():
        for k in a.coordinates | b.coordinates:
            seen[k] = seen.get(k, 0) + 1
    private = frozenset(k for k, count in seen.items() if count == 1) & unknowns
    loops: list[LoopEquations] = []
    for closure in robot.closures:
        try:
            equations = planar_equations(tree, closure)
        except ValueError as error:
            if closure.kind == "planar":
                raise robot.error(robot.closure_key(closure.name), str(error)) from error
            equations = _spatial(closure, chains[closure.name], private)
        loops += (
            _as_parallelogram(robot, closure, equations)
            if closure.assembly == PARALLELOGRAM
            else equations
        )
    return loops + [_follower(tree, robot, name) for name in robot.mimics]


def _as_parallelogram(
    robot: RobotDescription, closure: Closure, equations: Sequence[LoopEquations]
) -> Sequence[LoopEquations]:
    """The claim of the file, as linear equations in place of the pin's."""
    pin, key = equations[0], f"{robot.closure_key(closure.name)}.assembly"
    if not isinstance(pin, PlanarPin) or len(equations) > 1:
        raise robot.error(key, "is not a parallelogram: it is not a planar loop closed by a pin")
    try:
        return parallelogram_equations(pin)
    except ValueError as error:
        raise robot.error(key, f"is not a parallelogram: {error}") from error


def _spatial(
    closure: Closure, chains: tuple[Chain, Chain], private: frozenset[int]
) -> list[LoopEquations]:
    if closure.kind == "point":
        for leg, target in (chains, chains[::-1]):
            pivot = find_pivot(leg, private)
            if pivot is not None:
                return [
                    Distance(closure.name, pivot, target),
                    Direction(closure.name, pivot, leg, target),
                ]
    return [SpatialClosure(closure.name, closure.kind, *chains)]


def _follower(tree: Tree, robot: RobotDescription, name: str) -> JointCoupling:
    mimic = robot.mimics[name]
    own, source = tree.coordinates.index(name), tree.coordinates.index(mimic.source)
    return JointCoupling(name, {own: 1.0, source: -mimic.multiplier}, -mimic.offset)
