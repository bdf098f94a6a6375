"""The status of a computed state: an integer in kernels, an `Outcome` in messages.

A kernel reports one integer for each state. Zero is success. Positive codes belong to a block of
the closure plan. Negative codes stand in `kernels.status`. This module alone knows the numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from ..kernels import status
from ..kernels.trace import Trace

NO_BLOCK = -1


class OutcomeKind(IntEnum):
    """The kinds of outcome of a computation."""

    CLOSED = 0
    UNREACHABLE = 1
    SINGULAR = 2
    JUMP = 3
    NOT_FINITE = 4
    MASS_SINGULAR = 5


_CODES = {
    OutcomeKind.CLOSED: status.GOOD,
    OutcomeKind.JUMP: status.JUMP,
    OutcomeKind.NOT_FINITE: status.NOT_FINITE,
    OutcomeKind.MASS_SINGULAR: status.MASS_SINGULAR,
}
_KINDS = {code: kind for kind, code in _CODES.items()}


class Outcome(NamedTuple):
    """Outcome of a computed state, and the block of the closure plan that decided it.

    Attributes:
        kind: solved, or why not.
        block: index of the block for UNREACHABLE and SINGULAR, `NO_BLOCK` for the other kinds.
            With n blocks, index n stands for frames that are turned by half a turn, and index n + 1
            for redundant equations that do not hold.
    """

    kind: OutcomeKind
    block: int = NO_BLOCK

    def encode(self) -> int:
        """The status code of a kernel."""
        if self.kind is OutcomeKind.UNREACHABLE:
            return 2 * self.block + 1
        if self.kind is OutcomeKind.SINGULAR:
            return 2 * self.block + 2
        return _CODES[self.kind]

    @classmethod
    def decode(cls, code: int) -> Outcome:
        """The outcome that a status code stands for."""
        if code in _KINDS:
            return cls(_KINDS[code])
        block, is_singular = divmod(int(code) - 1, 2)
        if is_singular:
            return cls(OutcomeKind.SINGULAR, block)
        return cls(OutcomeKind.UNREACHABLE, block)


def kinds(codes: Any, where: Callable[..., Any] = np.where) -> Any:
    """The `OutcomeKind` of each status code, as an integer array of the same shape.

    Args:
        codes: integers, an array of NumPy or of another library.
        where: `where` of that library.
    """
    result = where(codes % 2 == 1, int(OutcomeKind.UNREACHABLE), int(OutcomeKind.SINGULAR))
    for code, kind in _KINDS.items():
        result = where(codes == code, int(kind), result)
    return result


def with_kinds(traced: Trace) -> Trace:
    """The trace with numbers of `OutcomeKind` as codes of its checks."""
    checks = [replace(one, code=int(Outcome.decode(one.code).kind)) for one in traced.checks]
    return replace(traced, checks=tuple(checks))
