"""Choice of assembly modes: the one the file names or, without a name, the one nearest the reference."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..description.model import RobotDescription
from ..errors import UndecidedModeError
from ..mechanism.configuration import Configuration
from .blocks.block_solver import Step
from .blocks.parallelogram import AngleStep
from .blocks.patterns import Context
from .loop_gap import shortfall
from .rank import CLOSED, posture_of


def choose_branch(
    robot: RobotDescription,
    step: Step,
    context: Context,
    configuration: Configuration,
    guess: Sequence[float],
) -> float:
    """The branch sign of a step; leaves the step solved at the reference configuration."""
    told = [k for k in step.unknowns if k in context.near]
    signs = _named(robot, step, context) or [1.0, -1.0][: len(step.modes)]
    if len(signs) > 1 and step.needs_mode and not told:
        _refuse_undecided(robot, step, context, configuration, guess)

    def distance(sign: float) -> float:
        if not _margin(step, configuration, sign, guess) > 0.0:
            return math.inf
        return sum(abs(float(configuration.q[k]) - guess[k]) for k in told or step.unknowns)

    best = min(signs, key=distance)
    if not _margin(step, configuration, best, guess) > 0.0:
        if _closed(step, context, guess):
            problem = (
                "is singular at the reference configuration: what is given does not hold it there;"
                " give other joints, or another reference"
            )
        else:
            gap = shortfall(context.tree, context.closures, step, configuration)
            problem = f"does not close at the reference configuration{': ' if gap else ''}{gap}; "
            problem += "mend the geometry or give a reference that closes"
        raise robot.error(robot.closure_key(step.loops[0]), problem)
    if isinstance(step, AngleStep):
        step.near(configuration, context.near)
        step.solve(configuration, best, guess)
    return best


def _closed(step: Step, context: Context, guess: Sequence[float]) -> bool:
    """Whether the block is closed at the guess."""
    configuration = posture_of(context.tree, guess)
    loops = dict.fromkeys(equation.loop for equation in step.equations)
    return (
        max(abs(float(r)) for loop in loops for r in loop.linearise(configuration).residual)
        < CLOSED
    )


def _margin(step: Step, configuration: Configuration, sign: float, guess: Sequence[float]) -> float:
    try:
        return float(step.solve(configuration, sign, guess))
    except ZeroDivisionError:  # a pin exactly on a pivot
        return math.nan


def _named(robot: RobotDescription, step: Step, context: Context) -> list[float] | None:
    """The sign of the mode that the file names; None where it names none."""
    closure = (
        context.closures.get(step.loops[0]) if context.named and len(step.loops) == 1 else None
    )
    if closure is None or closure.assembly is None:
        return None
    if closure.assembly not in step.modes:
        raise robot.error(
            f"{robot.closure_key(step.loops[0])}.assembly",
            f"is '{closure.assembly}'; this loop has {' and '.join(step.modes)}",
        )
    return [1.0, -1.0][step.modes.index(closure.assembly) :][:1]


def _refuse_undecided(
    robot: RobotDescription,
    step: Step,
    context: Context,
    configuration: Configuration,
    guess: Sequence[float],
) -> None:
    """Raise where a loop closes in more than one way, with the joints of each; return where it closes in none."""
    tree, found = context.tree, {}
    for sign, mode in zip((1.0, -1.0), step.modes, strict=False):
        if _margin(step, configuration, sign, guess) > 0.0:
            joints = (
                f"{tree.coordinates[k]} = {float(configuration.q[k]):.4g} {tree.unit(k)}"
                for k in step.unknowns
            )
            found[mode] = ", ".join(joints)
    if found:
        ways = " or ".join(f"{mode} ({joints})" for mode, joints in found.items())
        problem = (
            f"closes in more than one way: {ways}; name one as assembly, or give its joints in"
            " reference"
        )
        error = robot.error(robot.closure_key(step.loops[0]), problem)
        raise UndecidedModeError(error, loop=step.loops[0], modes=tuple(found))
