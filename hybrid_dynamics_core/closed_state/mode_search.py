"""All assembly modes at a given input: in closed form, or by iterations from many starts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..algebra.scalar import Scalar
from ..certified.block_modes import certified_modes
from ..certified.setting import BlockModes, Setting
from ..closure.blocks.block_solver import BlockSolver
from ..closure.constraints.equations import loops_of
from ..closure.plan import ClosurePlan
from ..ground.arrays import Array
from ..ground.wording import counted, singular_or_plural
from ..mechanism.configuration import Configuration, given_configuration
from ..programs import Model, Outcome, OutcomeKind
from ..programs.model import SINGULAR
from .assembly_modes import NUMBERED, SAME, Completeness, branch_names

# first number of starts: several for each of the 40 modes that a Gough platform can have
STARTS = 600
MOST_STARTS = 9600  # the number is doubled up to this
NEAR = 1e-3  # share of places and orientations: an end this near to a solution is not another one
ENOUGH = 3  # a search counts as exhaustive if every solution was reached so often


class ModeSolution(NamedTuple):
    """One assembly mode of the whole robot, as numbers.

    Attributes:
        signs: branch sign of each block, +1 or -1, then the charts of ball and free joints.
        s: all coordinates (n_s,) [rad, m].
        names: name of the mode of each loop.
    """

    signs: Array
    s: Array
    names: Mapping[str, str]


class BlockSolution(NamedTuple):
    """One solution of a block: its branch sign, its mode, and the configuration with it."""

    sign: float
    mode: str
    configuration: Configuration


class Reached(NamedTuple):
    """Result of a search from many starts.

    Attributes:
        solutions: the distinct ones (modes, unknowns) [rad, m].
        counts: number of starts that reached each mode (modes,).
        starts: number of starts.
        nears_singular: whether a start came next to a closed configuration, yet to no end, as
            iterations do where two modes meet.
    """

    solutions: Array
    counts: NDArray[np.int64]
    starts: int
    nears_singular: bool

    @property
    def is_exhaustive(self) -> bool:
        """Whether each solution was reached often, so that another one is unlikely."""
        return bool((self.counts >= ENOUGH).all())


class ModeSearch:
    """Lists the assembly modes at u.

    Args:
        model: tree and closure plan.
        u: given coordinates (n,) [rad, m].
        signs: branch signs of the blocks that are not searched, then the charts of ball and free
            joints.
        start: all coordinates (n_s,) where iterations start [rad, m].
    """

    def __init__(self, model: Model, u: Array, signs: Array, start: Array) -> None:
        self._model = model
        self._signs = signs
        self._guess = start.tolist()
        self._evidence: dict[str, Reached] = {}
        self._proofs: dict[str, BlockModes] = {}
        self._singular: list[str] = []
        given = dict(zip(model.plan.given, u.tolist(), strict=True))
        _, charts = model.plan.split(signs.tolist())
        before = given_configuration(model.tree, given, charts)
        self.solutions = list(self._extended(before, []))

    def note_singular(self, loop: str) -> None:
        """Note that a mode is left out, since a loop is singular on it."""
        self._singular.append(loop)

    def note(self, code: int) -> None:
        """Note the status code of a solution's closed state."""
        outcome = Outcome.decode(code)
        if outcome.kind is OutcomeKind.SINGULAR:
            self.note_singular(self._model.plan.blocks[outcome.block].name)

    def verdict(self) -> tuple[Completeness, str]:
        """Whether the list is complete, and the reason."""
        completeness, reason = self._verdict_of_search()
        count = len(self._singular)
        if not count:
            return completeness, reason
        loops = ", ".join(dict.fromkeys(f"'{loop}'" for loop in self._singular))
        modes = f"{counted(count, 'mode')} {singular_or_plural(count, 'is', 'are')} left out"
        singular = f"nearer than {SINGULAR:g} to a singular place, loop {loops}"
        return Completeness.UNLIKELY, f"{modes}, {singular}; of the others: {reason}"

    def _verdict_of_search(self) -> tuple[Completeness, str]:
        """The verdict on the modes that are not singular."""
        proofs = [f"loop '{loop}': {proof.reason}" for loop, proof in self._proofs.items()]
        if not self._evidence and proofs:
            return Completeness.PROVEN, "; ".join(proofs)
        if not self._evidence:
            return Completeness.PROVEN, "every loop has a closed form, which has no other solution"
        completeness, reason = self._verdict_of_starts()
        return completeness, "; ".join([reason, *proofs])

    def _verdict_of_starts(self) -> tuple[Completeness, str]:
        """The verdict on the loops that were searched from random starts."""
        loop, least = min(self._evidence.items(), key=_least_count)
        starts = least.starts
        fewest = _least_count((loop, least))
        if not len(least.counts):
            reason = (
                f"loop '{loop}' is closed by iteration, and none of {starts} starts came to an end"
            )
            return Completeness.UNLIKELY, reason
        reached = f"loop '{loop}' is closed by iteration: of {starts} starts"
        if least.is_exhaustive:
            reason = f"{reached} {fewest} or more came to each mode; this is no proof"
            return Completeness.LIKELY, reason
        reason = f"{reached} only {fewest} came to one of the modes, so that others may be missing"
        return Completeness.UNLIKELY, reason

    def _extended(
        self, configuration: Configuration, solved: list[BlockSolution]
    ) -> Iterator[ModeSolution]:
        plan = self._model.plan
        k = len(solved)
        if k == len(plan.blocks):
            yield _mode_solution(plan, solved, configuration)
            return
        block, sign = plan.blocks[k], float(self._signs[k])
        for solution in self._solutions(block, configuration, sign):
            yield from self._extended(solution.configuration, [*solved, solution])

    def _solutions(
        self, block: BlockSolver, configuration: Configuration, sign: float
    ) -> Iterator[BlockSolution]:
        """All solutions of a block; a block that is not searched has the one on `sign`."""
        if block.iterates:
            yield from self._numbered_solutions(block, configuration)
            return
        signs = (sign,) if block.modes_fixed else block.signs
        for option in signs:
            trial = configuration.copy()
            try:
                margin = block.solve(trial, option, self._guess)
            except ZeroDivisionError:
                margin = 0.0
            if margin > 0.0:
                mode = block.modes[block.signs.index(option)]
                yield BlockSolution(option, mode, trial)
            elif not margin < -(SINGULAR**2):
                # rounding decides whether two modes meet here or there is none
                self.note_singular(block.name)

    def _numbered_solutions(
        self, block: BlockSolver, configuration: Configuration
    ) -> Iterator[BlockSolution]:
        """The distinct solutions of an iteration, the one nearest the guess first."""
        near = np.array([self._guess[k] for k in block.unknowns])
        plan, tree = self._model.plan, self._model.tree
        setting = Setting(tree, plan.given, configuration, self._guess)
        certified = certified_modes(block, setting)
        if certified is not None:
            self._note_proof(block.name, certified)
        if certified is not None and certified.complete:
            solutions = certified.solutions
        else:
            solutions = self._reached(block, configuration, certified)
        moves = [_wrapped(self._model, block, x - near) for x in solutions]
        moves.sort(key=lambda move: float(np.abs(move).max()))
        for number, move in enumerate(moves, start=1):
            mode = block.modes[0] if number == 1 else f"{NUMBERED}{number}"
            trial = _with_unknowns(self._model, block, configuration, near + move)
            yield BlockSolution(1.0, mode, trial)

    def _note_proof(self, loop: str, modes: BlockModes) -> None:
        """Keep what is known of a loop; what is not complete goes before what is."""
        earlier = self._proofs.get(loop)
        if earlier is None or earlier.complete:
            self._proofs[loop] = modes

    def _reached(
        self, block: BlockSolver, configuration: Configuration, certified: BlockModes | None
    ) -> Array:
        """Solutions (modes, unknowns) from random starts, and those that are certified."""
        reached = self._searched(block, configuration)
        worst = self._evidence.get(block.name)
        if worst is None or _least_count((block.name, reached)) < _least_count((block.name, worst)):
            self._evidence[block.name] = reached
        if reached.nears_singular:
            self.note_singular(block.name)
        if certified is None or not len(certified.solutions):
            return reached.solutions
        both = np.concatenate([reached.solutions, certified.solutions])
        marks = _fingerprints(self._model, block, configuration, both)
        apart = np.abs(marks[:, None] - marks).max(axis=2)
        repeated = np.tril(apart <= SAME, k=-1).any(axis=1)
        distinct: Array = both[~repeated]
        return distinct

    def _searched(self, block: BlockSolver, configuration: Configuration) -> Reached:
        """Search from more and more starts until each solution was reached often enough."""
        count = STARTS
        reached = self._from_starts(block, configuration, count)
        while not reached.is_exhaustive and count < MOST_STARTS:
            count = 2 * count
            reached = self._from_starts(block, configuration, count)
        return reached

    def _from_starts(self, block: BlockSolver, configuration: Configuration, count: int) -> Reached:
        starts = _starts(self._model, block, self._guess, count)
        trials = configuration.copy()
        converged = np.asarray(block.solve(trials, 1.0, starts)) > 0.0
        ends = np.stack([trials.q[k] for k in block.unknowns], axis=1)
        answers = ends[converged]
        marks = _fingerprints(self._model, block, configuration, answers)
        chosen: list[int] = []
        counts: list[int] = []
        remaining = np.arange(len(answers))
        while len(remaining):
            first = remaining[0]
            is_same = np.abs(marks[remaining] - marks[first]).max(axis=1) <= SAME
            chosen.append(int(first))
            counts.append(int(is_same.sum()))
            remaining = remaining[~is_same]
        closed = ends[~converged & (_gaps(block, trials) < SINGULAR**2)]
        others = _fingerprints(self._model, block, configuration, closed)
        apart = np.abs(others[:, None, :] - marks[chosen]).max(axis=2)
        nears_singular = bool((apart.min(axis=1, initial=np.inf) > NEAR).any())
        return Reached(answers[chosen], np.array(counts, dtype=np.int64), count, nears_singular)


def _least_count(entry: tuple[str, Reached]) -> int:
    _, reached = entry
    if not len(reached.counts):
        return 0
    return int(reached.counts.min())


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
    with_charts = np.array([*signs, *configuration.charts])
    return ModeSolution(with_charts, np.array(s), branch_names(plan, modes))


def _starts(
    model: Model,
    block: BlockSolver,
    guess: Sequence[float],
    count: int,
) -> list[Array]:
    """Start values of the iterations, one array a coordinate; the guess comes first."""
    from scipy.stats import qmc  # noqa: PLC0415  slow to import, and only this needs it

    reference = model.plan.reference
    length = max(equation.loop.reach(reference) for equation in block.equations)
    samples = qmc.Halton(len(block.unknowns), scramble=False).random(count)
    starts: list[Array] = [np.zeros(1 + count)] * len(guess)
    for k, sample in zip(block.unknowns, samples.T, strict=True):
        centre, span = guess[k], 1.5 * length
        if model.tree.is_revolute(k):
            centre, span = 0.0, np.pi
        points = centre + span * (2.0 * sample - 1.0)
        starts[k] = np.concatenate([[guess[k]], points])
    return starts


def _gaps(block: BlockSolver, trials: Configuration) -> Array:
    """The largest gap (N,) of each of N configurations of a block."""
    gaps: list[Array] = []
    with np.errstate(all="ignore"):  # the search may end anywhere
        for loop in loops_of(block.equations):
            residual = loop.linearise(trials).residual
            gaps += [np.abs(np.asarray(gap, dtype=float)) for gap in residual]
    largest: Array = np.max(np.broadcast_arrays(*gaps), axis=0)
    return largest


def _fingerprints(
    model: Model, block: BlockSolver, configuration: Configuration, answers: Array
) -> Array:
    """Poses of the links in the block's loops, one row for each row of unknowns.

    Two sets of angles that mean the same configuration have equal rows.
    """
    trials = _with_unknowns(model, block, configuration, answers.T)
    rows = len(answers)
    marks: list[Scalar] = []
    for loop in dict.fromkeys(equation.loop for equation in block.equations):
        marks += loop.marks(trials)
    columns = [np.broadcast_to(np.asarray(mark, dtype=float), rows) for mark in marks]
    return np.stack(columns, axis=1)


def _with_unknowns(
    model: Model, block: BlockSolver, configuration: Configuration, x: Array
) -> Configuration:
    """A copy of the configuration in which the unknowns of a block are set to x."""
    result = configuration.copy()
    for k, value in zip(block.unknowns, x, strict=True):
        result.set_value(k, value, revolute=model.tree.is_revolute(k))
    return result


def _wrapped(model: Model, block: BlockSolver, difference: Array) -> Array:
    """A difference of the unknowns, reduced by whole turns where angles are free to turn."""
    counted = block.counted_turns
    may_turn = [model.tree.is_revolute(k) and k not in counted for k in block.unknowns]
    wrapped = np.remainder(difference + np.pi, 2.0 * np.pi) - np.pi
    return np.where(may_turn, wrapped, difference)
