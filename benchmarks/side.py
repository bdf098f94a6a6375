"""What takes part in the benchmark, and what is asked of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

# What every side is called with, and what it returns. u, du, ddu, tau are arrays (4,) in the order
# of robot.active.
WORKS = {
    "id": "inverse dynamics, new array",  # (u, du, ddu) -> tau
    "id_out": "inverse dynamics, `out=`",  # (u, du, ddu, out) -> tau
    "minimal": "M-bar, C-bar u', G-bar",  # (u, du) -> M (4, 4), h (4,), g (4,)
    "fd": "forward dynamics",  # (u, du, tau) -> ddu
    "close": "closure of the 8 passive joints, with rates",  # (u, du) -> s (12,), ds (12,)
    "id_batch": "inverse dynamics, batch",  # (u, du, ddu), each (N, 4) -> tau (N, 4)
}


@dataclass(frozen=True)
class Side:
    """An engine, and the works that it does.

    Attributes:
        name: as the tables show it.
        calls: its works, by key of WORKS.
        tolerance: relative, of its answers.
    """

    name: str
    calls: Mapping[str, Callable[..., Any]]
    tolerance: float = 1e-9
