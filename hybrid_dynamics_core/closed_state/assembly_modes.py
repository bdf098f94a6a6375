"""Assembly modes: their names and signs, and all of them at a given input."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from ..closure.blocks.block_solver import BlockSolver
from ..closure.plan import ClosurePlan
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.suggestions import no_such_name, suggestion
from ..mechanism.configuration import Configuration, configuration_at, given_configuration
from ..programs import Model
from .state import ClosedState

Found = tuple[Array, Array, Mapping[str, str]]  # branch signs, configuration s, mode names
# of a Newton block: several for each of the modes a platform can have (40 for a Gough platform)
STARTS = 600
SAME = 1e-6  # [rad or m] solutions nearer than this are one


@dataclass(frozen=True, eq=False)
class AssemblyMode:
    """One way in which the loops close: `branch` names the mode of each loop, `state` is closed on it."""

    branch: Mapping[str, str]
    state: ClosedState


def mode_of(modes: Sequence[AssemblyMode], state: ClosedState) -> int | None:
    """Which of the modes a closed state is; None where it is none of them."""
    apart = [float(np.abs(np.sin(0.5 * (mode.state.s - state.s))).max()) for mode in modes]
    return int(np.argmin(apart)) if apart and min(apart) < SAME else None


def branch_names(plan: ClosurePlan, modes: Sequence[str]) -> Mapping[str, str]:
    """The mode of each loop from the mode of each step; joined by + where a loop closes in several steps."""
    names: dict[str, list[str]] = {}
    for step, mode in zip(plan.blocks, modes, strict=True):
        parts = names.setdefault(step.name, [])
        if mode not in parts:
            parts.append(mode)
    return MappingProxyType({loop: "+".join(parts) for loop, parts in names.items()})


def mode_names(plan: ClosurePlan) -> Mapping[str, tuple[str, ...]]:
    """The modes that each loop can have; loops that close by iteration, whose modes have only numbers, are left out."""
    numbered = {step.name for step in plan.blocks if step.iterates}
    loops = dict.fromkeys(step.name for step in plan.blocks)
    return MappingProxyType({loop: _modes_of(plan, loop) for loop in loops if loop not in numbered})


def no_mode(loop: str, mode: str, known: Sequence[str]) -> str:
    """That a loop has no mode of this name, and what may have been meant."""
    return f"loop '{loop}' has no mode '{mode}'{suggestion(mode, known)}; known: {', '.join(known)}"


def _modes_of(plan: ClosurePlan, loop: str) -> tuple[str, ...]:
    return tuple(
        dict.fromkeys(mode for step in plan.blocks if step.name == loop for mode in step.modes)
    )


def signs_of_names(plan: ClosurePlan, signs: Array, branch: Mapping[str, str]) -> Array:
    """The branch signs with some modes replaced by name; of a joined name a part is enough.

    InputError for a loop or mode that does not exist.
    """
    if not isinstance(branch, Mapping):
        raise InputError(f"branch: expected assembly modes by loop name, got {branch!r}")
    result = np.array(signs)
    loops = list(dict.fromkeys(step.name for step in plan.blocks))
    for loop, name in branch.items():
        if loop not in loops:
            raise InputError(f"branch: {no_such_name('loop', loop, loops)}")
        steps = {k: step.modes for k, step in enumerate(plan.blocks) if step.name == loop}
        for mode in name.split("+"):
            having = {k: modes.index(mode) for k, modes in steps.items() if mode in modes}
            if not having:
                raise InputError(f"branch: {no_mode(loop, mode, _modes_of(plan, loop))}")
            for k, index in having.items():
                result[k] = 1.0 - 2.0 * index
    return result


def matching_signs(model: Model, s: Array) -> Array:
    """The branch signs on which a plan gives the closed configuration s (n_s,)."""
    exact = configuration_at(model.tree, s)
    signs = []
    for step in model.plan.blocks:
        options = step.signs
        signs.append(min(options, key=lambda sign, step=step: _miss(step, exact, sign, s)))  # type: ignore[misc]
    return np.array(signs)


def _miss(step: BlockSolver, exact: Configuration, sign: float, s: Array) -> float:
    trial = exact.copy()
    try:
        margin = step.solve(trial, sign, s.tolist())
    except ZeroDivisionError:
        return np.inf
    miss = sum(abs(float(trial.q[k]) - float(s[k])) for k in step.unknowns)
    return miss if margin > -SAME and np.isfinite(miss) else np.inf


def list_modes(model: Model, u: Array, signs: Array, start: Array) -> Iterator[Found]:
    """Every way to close at u: branch signs, configuration s and mode names."""
    guess = start.tolist()

    def extend(
        k: int, configuration: Configuration, chosen: list[float], names: list[str]
    ) -> Iterator[Found]:
        if k == len(model.plan.blocks):
            s = np.array([float(q) for q in configuration.q])
            yield np.array(chosen), s, branch_names(model.plan, names)
            return
        for sign, name, closed in _solutions(model, k, configuration, float(signs[k]), guess):
            yield from extend(k + 1, closed, [*chosen, sign], [*names, name])

    yield from extend(
        0,
        given_configuration(model.tree, dict(zip(model.plan.given, u.tolist(), strict=True))),
        [],
        [],
    )


def _solutions(
    model: Model, k: int, configuration: Configuration, own: float, guess: Sequence[float]
) -> Iterator[tuple[float, str, Configuration]]:
    step = model.plan.blocks[k]
    if step.iterates:
        yield from _newton_solutions(model, step, configuration, guess)
        return
    options = [own] if step.modes_fixed else list(step.signs)
    for sign in options:
        trial = configuration.copy()
        try:
            margin = step.solve(trial, sign, guess)
        except ZeroDivisionError:
            continue
        if margin > 0.0:
            yield sign, step.modes[0 if sign > 0 else 1], trial


def _newton_solutions(
    model: Model, step: BlockSolver, configuration: Configuration, guess: Sequence[float]
) -> Iterator[tuple[float, str, Configuration]]:
    """Newton from many starts at once; distinct answers, the one nearest the reference first."""
    found = _many_starts(model, step, configuration, guess)
    near = np.array([guess[k] for k in step.unknowns])
    found.sort(key=lambda x: float(np.abs(_wrapped(model, step, x - near)).max()))
    number = 1
    for x in found:
        trial = configuration.copy()
        for coordinate, value in zip(
            step.unknowns, near + _wrapped(model, step, x - near), strict=True
        ):
            put = trial.set_angle if model.tree.is_revolute(coordinate) else trial.set_length
            put(coordinate, float(value))
        yield 1.0, step.modes[0] if number == 1 else f"mode_{number}", trial
        number += 1


def _many_starts(
    model: Model, step: BlockSolver, configuration: Configuration, guess: Sequence[float]
) -> list[Array]:
    from scipy.stats import qmc  # noqa: PLC0415  slow to import, and only this needs it

    length = max(equation.loop.length for equation in step.equations)
    spans = np.array([np.pi if model.tree.is_revolute(k) else 1.5 * length for k in step.unknowns])
    centre = np.array([0.0 if model.tree.is_revolute(k) else guess[k] for k in step.unknowns])
    points = centre + spans * (2.0 * qmc.Halton(len(spans), scramble=False).random(STARTS) - 1.0)
    points = np.vstack([[guess[k] for k in step.unknowns], points])
    starts: list[Array] = [np.zeros(len(points))] * len(guess)
    for column, k in enumerate(step.unknowns):
        starts[k] = points[:, column]
    many = configuration.copy()
    converged = np.asarray(step.solve(many, 1.0, starts)) > 0.0
    answers = np.stack([many.q[k] for k in step.unknowns], axis=1)[converged]
    kept: list[Array] = []
    poses: list[Array] = []
    for x in answers:
        pose = _fingerprint(model, step, configuration, x)
        if all(np.abs(pose - other).max() > SAME for other in poses):
            kept.append(x)
            poses.append(pose)
    return kept


def _fingerprint(model: Model, step: BlockSolver, configuration: Configuration, x: Array) -> Array:
    """Where the block's loops put their links: equal for two sets of angles that mean the same configuration."""
    trial = configuration.copy()
    for k, value in zip(step.unknowns, x, strict=True):
        put = trial.set_angle if model.tree.is_revolute(k) else trial.set_length
        put(k, float(value))
    marks = [
        mark for loop in dict.fromkeys(e.loop for e in step.equations) for mark in loop.marks(trial)
    ]
    return np.array([float(m) for m in marks])


def _wrapped(model: Model, step: BlockSolver, difference: Array) -> Array:
    turn = np.array([model.tree.is_revolute(k) for k in step.unknowns])
    return np.where(turn, np.remainder(difference + np.pi, 2.0 * np.pi) - np.pi, difference)
