"""Whether the given coordinates fit the loops: by structure if that decides, otherwise by rank."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..description.model import RobotDescription
from ..ground.wording import counted, singular_or_plural
from ..mechanism.configuration import configuration_at
from ..mechanism.tree import Tree
from .constraints.equations import Equation, LoopEquations, equations_of, loops_of
from .loop_gap import describe_gap
from .matching import Matching, match
from .numeric_closure import CLOSED
from .rank import CLOSED_NEARBY, MISFIT_MOVE, Ranked, rank_equations


def independent_equations(
    tree: Tree,
    robot: RobotDescription,
    loops: Sequence[LoopEquations],
    near: Mapping[int, float],
    unknowns: Sequence[int],
) -> tuple[list[Equation], list[Equation]]:
    """The independent equations, and the redundant ones.

    Args:
        tree: the spanning tree.
        robot: its description.
        loops: all equations.
        near: a configuration near which the loops close, by coordinate [rad or m].
        unknowns: the coordinates that are not given.

    Raises:
        DescriptionError: the given coordinates are too many, too few or the wrong ones, or the
            loops do not close.
    """
    equations = equations_of(loops)
    matching = match(equations, unknowns)
    if len(equations) < len(unknowns):
        problem = _wrong_count(tree, len(unknowns), len(equations), matching.undetermined)
        raise robot.error("active", problem + _untied_links(robot))
    require_determined(tree, robot, matching, len(equations), len(unknowns))
    if not matching.surplus:
        return equations, []
    start = [near.get(k, 0.0) for k in range(len(tree.coordinates))]
    ranked = rank_equations(tree, loops, start, unknowns)
    if ranked.rank is not None and ranked.rank > len(unknowns):
        problem = _wrong_count(tree, len(unknowns), ranked.rank)
        surplus = f": {_names(matching.surplus)} would be fixed more than once"
        raise robot.error("active", problem + surplus + _misfit(tree, robot, ranked))
    _require_movable(tree, robot, ranked, unknowns)
    if ranked.free:
        count = len(ranked.independent)
        problem = _wrong_count(tree, len(unknowns), count, ranked.free)
        raise robot.error("active", problem)
    return ranked.independent, ranked.redundant


def require_determined(
    tree: Tree, robot: RobotDescription, matching: Matching, equations: int, unknowns: int
) -> None:
    """Raise if the number of given coordinates is right, but the choice is wrong.

    Args:
        tree: the spanning tree.
        robot: its description.
        matching: matching of equations to unknowns.
        equations: number of equations.
        unknowns: number of unknowns.
    """
    if not matching.undetermined:
        return
    missing = unknowns - equations + len(matching.surplus)
    undetermined = ", ".join(tree.coordinates[k] for k in matching.undetermined)
    surplus = _names(matching.surplus)
    raise robot.error(
        "active",
        f"the loops do not determine {undetermined}, while {surplus} would be fixed more than once;"
        f" name {_some_of(tree, missing, matching.undetermined)} in place of"
        f" {_number(missing)} of {surplus}",
    )


def _require_movable(
    tree: Tree, robot: RobotDescription, ranked: Ranked, unknowns: Sequence[int]
) -> None:
    """Raise if the loops do not close, or close in one configuration only."""
    worst = max(ranked.residual, key=lambda name: ranked.residual[name])
    gap = describe_gap(tree, robot, worst, configuration_at(tree, ranked.closest))
    share = f"{ranked.residual[worst]:.2g} of the loop's length"
    if ranked.rigid:
        given = [name for k, name in enumerate(tree.coordinates) if k not in unknowns]
        raise robot.error(
            robot.closure_key(worst),
            f"closes at the reference, but not next to it: with {', '.join(given)} moved by"
            f" {MISFIT_MOVE:g}, {gap} ({share}; {CLOSED_NEARBY:g} is allowed). The loops are"
            " over-determined and lengths, axes or rounded numbers do not fit: give them with more"
            " digits, or leave out what follows from the other closures",
        )
    if ranked.residual[worst] > CLOSED:
        raise robot.error(
            robot.closure_key(worst),
            f"does not close: {gap} ({share}; {CLOSED:g} is allowed) where it comes nearest; mend"
            " the geometry, or give a reference nearer to a closed configuration",
        )


def _misfit(tree: Tree, robot: RobotDescription, ranked: Ranked) -> str:
    """Text on the largest residual: inexact lengths make redundant equations independent."""
    worst = max(ranked.residual, key=lambda name: ranked.residual[name])
    residual = ranked.residual[worst]
    if residual <= CLOSED_NEARBY:
        return ""
    gap = describe_gap(tree, robot, worst, configuration_at(tree, ranked.closest))
    at = f" with the given joints moved by {MISFIT_MOVE:g}" if ranked.rigid else ""
    return (
        f"; if they are to follow from each other, mend lengths and axes: of {worst}, {gap}{at}"
        f" ({residual:.2g} of the loop's length; {CLOSED_NEARBY:g} is allowed)"
    )


def _wrong_count(tree: Tree, unknowns: int, equations: int, free: Sequence[int] = ()) -> str:
    """Error text for a wrong number of active joints; `free` are candidates to be added."""
    joints = len(tree.coordinates)
    freedom = joints - equations
    independent = counted(equations, "independent loop equation")
    if freedom <= 0:
        hold = singular_or_plural(equations, "holds", "hold")
        return f"{independent} {hold} all {counted(joints, 'joint')} fast; nothing can move"
    named = joints - unknowns
    missing = ""
    if free and freedom > named:
        missing = f": besides those named, {_some_of(tree, freedom - named, free)}"
    return (
        f"{counted(named, 'joint')} {singular_or_plural(named, 'is', 'are')} named, but"
        f" {counted(joints, 'joint')} with {independent}"
        f" {singular_or_plural(joints, 'has', 'have')} {counted(freedom, 'degree')} of freedom;"
        f" name {freedom}{missing}"
    )


def _untied_links(robot: RobotDescription) -> str:
    """Text on links at the end of a chain, where a closure may be missing."""
    tied = {joint.parent for joint in robot.joints.values()}
    tied |= {frame.link for frame in robot.frames.values()}
    for closure in robot.closures:
        tied |= {closure.link_a, closure.link_b}
    untied = [joint.child for joint in robot.joints.values() if joint.child not in tied]
    if not untied:
        return ""
    names = ", ".join(f"'{name}'" for name in untied)
    return f"; or a loop is missing: nothing is tied to {names}"


def _some_of(tree: Tree, count: int, coordinates: Sequence[int]) -> str:
    names = ", ".join(tree.coordinates[k] for k in coordinates)
    if count == len(coordinates):
        return names
    return f"{_number(count)} of {names}"


def _number(count: int) -> str:
    if count == 1:
        return "one"
    return str(count)


def _names(equations: Sequence[Equation]) -> str:
    """Names of the loops of some equations."""
    return ", ".join(dict.fromkeys(loop.name for loop in loops_of(equations)))
