"""What is proved of a closed configuration and of the efforts that hold it."""

from __future__ import annotations

from dataclasses import dataclass

from ...ground.arrays import Array


@dataclass(frozen=True, eq=False)
class Certificate:
    """A box that surely holds the closed configuration, and one that surely holds the efforts.

    For each u of the box of active coordinates, the loops close in exactly one way within `alone`
    of the state. That configuration is in the box of `s`, and it is not singular. If nothing was
    proved, all bounds are NaN.

    Attributes:
        holds: whether this was proved.
        reason: why, in a sentence.
        s_lower: lower bounds of all coordinates (n_s,) [rad, m].
        s_upper: their upper bounds.
        alone: distance (n_s,) from the state within which no other closed configuration is; zero
            for the active coordinates [rad, m].
        tau_lower: lower bounds of the efforts (n,) [N m, N].
        tau_upper: their upper bounds.
    """

    holds: bool
    reason: str
    s_lower: Array
    s_upper: Array
    alone: Array
    tau_lower: Array
    tau_upper: Array

    def __bool__(self) -> bool:
        return self.holds
