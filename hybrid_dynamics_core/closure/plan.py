"""The order in which loops close: their equations in block-triangular form, each block with the step that solves it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..description.model import RobotDescription
from ..ground.wording import counted, singular_or_plural
from ..mechanism.configuration import Configuration, configuration_at, given_configuration
from ..mechanism.tree import Tree
from .blocks.block_solver import BlockSolver
from .blocks.patterns import Context, solver_for
from .branch import choose_branch
from .constraints.equations import Equation, LoopEquations
from .constraints.from_description import loop_equations
from .loop_gap import gap_of
from .matching import Matching, match
from .rank import CLOSED, close_numerically, rank_equations


@dataclass(frozen=True)
class ClosurePlan:
    """How all other coordinates follow from the given ones.

    Attributes:
        given: the coordinates that are given.
        blocks: what solves for the others, in solving order.
        branch: the branch sign of each block, +1 or -1.
        reference: a closed configuration, floats.
        loops: the equations of all loops.
        redundant: equations that follow from the others.
    """

    given: tuple[int, ...]
    blocks: tuple[BlockSolver, ...]
    branch: tuple[float, ...]
    reference: Configuration
    loops: tuple[LoopEquations, ...]
    redundant: tuple[Equation, ...]


def build_plan(
    tree: Tree,
    robot: RobotDescription,
    given: Sequence[int] | None = None,
    near: Mapping[int, float] | None = None,
) -> ClosurePlan:
    """Plan the closure of every loop from the given coordinates (the active ones if None).

    `near`: a configuration from which modes are read and iterations start (the description's
    reference if None). Raises DescriptionError where the loops do not fit the given coordinates or
    do not close.
    """
    named = given is None
    given = tuple(range(tree.n_active)) if given is None else tuple(given)
    if near is None:
        near = {
            k: robot.reference[name]
            for k, name in enumerate(tree.coordinates)
            if name in robot.reference
        }
    unknowns = [k for k in range(len(tree.coordinates)) if k not in given]
    loops = loop_equations(tree, robot, frozenset(unknowns))
    equations, redundant = _independent(tree, robot, loops, near, unknowns)
    matching = match(equations, unknowns)
    if matching.undetermined:
        raise robot.error("active", _undetermined(tree, matching, len(equations), len(unknowns)))
    context = Context(tree, {c.name: c for c in robot.closures}, near, named)
    guess = [float(near.get(k, 0.0)) for k in range(len(tree.coordinates))]
    configuration = given_configuration(tree, {k: guess[k] for k in given})
    blocks = [solver_for(block, context) for block in matching.blocks]
    # iterations start where everything is closed already
    if any(block.iterates for block in blocks):
        closed, residual = close_numerically(tree, loops, guess, unknowns)
        if max(residual.values()) < CLOSED:
            guess = closed.tolist()
    branch = [choose_branch(robot, block, context, configuration, guess) for block in blocks]
    _check_closed(tree, robot, loops, configuration)
    if (
        named and robot.active_set == "exact"
    ):  # else the reference is not the file's: a note tells of it
        _check_limits(tree, robot, configuration)
    return ClosurePlan(
        given, tuple(blocks), tuple(branch), configuration, tuple(loops), tuple(redundant)
    )


def _independent(
    tree: Tree,
    robot: RobotDescription,
    loops: Sequence[LoopEquations],
    near: Mapping[int, float],
    unknowns: Sequence[int],
) -> tuple[list[Equation], list[Equation]]:
    """Equations to solve, and those that follow from them: by count where that is enough, otherwise by rank."""
    equations = [Equation(loop, k) for loop in loops for k in range(loop.size)]
    matching = match(equations, unknowns)
    if len(equations) < len(unknowns):
        problem = _wrong_count(tree, len(unknowns), len(equations), matching.undetermined)
        raise robot.error("active", problem + _loose_ends(robot))
    if matching.undetermined:
        raise robot.error("active", _undetermined(tree, matching, len(equations), len(unknowns)))
    if not matching.surplus:
        return equations, []
    ranked = rank_equations(
        tree, loops, [near.get(k, 0.0) for k in range(len(tree.coordinates))], unknowns
    )
    if ranked.rank is not None and ranked.rank > len(unknowns):
        held = f": {_loops_of(matching.surplus)} would be fixed more than once"
        raise robot.error("active", _wrong_count(tree, len(unknowns), ranked.rank) + held)
    worst = max(ranked.residual, key=lambda name: ranked.residual[name])
    if ranked.residual[worst] > CLOSED:
        raise robot.error(
            robot.closure_key(worst),
            f"does not close: {gap_of(tree, robot, worst, configuration_at(tree, ranked.closest))}"
            f" ({ranked.residual[worst]:.2g} of the loop's length) where it comes nearest; mend the"
            " geometry, or give a reference nearer to a closed configuration",
        )
    if ranked.rigid:
        problem = (
            "close at the reference, but not next to it: over-determined, the mechanism cannot move"
        )
        raise robot.error("closures" if "closures" in robot.lines else "loops", problem)
    if ranked.idle:
        raise robot.error(
            "active", _wrong_count(tree, len(unknowns), len(ranked.independent), ranked.idle)
        )
    return ranked.independent, ranked.redundant


def _wrong_count(tree: Tree, unknowns: int, equations: int, free: Sequence[int] = ()) -> str:
    """What is wrong with the number of active joints; `free`: coordinates that are left to be named."""
    freedom = len(tree.coordinates) - equations
    if freedom <= 0:
        return (
            f"{counted(equations, 'independent loop equation')}"
            f" {singular_or_plural(equations, 'holds', 'hold')} all {counted(len(tree.coordinates), 'joint')}"
            " fast; nothing can move"
        )
    named, joints = len(tree.coordinates) - unknowns, len(tree.coordinates)
    missing = (
        f": besides those named, {_some_of(tree, freedom - named, free)}"
        if free and freedom > named
        else ""
    )
    return (
        f"{counted(named, 'joint')} {singular_or_plural(named, 'is', 'are')} named, but"
        f" {counted(joints, 'joint')} with {counted(equations, 'independent loop equation')}"
        f" {singular_or_plural(joints, 'has', 'have')} {counted(freedom, 'degree')} of freedom; name"
        f" {freedom}{missing}"
    )


def _loose_ends(robot: RobotDescription) -> str:
    """Links that carry nothing and that no loop ties: one of them may belong to a loop that was forgotten."""
    carrying = {joint.parent for joint in robot.joints.values()} | {
        frame.link for frame in robot.frames.values()
    }
    tied = {link for closure in robot.closures for link in (closure.link_a, closure.link_b)}
    loose = [joint.child for joint in robot.joints.values() if joint.child not in carrying | tied]
    names = ", ".join(f"'{name}'" for name in loose)
    return f"; or a loop is missing: nothing is tied to {names}" if loose else ""


def _undetermined(tree: Tree, matching: Matching, equations: int, unknowns: int) -> str:
    """What is wrong where the number of active joints is right, but not which they are."""
    missing = unknowns - equations + len(matching.surplus)
    names = ", ".join(tree.coordinates[k] for k in matching.undetermined)
    held = _loops_of(matching.surplus)
    return (
        f"the loops do not determine {names}, while {held} would be fixed more than once; name"
        f" {_some_of(tree, missing, matching.undetermined)} in place of"
        f" {'one' if missing == 1 else missing} of {held}"
    )


def _some_of(tree: Tree, count: int, coordinates: Sequence[int]) -> str:
    names = [tree.coordinates[k] for k in coordinates]
    return (
        ", ".join(names)
        if count == len(names)
        else f"{'one' if count == 1 else count} of {', '.join(names)}"
    )


def _loops_of(equations: Sequence[Equation]) -> str:
    return ", ".join(dict.fromkeys(equation.loop.name for equation in equations))


def _check_closed(
    tree: Tree,
    robot: RobotDescription,
    loops: Sequence[LoopEquations],
    configuration: Configuration,
) -> None:
    for loop in loops:
        error = max(abs(float(r)) for r in loop.linearise(configuration).residual)
        flipped = any(not float(g) > 0.0 for g in loop.guards(configuration))
        if not error < CLOSED or flipped:
            gap = f"{gap_of(tree, robot, loop.name, configuration)} ({error:.2g} of the loop's length)"
            size = gap if not flipped else "its frames face opposite ways"
            raise robot.error(
                robot.closure_key(loop.name),
                f"does not close at the reference: {size}; mend geometry or reference",
            )


def _check_limits(tree: Tree, robot: RobotDescription, configuration: Configuration) -> None:
    for body in tree.bodies:
        value, (lower, upper) = float(configuration.q[body.coordinate]), body.limits
        if not lower - CLOSED <= value <= upper + CLOSED:
            problem = (
                f"the loops close at the reference with {value:.6g}, outside [{lower:.6g},"
                f" {upper:.6g}]"
            )
            raise robot.error(
                f"joints.{body.joint}",
                f"{problem}; mend the limits, the reference or the assembly mode",
            )
