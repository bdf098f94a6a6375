"""Records of passages, with the names of modes and the motions that branch off."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...ground.arrays import Array
from ...programs import Model
from ..assembly_modes import branch_names
from .branches import other_rates
from .crossing import PassageKind
from .record import Passage


class Passed(NamedTuple):
    """What is known of a passage.

    Attributes:
        kind: change point or toggle.
        blocks: indices of the singular blocks of the closure plan.
        s: all coordinates (n_s,) at the place [rad, m].
        rates: rates (n_s,) there.
        before: branch signs before the place.
        after: branch signs after it.
    """

    kind: PassageKind
    blocks: Sequence[int]
    s: Array
    rates: Array
    before: Array
    after: Array


def recorded(model: Model, passed: Passed, index: int | None = None) -> Passage:
    """The record of a passage.

    Args:
        model: tree and closure plan.
        passed: what is known of it.
        index: row of a path at which the place is reached.
    """
    plan = model.plan
    others: Mapping[int, Array] = {}
    if passed.kind is PassageKind.CHANGE_POINT:
        charts = passed.before[len(plan.blocks) :]
        others = other_rates(model, charts, passed.s, passed.rates)
    loops = [plan.blocks[k].name for k in passed.blocks]
    return Passage(
        kind=passed.kind.value,
        loops=tuple(dict.fromkeys(loops)),
        s=_numbers(passed.s),
        rates=_numbers(passed.rates),
        other_rates=tuple(_numbers(others[k]) for k in passed.blocks if k in others),
        before=modes_on(model, passed.before),
        after=modes_on(model, passed.after),
        index=index,
    )


def modes_on(model: Model, signs: Array) -> Mapping[str, str]:
    """Names of the assembly modes by loop on branch signs (blocks,)."""
    plan = model.plan
    names: list[str] = []
    # charts of ball and free joints may follow the signs of the blocks
    for block, sign in zip(plan.blocks, signs.tolist(), strict=False):
        names.append(block.modes[block.signs.index(sign)])
    return dict(branch_names(plan, names))


def _numbers(values: Array) -> tuple[float, ...]:
    numbers: list[float] = np.asarray(values, dtype=float).tolist()
    return tuple(numbers)
