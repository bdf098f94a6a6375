"""From the closures of a description to equations."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

from ...description.model import Closure, RobotDescription
from ...mechanism.tree import Tree
from .ball_cut import cut_at_ball
from .closure_place import placed
from .equations import LoopEquations
from .joint_coupling import JointCoupling
from .leg import Direction, Distance, find_pivot
from .parallelogram import PARALLELOGRAM, parallelogram_equations
from .planar import PlanarPin
from .planar_loops import planar_equations
from .spatial import Chain, SpatialClosure, closure_chains

Chains = tuple[Chain, Chain]


def loop_equations(
    tree: Tree, robot: RobotDescription, unknowns: frozenset[int]
) -> list[LoopEquations]:
    """Every closure and every follower as equations.

    Args:
        tree: the spanning tree.
        robot: its description.
        unknowns: coordinates to solve for. Equations of legs are split to suit them.

    Returns:
        Equations of the closures, then of the joints that follow others.

    Raises:
        DescriptionError: a closure is not of the kind that the file says.
    """
    closures = [placed(tree, robot, closure) for closure in robot.closures]
    chains = {closure.name: closure_chains(tree, closure) for closure in closures}
    private = _in_one_loop(chains.values()) & unknowns
    loops: list[LoopEquations] = []
    for closure in closures:
        try:
            equations = planar_equations(tree, closure)
        except ValueError as error:
            if closure.kind == "planar":
                raise robot.error(robot.closure_key(closure.name), str(error)) from error
            equations = _spatial(closure, chains[closure.name], private)
        if closure.assembly == PARALLELOGRAM:
            loops += _as_parallelogram(robot, closure, equations)
        else:
            loops += equations
    return loops + [_follower(tree, robot, name) for name in robot.mimics]


def _in_one_loop(chains: Iterable[Chains]) -> frozenset[int]:
    """Coordinates that belong to one loop only."""
    loops = Counter[int]()
    for a, b in chains:
        loops.update(a.coordinates | b.coordinates)
    return frozenset(k for k, count in loops.items() if count == 1)


def _as_parallelogram(
    robot: RobotDescription, closure: Closure, equations: Sequence[LoopEquations]
) -> Sequence[LoopEquations]:
    """The linear equations of a parallelogram in place of the pin's."""
    pin = equations[0]
    key = f"{robot.closure_key(closure.name)}.assembly"
    if not isinstance(pin, PlanarPin) or len(equations) > 1:
        raise robot.error(key, "is not a parallelogram: it is not a planar loop closed by a pin")
    try:
        return parallelogram_equations(pin)
    except ValueError as error:
        raise robot.error(key, f"is not a parallelogram: {error}") from error


def _spatial(closure: Closure, chains: Chains, private: frozenset[int]) -> list[LoopEquations]:
    """The equations of a spatial loop, split at a ball joint or at a leg on a universal joint."""
    if closure.kind == "point":
        return _meeting(closure.name, chains, private)
    if closure.kind == "frame":
        cut = cut_at_ball(closure.name, chains, private)
        if cut is not None:
            return [*_meeting(closure.name, cut.ends, private), cut.orientation]
    first, second = chains
    return [SpatialClosure(closure.name, closure.kind, first, second)]


def _meeting(name: str, chains: Chains, private: frozenset[int]) -> list[LoopEquations]:
    """The equations of two ends that meet in a point."""
    first, second = chains
    for leg, target in ((first, second), (second, first)):
        pivot = find_pivot(leg, private)
        if pivot is not None:
            distance = Distance(name, pivot, target)
            return [distance, Direction(name, pivot, leg, target)]
    return [SpatialClosure(name, "point", first, second)]


def _follower(tree: Tree, robot: RobotDescription, name: str) -> JointCoupling:
    mimic = robot.mimics[name]
    coefficients = {tree.coordinates.index(name): 1.0}
    for source, multiplier in mimic.multipliers.items():
        coefficients[tree.coordinates.index(source)] = -multiplier
    return JointCoupling(name, coefficients, -mimic.offset)
