"""The record of a singular place that a motion passed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Passage:
    """A change point or toggle that a motion passed.

    Coordinates are in the order of `robot.coordinates`, in [rad] or [m]. Rates are per second in a
    simulation. In `close_path` they are the changes per row; at a toggle they then have length 1,
    and only their direction counts.

    Attributes:
        kind: "change point" or "toggle".
        loops: the loops that are singular there.
        s: all coordinates (n_s,) at the place.
        rates: rates (n_s,) of the motion that was followed.
        other_rates: rates (n_s,) of the motions that branch off, one for each of `loops`: that loop
            goes the other way, and those after it keep their velocity as far as they can. The
            active rates are the same, or zero where that motion holds u at rest. Empty at a toggle,
            where no motion branches off.
        before: assembly modes by loop before the place.
        after: assembly modes by loop after it. A motion that branches off keeps the mode `before`
            of its loop.
        index: row of `close_path` at which the place is reached; None in a simulation.
    """

    kind: str
    loops: tuple[str, ...]
    s: tuple[float, ...]
    rates: tuple[float, ...]
    other_rates: tuple[tuple[float, ...], ...]
    before: Mapping[str, str]
    after: Mapping[str, str]
    index: int | None = None

    @property
    def message(self) -> str:
        """What was passed, in a sentence."""
        names = "+".join(self.loops)
        modes = [f"{self.before[loop]} to {self.after[loop]}" for loop in self.loops]
        changed = ", ".join(dict.fromkeys(modes))
        return f"loop '{names}' passed a {self.kind}, from mode {changed}"


def passage_from(entry: Mapping[str, Any]) -> Passage:
    """The record from plain data, such as `dataclasses.asdict` makes."""
    return Passage(
        kind=entry["kind"],
        loops=tuple(entry["loops"]),
        s=tuple(entry["s"]),
        rates=tuple(entry["rates"]),
        other_rates=tuple(tuple(rates) for rates in entry["other_rates"]),
        before=dict(entry["before"]),
        after=dict(entry["after"]),
        index=entry["index"],
    )
