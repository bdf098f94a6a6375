"""Assembly modes: their names and branch signs, and all of them at a given input."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ..closure.blocks.block_solver import BlockSolver
from ..closure.plan import ClosurePlan
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.suggestions import no_such_name, suggestion
from ..mechanism.configuration import Configuration, configuration_at, given_configuration
from ..programs import Model
from .state import ClosedState

# of a block closed by iteration: several for each of the modes a platform can have (40 for a Gough
# platform)
STARTS = 600
SAME = 1e-6  # [rad or m] solutions nearer than this are one


@dataclass(frozen=True, eq=False)
class AssemblyMode:
    """One way in which the loops close.

    Attributes:
        branch: name of the mode of each loop.
        state: closed state on these modes.
    """

    branch: Mapping[str, str]
    state: ClosedState


class ModeSolution(NamedTuple):
    """One way in which the loops close, as numbers.

    Attributes:
        signs: branch sign (blocks,) of each block, +1 or -1.
        s: all coordinates (n_s,) [rad, m].
        names: name of the mode of each loop.
    """

    signs: Array
    s: Array
    names: Mapping[str, str]


class BlockSolution(NamedTuple):
    """One way in which a block closes: its branch sign, its mode, and the configuration with it."""

    sign: float
    mode: str
    configuration: Configuration


def mode_of(modes: Sequence[AssemblyMode], state: ClosedState) -> int | None:
    """Index of the mode that a closed state is on; None where it is on none of them."""
    nearest, least = None, SAME
    for k, mode in enumerate(modes):
        halves = np.sin(0.5 * (mode.state.s - state.s))
        distance = float(np.abs(halves).max())
        if distance < least:
            nearest, least = k, distance
    return nearest


# -- names


def branch_names(plan: ClosurePlan, modes: Sequence[str]) -> Mapping[str, str]:
    """The mode of each loop, joined by + where a loop closes in several blocks.

    Args:
        plan: closure plan.
        modes: mode of each block.
    """
    names: dict[str, list[str]] = {}
    for block, mode in zip(plan.blocks, modes, strict=True):
        parts = names.setdefault(block.name, [])
        if mode not in parts:
            parts.append(mode)
    joined = {loop: "+".join(parts) for loop, parts in names.items()}
    return MappingProxyType(joined)


def mode_names(plan: ClosurePlan) -> Mapping[str, tuple[str, ...]]:
    """The modes that each loop can have.

    Loops that close by iteration are left out: their modes have only numbers.
    """
    modes = {block.name: _modes_of(plan, block.name) for block in plan.blocks}
    for block in plan.blocks:
        if block.iterates:
            modes.pop(block.name, None)
    return MappingProxyType(modes)


def no_such_mode(loop: str, mode: str, modes: Sequence[str]) -> str:
    """That a loop has no mode of this name, and what may have been meant."""
    return f"loop '{loop}' has no mode '{mode}'{suggestion(mode, modes)}; known: {', '.join(modes)}"


def _modes_of(plan: ClosurePlan, loop: str) -> tuple[str, ...]:
    modes: list[str] = []
    for block in plan.blocks:
        if block.name == loop:
            modes += block.modes
    return tuple(dict.fromkeys(modes))


# -- signs


def signs_of_names(
    plan: ClosurePlan,
    signs: Array,
    branch: Mapping[str, str],
) -> Array:
    """Branch signs with some modes replaced by name; of a joined name a part is enough.

    Args:
        plan: closure plan.
        signs: branch signs (blocks,) to begin with.
        branch: modes by loop name.

    Returns:
        Branch signs (blocks,).

    Raises:
        InputError: there is no such loop or mode.
    """
    if not isinstance(branch, Mapping):
        raise InputError(f"branch: expected assembly modes by loop name, got {branch!r}")
    result = np.array(signs)
    loops = list(dict.fromkeys(block.name for block in plan.blocks))
    for loop, names in branch.items():
        if loop not in loops:
            raise InputError(f"branch: {no_such_name('loop', loop, loops)}")
        for mode in names.split("+"):
            _set_mode(plan, result, loop, mode)
    return result


def _set_mode(
    plan: ClosurePlan,
    signs: Array,
    loop: str,
    mode: str,
) -> None:
    """Set the sign of every block of a loop that has this mode."""
    exists = False
    for k, block in enumerate(plan.blocks):
        if block.name == loop and mode in block.modes:
            signs[k] = block.signs[block.modes.index(mode)]
            exists = True
    if not exists:
        raise InputError(f"branch: {no_such_mode(loop, mode, _modes_of(plan, loop))}")


def matching_signs(model: Model, s: Array) -> Array:
    """The branch signs (blocks,) on which a plan gives the closed configuration s (n_s,)."""
    closed = configuration_at(model.tree, s)
    signs = []
    for block in model.plan.blocks:
        options = block.signs
        errors = [_error_on(block, closed, sign, s) for sign in options]
        signs.append(options[errors.index(min(errors))])
    return np.array(signs)


def _error_on(
    block: BlockSolver,
    closed: Configuration,
    sign: float,
    s: Array,
) -> float:
    """How far a block's solution on a sign is from the closed configuration s [rad, m]."""
    trial = closed.copy()
    try:
        margin = block.solve(trial, sign, s.tolist())
    except ZeroDivisionError:
        return np.inf
    error = 0.0
    for k in block.unknowns:
        error += abs(float(trial.q[k]) - float(s[k]))
    if margin > -SAME and np.isfinite(error):
        return error
    return np.inf


# -- all modes


def list_modes(
    model: Model,
    u: Array,
    signs: Array,
    start: Array,
) -> Iterator[ModeSolution]:
    """Every way to close at u.

    Args:
        model: tree and closure plan.
        u: given coordinates (n,) [rad, m].
        signs: branch signs (blocks,) of blocks whose mode is not looked for.
        start: all coordinates (n_s,) where iterations start [rad, m].
    """
    guess = start.tolist()

    def extend(configuration: Configuration, solved: list[BlockSolution]) -> Iterator[ModeSolution]:
        k = len(solved)
        if k == len(model.plan.blocks):
            yield _mode_solution(model.plan, solved, configuration)
            return
        block, sign = model.plan.blocks[k], float(signs[k])
        for solution in _solutions(model, block, configuration, sign, guess):
            yield from extend(solution.configuration, [*solved, solution])

    given = dict(zip(model.plan.given, u.tolist(), strict=True))
    yield from extend(given_configuration(model.tree, given), [])


def _mode_solution(
    plan: ClosurePlan,
    solved: Sequence[BlockSolution],
    configuration: Configuration,
) -> ModeSolution:
    """The solutions of all blocks as one."""
    signs, modes = [], []
    for solution in solved:
        signs.append(solution.sign)
        modes.append(solution.mode)
    s = [float(q) for q in configuration.q]
    return ModeSolution(np.array(signs), np.array(s), branch_names(plan, modes))


def _solutions(
    model: Model,
    block: BlockSolver,
    configuration: Configuration,
    sign: float,
    guess: Sequence[float],
) -> Iterator[BlockSolution]:
    """Every way in which a block closes; `sign` is that of a block whose mode is not looked for."""
    if block.iterates:
        yield from _numbered_solutions(model, block, configuration, guess)
        return
    signs = (sign,) if block.modes_fixed else block.signs
    for option in signs:
        trial = configuration.copy()
        try:
            margin = block.solve(trial, option, guess)
        except ZeroDivisionError:
            continue
        if margin > 0.0:
            mode = block.modes[block.signs.index(option)]
            yield BlockSolution(option, mode, trial)


def _numbered_solutions(
    model: Model, block: BlockSolver, configuration: Configuration, guess: Sequence[float]
) -> Iterator[BlockSolution]:
    """The distinct solutions of an iteration from many starts, the one nearest the guess first."""
    near = np.array([guess[k] for k in block.unknowns])
    starts = _starts(model, block, guess)
    solutions = _distinct_solutions(model, block, configuration, starts)
    moves = [_wrapped(model, block, x - near) for x in solutions]
    moves.sort(key=lambda move: float(np.abs(move).max()))
    for number, move in enumerate(moves, start=1):
        mode = block.modes[0] if number == 1 else f"mode_{number}"
        yield BlockSolution(1.0, mode, _with_unknowns(model, block, configuration, near + move))


def _starts(
    model: Model,
    block: BlockSolver,
    guess: Sequence[float],
) -> list[Array]:
    """Where iterations start: for every coordinate its values, the guess first."""
    from scipy.stats import qmc  # noqa: PLC0415  slow to import, and only this needs it

    length = max(equation.loop.length for equation in block.equations)
    samples = qmc.Halton(len(block.unknowns), scramble=False).random(STARTS)
    starts: list[Array] = [np.zeros(1 + STARTS)] * len(guess)
    for k, sample in zip(block.unknowns, samples.T, strict=True):
        centre, span = guess[k], 1.5 * length
        if model.tree.is_revolute(k):
            centre, span = 0.0, np.pi
        points = centre + span * (2.0 * sample - 1.0)
        starts[k] = np.concatenate([[guess[k]], points])
    return starts


def _distinct_solutions(
    model: Model, block: BlockSolver, configuration: Configuration, starts: Sequence[Array]
) -> list[Array]:
    """The unknowns of a block at each of its solutions that some start leads to."""
    trials = configuration.copy()
    converged = np.asarray(block.solve(trials, 1.0, starts)) > 0.0
    answers = np.stack([trials.q[k] for k in block.unknowns], axis=1)
    solutions: list[Array] = []
    fingerprints: list[Array] = []
    for x in answers[converged]:
        fingerprint = _fingerprint(model, block, configuration, x)
        if not _is_among(fingerprint, fingerprints):
            solutions.append(x)
            fingerprints.append(fingerprint)
    return solutions


def _is_among(fingerprint: Array, others: Sequence[Array]) -> bool:
    """Whether some other fingerprint is the same."""
    return any(np.abs(fingerprint - other).max() <= SAME for other in others)


def _fingerprint(
    model: Model,
    block: BlockSolver,
    configuration: Configuration,
    x: Array,
) -> Array:
    """Where the block's loops put their links.

    It is equal for two sets of angles that mean the same configuration.
    """
    trial = _with_unknowns(model, block, configuration, x)
    marks = []
    for loop in dict.fromkeys(equation.loop for equation in block.equations):
        marks += loop.marks(trial)
    return np.array([float(mark) for mark in marks])


def _with_unknowns(
    model: Model, block: BlockSolver, configuration: Configuration, x: Array
) -> Configuration:
    """The configuration with the unknowns of a block set to x."""
    result = configuration.copy()
    for k, value in zip(block.unknowns, x, strict=True):
        result.set_value(k, float(value), revolute=model.tree.is_revolute(k))
    return result


def _wrapped(model: Model, block: BlockSolver, difference: Array) -> Array:
    """A difference of the unknowns, without whole turns of angles that may turn."""
    counted = block.counted_turns
    may_turn = [model.tree.is_revolute(k) and k not in counted for k in block.unknowns]
    wrapped = np.remainder(difference + np.pi, 2.0 * np.pi) - np.pi
    return np.where(may_turn, wrapped, difference)
