"""Assembly modes: their names and branch signs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType

import numpy as np

from ..closure.blocks.block_solver import BlockSolver
from ..closure.plan import ClosurePlan
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.suggestions import no_such_name, suggestion
from ..mechanism.configuration import Configuration, configuration_at
from ..programs import Model
from .state import ClosedState

NUMBERED = "mode_"  # prefix of further modes of a loop that closes by iteration
SAME = 1e-6  # [rad or m] solutions closer than this are the same


@dataclass(frozen=True, eq=False)
class AssemblyMode:
    """One way in which the loops close.

    Attributes:
        branch: name of the mode of each loop.
        state: closed state on these modes.
    """

    branch: Mapping[str, str]
    state: ClosedState


class Completeness(Enum):
    """Whether a list of assembly modes holds all of them."""

    PROVEN = "proven"
    LIKELY = "likely"
    UNLIKELY = "unlikely"


class AssemblyModes(tuple[AssemblyMode, ...]):  # noqa: SLOT001  a tuple takes none
    """The tuple of assembly modes at one input, and whether it is complete.

    Attributes:
        completeness: `PROVEN` if every loop has a closed form, or its list was proved to be
            complete; else `LIKELY` or `UNLIKELY`. Always `UNLIKELY` if a mode was left out, since a
            loop is singular on it.
        reason: why, in a sentence; of a search, what was searched.
    """

    completeness: Completeness
    reason: str

    def __new__(
        cls, modes: Iterable[AssemblyMode], completeness: Completeness, reason: str
    ) -> AssemblyModes:
        """Make the tuple and set its attributes."""
        self = super().__new__(cls, modes)
        self.completeness = completeness
        self.reason = reason
        return self

    @property
    def complete(self) -> bool:
        """Whether the list was proved to hold all modes."""
        return self.completeness is Completeness.PROVEN


def mode_of(modes: Sequence[AssemblyMode], state: ClosedState) -> int | None:
    """Index of the mode of a closed state; None if it is none of them."""
    nearest, least = None, SAME
    for k, mode in enumerate(modes):
        halves = np.sin(0.5 * (mode.state.s - state.s))
        distance = float(np.abs(halves).max(initial=0.0))
        if distance < least:
            nearest, least = k, distance
    return nearest


# -- names


def branch_names(plan: ClosurePlan, modes: Sequence[str]) -> Mapping[str, str]:
    """The mode of each loop, joined by + if a loop closes in several blocks.

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
    """An error text: a loop has no mode of this name; close names are suggested."""
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
    """Branch signs with some modes replaced by name.

    Args:
        plan: closure plan.
        signs: branch signs (blocks,) of the other modes.
        branch: modes by loop name. Of a name joined by +, one part is enough.

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
        if not isinstance(names, str):
            raise InputError(f"branch: expected the name of a mode of loop '{loop}', got {names!r}")
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
    iterates = any(block.name == loop and block.iterates for block in plan.blocks)
    if not exists and iterates and mode.startswith(NUMBERED):
        raise InputError(
            f"branch: '{mode}' of loop '{loop}' is a number in one list of assembly_modes, not a"
            " name; give close(u, near=mode.state) with an entry of that list"
        )
    if not exists:
        raise InputError(f"branch: {no_such_mode(loop, mode, _modes_of(plan, loop))}")


def matching_signs(model: Model, s: Array, charts: Array) -> Array:
    """The branch signs of the closed configuration s (n_s,) in given charts."""
    closed = configuration_at(model.tree, s, charts)
    signs = []
    for block in model.plan.blocks:
        options = block.signs
        errors = [_error_on(block, closed, sign, s) for sign in options]
        signs.append(options[errors.index(min(errors))])
    return np.array([*signs, *charts])


def _error_on(
    block: BlockSolver,
    closed: Configuration,
    sign: float,
    s: Array,
) -> float:
    """Distance of a block's solution on a branch sign from the closed configuration s [rad, m]."""
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
