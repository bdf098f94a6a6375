"""The closure plan: the equations of all loops in blocks, each with its solver."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from ..algebra.scalar import Scalars
from ..description.model import RobotDescription
from ..errors import DescriptionError, UndecidedModeError
from ..mechanism.configuration import Configuration, given_configuration
from ..mechanism.tree import Tree
from .blocks.block_solver import BlockSolver
from .blocks.newton import NewtonBlock
from .blocks.patterns import Context, solver_for
from .branch import choose_branches
from .constraints.equations import Equation, LoopEquations, loops_of
from .constraints.from_description import loop_equations
from .degrees_of_freedom import independent_equations, require_determined
from .joined_equations import joined_blocks
from .loop_length import measure
from .matching import EquationBlock, match
from .numeric_closure import CLOSED
from .reference_search import closed_near


@dataclass(frozen=True)
class ClosurePlan:
    """The order in which all other coordinates are solved from the given ones.

    Attributes:
        given: the coordinates that are given.
        blocks: block solvers, in solving order.
        branch: the branch sign of each block, +1 or -1.
        reference: a closed configuration, floats.
        loops: the equations of all loops.
        redundant: equations that follow from the solved ones.
    """

    given: tuple[int, ...]
    blocks: tuple[BlockSolver, ...]
    branch: tuple[float, ...]
    reference: Configuration
    loops: tuple[LoopEquations, ...]
    redundant: tuple[Equation, ...]

    @property
    def signs(self) -> tuple[float, ...]:
        """Signs of the reference: `branch`, then the chart of each ball or free joint."""
        return (*self.branch, *map(float, self.reference.charts))

    @property
    def depends_on_turns(self) -> bool:
        """Whether a loop closes otherwise after a whole turn of a passive angle."""
        geared: set[int] = set()
        for block in self.blocks:
            if block.counted_turns.difference(self.given):
                geared.update(block.unknowns)
            elif geared.intersection(block.inputs):
                return True
        return False

    def split(self, signs: Scalars) -> tuple[Scalars, Scalars]:
        """Split signs into those of the blocks and the charts."""
        blocks = len(self.blocks)
        return signs[:blocks], signs[blocks:]


def build_plan(
    tree: Tree,
    robot: RobotDescription,
    given: Sequence[int] | None = None,
    near: Mapping[int, float] | None = None,
) -> ClosurePlan:
    """Plan the closure of every loop.

    Args:
        tree: the spanning tree.
        robot: its description.
        given: the given coordinates; None for the active ones.
        near: values by coordinate [rad or m] at which modes are chosen and iterations start; None
            for the reference of the description.

    Raises:
        DescriptionError: the loops do not fit the given coordinates, or do not close.
    """
    of_active = given is None
    if given is None:
        given = range(tree.n_active)
    if near is None:
        near = _reference(tree, robot)
    unknowns = [k for k in range(len(tree.coordinates)) if k not in given]
    loops = loop_equations(tree, robot, frozenset(unknowns))
    equations, redundant = independent_equations(tree, robot, loops, near, unknowns)
    matching = match(equations, unknowns)
    require_determined(tree, robot, matching, len(equations), len(unknowns))
    closures = {closure.name: closure for closure in robot.closures}
    problem = _Problem(robot, loops, tuple(given))
    context = Context(tree, closures, near, of_active)
    blocks = _solvers(matching.blocks, context)
    if redundant:
        is_exact = [not block.iterates for block in blocks]
        joined = joined_blocks(tree, loops, near, matching.blocks, redundant, is_exact)
        if any(block not in joined for block in _chosen(matching.blocks, is_exact)):
            context = problem.started(blocks, context)
        blocks = _solvers(joined, context)
    configuration, branch = problem.settled(blocks, context)
    together = [loops_of(block.equations) for block in blocks]
    measure(tree, robot, all_loops(loops, blocks), together, configuration)
    for block in blocks:
        if isinstance(block, NewtonBlock):
            block.choose_order(configuration)
    # a reference that differs from the file's has a note of its own
    if of_active and robot.active_set == "exact":
        _require_limits(tree, robot, configuration)
    return ClosurePlan(
        given=tuple(given),
        blocks=tuple(blocks),
        branch=tuple(branch),
        reference=configuration,
        loops=tuple(loops),
        redundant=tuple(redundant),
    )


@dataclass(frozen=True)
class _Problem:
    """The loops of a robot, and the coordinates that are given."""

    robot: RobotDescription
    loops: Sequence[LoopEquations]
    given: tuple[int, ...]

    def settled(
        self, blocks: Sequence[BlockSolver], context: Context
    ) -> tuple[Configuration, list[float]]:
        """The closed reference, and the branch sign of each block."""
        tree = context.tree
        coordinates = range(len(tree.coordinates))
        guess = [float(context.near.get(k, 0.0)) for k in coordinates]
        configuration = given_configuration(tree, {k: guess[k] for k in self.given})
        if any(block.iterates for block in blocks):
            unknowns = [k for k in coordinates if k not in self.given]
            guess = _closed_guess(tree, self.loops, guess, unknowns)
        branch = choose_branches(self.robot, blocks, self.loops, context, configuration, guess)
        return configuration, branch

    def started(self, blocks: Sequence[BlockSolver], context: Context) -> Context:
        """The context of iterations in place of closed forms, whose modes say where they start.

        Closed forms may be singular where all equations together are not.
        """
        try:
            configuration, _ = self.settled(blocks, context)
        except UndecidedModeError:
            raise
        except DescriptionError:
            if any(closure.assembly for closure in self.robot.closures):
                raise
            return context
        closed = dict(enumerate(map(float, configuration.q)))
        return replace(context, near=closed, named=False)


def _solvers(blocks: Sequence[EquationBlock], context: Context) -> list[BlockSolver]:
    return [solver_for(block, context) for block in blocks]


def _chosen(blocks: Sequence[EquationBlock], flags: Sequence[bool]) -> list[EquationBlock]:
    return [block for block, flag in zip(blocks, flags, strict=True) if flag]


def all_loops(loops: Sequence[LoopEquations], blocks: Sequence[BlockSolver]) -> list[LoopEquations]:
    """The loops of a plan, then those that occur only in its blocks."""
    result = list(loops)
    for block in blocks:
        result += loops_of(block.equations)
    return list(dict.fromkeys(result))


def _reference(tree: Tree, robot: RobotDescription) -> dict[int, float]:
    """The reference that the file names, by coordinate [rad or m]."""
    values: dict[int, float] = {}
    for k, name in enumerate(tree.coordinates):
        if name in robot.reference:
            values[k] = robot.reference[name]
    return values


def _closed_guess(
    tree: Tree, loops: Sequence[LoopEquations], guess: list[float], unknowns: Sequence[int]
) -> list[float]:
    """The start of iterations (n_s,): closed, if the loops can be closed."""
    closed = closed_near(tree, loops, guess, unknowns, driven_may_move=False)
    if closed.is_closed:
        return [float(q) for q in closed.s]
    return guess


def _require_limits(tree: Tree, robot: RobotDescription, configuration: Configuration) -> None:
    """Raise if a joint is beyond its limits at the reference."""
    for body in tree.bodies:
        value = float(configuration.q[body.coordinate])
        lower, upper = body.limits
        if lower - CLOSED <= value <= upper + CLOSED:
            continue
        raise robot.error(
            f"joints.{body.joint}",
            f"the loops close at the reference with {value:.6g}, outside [{lower:.6g},"
            f" {upper:.6g}]; mend the limits, the reference or the assembly mode",
        )
