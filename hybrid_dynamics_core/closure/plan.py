"""The order in which loops close: their equations in block-triangular form, each block with the step that solves it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..algebra.scalar import Scalar
from ..description.model import Closure, RobotDescription
from ..mechanism.tree import Tree
from .branch import choose_branch
from .equations import Equation, LoopEquations
from .leg import Direction, Distance, find_pivot
from .matching import match
from .parallelogram import PARALLELOGRAM, parallelogram_equations
from .patterns import Context, make_step
from .planar import PlanarPin, planar_equations
from .posture import Posture
from .rank import rank_equations
from .spatial import Chain, SpatialClosure, closure_chains
from .step import Step

CLOSED = 1e-6  # residual, in lengths of the loop, up to which a reference counts as closed


@dataclass(frozen=True)
class ClosurePlan:
    """How the rest follows from the given coordinates.

    `steps` in solving order; `branch`: the sign (+1, -1) of each; `reference`: a closed posture (floats);
    `loops`: all equations; `redundant`: those that follow from the others; `idle`: coordinates no loop holds.
    """

    given: tuple[int, ...]
    steps: tuple[Step, ...]
    branch: tuple[float, ...]
    reference: Posture
    loops: tuple[LoopEquations, ...]
    redundant: tuple[Equation, ...]


def build_plan(
    tree: Tree, robot: RobotDescription, given: Sequence[int] | None = None, near: Mapping[int, float] | None = None
) -> ClosurePlan:
    """Plan the closure of every loop from the given coordinates (the active ones if None).

    `near`: a configuration from which modes are read and iterations start (the description's reference if None).
    Raises DescriptionError where the loops do not fit the given coordinates or do not close.
    """
    named = given is None
    given = tuple(range(tree.n_active)) if given is None else tuple(given)
    if near is None:
        near = {k: robot.reference[name] for k, name in enumerate(tree.coordinates) if name in robot.reference}
    unknowns = [k for k in range(len(tree.coordinates)) if k not in given]
    loops = _all_equations(tree, robot, frozenset(unknowns))
    equations, redundant = _independent(tree, robot, loops, near, unknowns)
    matching = match(equations, unknowns)
    if matching.undetermined:
        names = ", ".join(tree.coordinates[k] for k in matching.undetermined)
        raise robot.error("active", f"the loops do not determine {names}; choose other active joints")
    context = Context(tree, {c.name: c for c in robot.closures}, near, named)
    guess = [float(near.get(k, 0.0)) for k in range(len(tree.coordinates))]
    posture = given_posture(tree, {k: guess[k] for k in given})
    steps, branch = [], []
    for block in matching.blocks:
        steps.append(make_step(block, context))
        branch.append(choose_branch(robot, steps[-1], context, posture, guess))
    _check_closed(robot, loops, posture)
    return ClosurePlan(given, tuple(steps), tuple(branch), posture, tuple(loops), tuple(redundant))


def given_posture(tree: Tree, values: Mapping[int, Scalar]) -> Posture:
    """A posture with some coordinates set; any scalar type."""
    posture = Posture(len(tree.coordinates))
    for body in tree.bodies:
        if body.coordinate in values:
            put = posture.set_angle if body.type == "revolute" else posture.set_length
            put(body.coordinate, values[body.coordinate])
    return posture


def _all_equations(tree: Tree, robot: RobotDescription, unknowns: frozenset[int]) -> list[LoopEquations]:
    """Every closure as equations, in the form that splits best."""
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
                raise robot.error(_key(robot, closure.name), str(error)) from error
            equations = _spatial(closure, chains[closure.name], private)
        loops += _as_parallelogram(robot, closure, equations) if closure.assembly == PARALLELOGRAM else equations
    return loops


def _as_parallelogram(
    robot: RobotDescription, closure: Closure, equations: Sequence[LoopEquations]
) -> Sequence[LoopEquations]:
    """The claim of the file, as linear equations in place of the pin's."""
    pin, key = equations[0], f"{_key(robot, closure.name)}.assembly"
    if not isinstance(pin, PlanarPin) or len(equations) > 1:
        raise robot.error(key, "is not a parallelogram: it is not a planar loop closed by a pin")
    try:
        return parallelogram_equations(pin)
    except ValueError as error:
        raise robot.error(key, f"is not a parallelogram: {error}") from error


def _spatial(closure: Closure, chains: tuple[Chain, Chain], private: frozenset[int]) -> list[LoopEquations]:
    if closure.kind == "point":
        for leg, target in (chains, chains[::-1]):
            pivot = find_pivot(leg, private)
            if pivot is not None:
                return [Distance(closure.name, pivot, target), Direction(closure.name, pivot, leg, target)]
    return [SpatialClosure(closure.name, closure.kind, *chains)]


def _independent(
    tree: Tree,
    robot: RobotDescription,
    loops: Sequence[LoopEquations],
    near: Mapping[int, float],
    unknowns: Sequence[int],
) -> tuple[list[Equation], list[Equation]]:
    """Equations to solve, and those that follow from them: by count where that is enough, otherwise by rank."""
    equations = [Equation(loop, k) for loop in loops for k in range(loop.size)]
    if len(equations) < len(unknowns):
        raise robot.error("active", _wrong_count(tree, len(unknowns), len(equations)))
    matching = match(equations, unknowns)
    if matching.undetermined:
        free = ", ".join(tree.coordinates[k] for k in matching.undetermined)
        held = ", ".join(dict.fromkeys(e.loop.name for e in matching.surplus))
        also = f", while {held} would be fixed more than once" if held else ""
        raise robot.error("active", f"the loops do not determine {free}{also}; choose other active joints")
    if not matching.surplus:
        return equations, []
    ranked = rank_equations(tree, loops, [near.get(k, 0.0) for k in range(len(tree.coordinates))], unknowns)
    worst = max(ranked.residual, key=lambda name: ranked.residual[name])
    if ranked.residual[worst] > CLOSED:
        raise robot.error(
            _key(robot, worst),
            f"does not close: {ranked.residual[worst]:.2g} of its length is left open; mend the geometry, "
            "or give a reference nearer to a closed configuration",
        )
    if ranked.idle:
        raise robot.error("active", _wrong_count(tree, len(unknowns), len(ranked.independent)))
    return ranked.independent, ranked.redundant


def _wrong_count(tree: Tree, unknowns: int, equations: int) -> str:
    freedom = len(tree.coordinates) - equations
    return (
        f"{len(tree.coordinates) - unknowns} joints are named, but {len(tree.coordinates)} joints with {equations} "
        f"independent loop equations have {freedom} degrees of freedom; name {freedom}"
    )


def _check_closed(robot: RobotDescription, loops: Sequence[LoopEquations], posture: Posture) -> None:
    for loop in loops:
        error = max(abs(float(r)) for r in loop.linearise(posture).residual)
        flipped = any(not float(g) > 0.0 for g in loop.guards(posture))
        if not error < CLOSED or flipped:
            size = f"{error:.2g} of its length is left open" if not flipped else "its frames face opposite ways"
            raise robot.error(
                _key(robot, loop.name), f"does not close at the reference: {size}; mend geometry or reference"
            )


def _key(robot: RobotDescription, name: str) -> str:
    return f"loops.{name}" if name in robot.loops else f"closures.{name}"
