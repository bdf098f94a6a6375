"""Choice of assembly modes: the named one or, without a name, the one nearest the reference."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import product

from ..description.model import RobotDescription
from ..errors import UndecidedModeError
from ..mechanism.configuration import Configuration, configuration_at
from .blocks.block_solver import BlockSolver
from .blocks.patterns import Context
from .constraints.equations import LoopEquations
from .loop_gap import describe_gap, describe_least_gap
from .numeric_closure import CLOSED

MOST_MODES = 64  # combinations of modes that are tried to find a loop that closes in none


def choose_branches(
    robot: RobotDescription,
    blocks: Sequence[BlockSolver],
    loops: Sequence[LoopEquations],
    context: Context,
    configuration: Configuration,
    guess: Sequence[float],
) -> list[float]:
    """Choose the branch sign of every block and solve all of them at the reference.

    Args:
        robot: its description, for error texts.
        blocks: the blocks in solving order.
        loops: the equations of all loops.
        context: tree, closures and reference of the robot.
        configuration: the reference, with the given coordinates set. All others are set on return.
        guess: start of the iterations, all coordinates s (n_s,) [rad, m].

    Returns:
        The branch signs, +1 or -1.

    Raises:
        UndecidedModeError: a loop closes in several modes, and the file names none.
        DescriptionError: a loop has no such mode, is singular or does not close. This comes first,
            where no mode of the undecided loops lets it close.
    """
    branch: list[float] = []
    try:
        # each block is solved into `configuration`, for the blocks after it
        for block in blocks:
            sign = choose_branch(robot, block, context, configuration, guess)
            branch.append(sign)
    except UndecidedModeError:
        later = blocks[len(branch) :]
        if not _closes_in_some_mode(robot, later, loops, context, configuration, guess):
            for block in later:
                _choose_nearest(robot, block, context, configuration, guess)
            _require_closed(robot, loops, context, configuration)
        raise
    _require_closed(robot, loops, context, configuration)
    return branch


def _closes_in_some_mode(
    robot: RobotDescription,
    blocks: Sequence[BlockSolver],
    loops: Sequence[LoopEquations],
    context: Context,
    configuration: Configuration,
    guess: Sequence[float],
) -> bool:
    """Whether all loops close in some modes of the blocks; taken to be so for very many modes."""
    modes = [_named_signs(robot, block, context) or list(block.signs) for block in blocks]
    if math.prod(map(len, modes)) > MOST_MODES:
        return True
    for signs in product(*modes):
        margins = (
            _solve_margin(block, configuration, sign, _start_of(block, context, guess))
            for block, sign in zip(blocks, signs, strict=True)
        )
        if all(margin > 0.0 for margin in margins) and not any(
            _is_open(loop, configuration) for loop in loops
        ):
            return True
    return False


def choose_branch(
    robot: RobotDescription,
    block: BlockSolver,
    context: Context,
    configuration: Configuration,
    guess: Sequence[float],
) -> float:
    """Choose the branch sign of a block and solve the block at the reference.

    Args:
        robot: its description, for error texts.
        block: the block.
        context: tree, closures and reference of the robot.
        configuration: the reference, with all coordinates before the block set. Its unknowns are
            set on return.
        guess: start of the iterations, all coordinates s (n_s,) [rad, m].

    Returns:
        The branch sign, +1 or -1.

    Raises:
        UndecidedModeError: the loop closes in several modes, and the file names none.
        DescriptionError: the loop has no such mode, is singular or does not close.
    """
    given = [k for k in block.unknowns if k in context.near]
    signs = _named_signs(robot, block, context) or list(block.signs)
    if len(signs) > 1 and block.needs_mode and not given:
        start = _start_of(block, context, guess)
        _require_decided(robot, block, context, configuration, start)
    return _choose_nearest(robot, block, context, configuration, guess)


def _choose_nearest(
    robot: RobotDescription,
    block: BlockSolver,
    context: Context,
    configuration: Configuration,
    guess: Sequence[float],
) -> float:
    """The named branch sign, or the one nearest the reference, and the block solved on it.

    Raises:
        DescriptionError: the loop has no such mode, is singular or does not close.
    """
    start = _start_of(block, context, guess)
    given = [k for k in block.unknowns if k in context.near]
    signs = _named_signs(robot, block, context) or list(block.signs)
    wanted = {k: guess[k] for k in given or block.unknowns}
    distances = [_distance(block, configuration, sign, start, wanted) for sign in signs]
    nearest = signs[distances.index(min(distances))]
    if not _solve_margin(block, configuration, nearest, start) > 0.0:
        problem = _open_problem(block, context, configuration, guess)
        raise robot.error(robot.closure_key(block.loops[0]), problem)
    return nearest


def _start_of(block: BlockSolver, context: Context, guess: Sequence[float]) -> Sequence[float]:
    """The start of a block; of a closed form the file's values, which keeps their whole turns."""
    if block.iterates:
        return guess
    result = list(guess)
    for k in block.unknowns:
        result[k] = context.near.get(k, 0.0)
    return result


def _solve_margin(
    block: BlockSolver, configuration: Configuration, sign: float, guess: Sequence[float]
) -> float:
    """Solve a block, set its unknowns in the configuration, and return the margin or NaN."""
    try:
        return float(block.solve(configuration, sign, guess))
    except ZeroDivisionError:  # a pin exactly on a pivot
        return math.nan


def _distance(
    block: BlockSolver,
    configuration: Configuration,
    sign: float,
    start: Sequence[float],
    wanted: Mapping[int, float],
) -> float:
    """Distance from a solution to the coordinates `wanted`; inf if there is no solution."""
    if not _solve_margin(block, configuration, sign, start) > 0.0:
        return math.inf
    return sum(abs(float(configuration.q[k]) - value) for k, value in wanted.items())


def _open_problem(
    block: BlockSolver, context: Context, configuration: Configuration, guess: Sequence[float]
) -> str:
    """Error text for a block that has no solution at the reference."""
    if _is_closed(block, context, guess):
        return (
            "is singular at the reference configuration: what is given does not hold it there;"
            " give other joints, or another reference"
        )
    gap = describe_least_gap(context.tree, context.closures, block, configuration)
    if gap:
        gap = f": {gap}"
    return (
        f"does not close at the reference configuration{gap}; mend the geometry or give a reference"
        " that closes"
    )


def _is_closed(block: BlockSolver, context: Context, guess: Sequence[float]) -> bool:
    """Whether the block is closed at the guess."""
    configuration = configuration_at(context.tree, guess)
    residuals: list[float] = []
    for loop in dict.fromkeys(equation.loop for equation in block.equations):
        residuals += [abs(float(r)) for r in loop.linearise(configuration).residual]
    return max(residuals) < CLOSED


def _named_signs(
    robot: RobotDescription, block: BlockSolver, context: Context
) -> list[float] | None:
    """The sign of the mode named in the file; None if there is none."""
    if not context.named or len(block.loops) != 1:
        return None
    (loop,) = block.loops
    closure = context.closures.get(loop)
    if closure is None or closure.assembly is None:
        return None
    if closure.assembly not in block.modes:
        raise robot.error(
            f"{robot.closure_key(loop)}.assembly",
            f"is '{closure.assembly}'; this loop has {' and '.join(block.modes)}",
        )
    return [block.signs[block.modes.index(closure.assembly)]]


def _require_decided(
    robot: RobotDescription,
    block: BlockSolver,
    context: Context,
    configuration: Configuration,
    guess: Sequence[float],
) -> None:
    """Raise if a loop closes in several modes; the error gives the joint values of each."""
    tree = context.tree
    joints_of: dict[str, str] = {}
    for sign, mode in zip(block.signs, block.modes, strict=True):
        if _solve_margin(block, configuration, sign, guess) > 0.0:
            joints = [tree.value_text(k, configuration.q[k], digits=4) for k in block.unknowns]
            joints_of[mode] = ", ".join(joints)
    if len(joints_of) < 2:
        return
    text = " or ".join(f"{mode} ({joints})" for mode, joints in joints_of.items())
    problem = (
        f"closes in more than one way: {text}; name one as assembly, or give its joints in"
        " reference"
    )
    error = robot.error(robot.closure_key(block.loops[0]), problem)
    raise UndecidedModeError(error, loop=block.loops[0], modes=tuple(joints_of))


def _is_open(loop: LoopEquations, configuration: Configuration) -> bool:
    """Whether a loop is open, or its frames face in opposite directions."""
    return not _residual(loop, configuration) < CLOSED or _is_opposed(loop, configuration)


def _residual(loop: LoopEquations, configuration: Configuration) -> float:
    """The largest residual of a loop."""
    residual = loop.linearise(configuration).residual
    return max(abs(float(r)) for r in residual)


def _is_opposed(loop: LoopEquations, configuration: Configuration) -> bool:
    """Whether frames that a loop ties face in opposite directions."""
    return any(not float(guard) > 0.0 for guard in loop.guards(configuration))


def _require_closed(
    robot: RobotDescription,
    loops: Sequence[LoopEquations],
    context: Context,
    configuration: Configuration,
) -> None:
    """Raise if a loop is open at the reference."""
    for loop in loops:
        if not _is_open(loop, configuration):
            continue
        problem = "its frames face in opposite directions"
        if not _is_opposed(loop, configuration):
            gap = describe_gap(context.tree, robot, loop.name, configuration)
            error = _residual(loop, configuration)
            problem = f"{gap} ({error:.2g} of the loop's length; {CLOSED:g} is allowed)"
        raise robot.error(
            robot.closure_key(loop.name),
            f"does not close at the reference: {problem}; mend geometry or reference",
        )
