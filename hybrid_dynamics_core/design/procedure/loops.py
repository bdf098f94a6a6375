"""Loops of an arm in words: their types, joints and dimensions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ...errors import InputError
from ...ground.arrays import Array
from ...ground.suggestions import no_such_name
from .arm import DENSITY, MOST, ArmLink
from .phrases import Phrase, parse_phrases
from .planar import point

_COMMON = ("joint", "base", "pivot", "pin", "masses")
_DRIVES = ("barrel", "rod", "stroke", "crank", "coupler", "side")
_KEYS = {
    "A": (*_COMMON, *_DRIVES),
    "B": (*_COMMON, "bar", "carrier", "side"),
    "C": (*_COMMON, "bar", "k2", "at", "side"),
    "D": (*_COMMON, *_DRIVES),
}
_NEEDED = {
    "A": ("joint", "pivot", "pin"),
    "B": ("joint", "pivot"),
    "C": ("joint", "pivot", "pin", "bar", "k2"),
    "D": ("joint", "pivot", "pin"),
}
_SIDES = ("left", "right")


@dataclass(frozen=True)
class ArmLoop:
    """A loop at a joint of an arm.

    Attributes:
        number: j of its names, from 1: links l_j1 and l_j2, joints q_j1 and q_j2.
        type: A to D.
        joint: the joint of the arm at which it stands.
        phrase: its dimensions.
    """

    number: int
    type: str
    joint: str
    phrase: Phrase

    @property
    def links(self) -> tuple[str, str]:
        """Names of its added links, the first on the base."""
        return f"l{self.number}1", f"l{self.number}2"

    @property
    def joints(self) -> tuple[str, str]:
        """Names of their joints."""
        return f"q{self.number}1", f"q{self.number}2"

    @property
    def name(self) -> str:
        """Its name."""
        return f"theta_{self.number}"

    @property
    def is_parallelogram(self) -> bool:
        """Whether a loop of Type B has equal opposite bars, as it has where none is given."""
        return not {"bar", "pin"} & set(self.phrase.words)

    def require(self, *keys: str) -> None:
        """Raise InputError for a missing key."""
        self.phrase.require_keys(_KEYS[self.type], keys)

    def masses(self, lengths: Sequence[float]) -> tuple[float, ...]:
        """Masses of two links [kg], by their lengths [m] where none are given."""
        usual = [DENSITY * length for length in lengths]
        return self.phrase.numbers("masses", "kg", 2, usual)

    def point(self, key: str) -> Array:
        """A point (2,) [m]."""
        x, y = self.phrase.numbers(key, "m", 2)
        return point(x, y)

    @property
    def left(self) -> bool:
        """Whether its bars meet on the left of the way from the first pivot to the second."""
        side = self.phrase.word("side", "left")
        if side not in _SIDES:
            raise InputError(f"{self.phrase.place}: side is '{side}'; expected left or right")
        return side == "left"


def parse_loops(text: str, links: Sequence[ArmLink]) -> tuple[ArmLoop, ...]:
    """Loops of an arm, as `A: joint=q2 pivot=-0.7,0.3 pin=0.4,0 barrel=0.4; B: ...`.

    Raises:
        InputError: a type or key is unknown, or a joint is none that pitches.
    """
    pitching = [link.joint for link in links if link.turn == "pitch"]
    joints = [link.joint for link in links]
    loops: list[ArmLoop] = []
    for number, phrase in enumerate(parse_phrases("loop", text), start=1):
        if phrase.head not in _KEYS:
            raise InputError(f"{phrase.place}: there is no such type; expected A, B, C or D")
        phrase.require_keys(_KEYS[phrase.head], _NEEDED[phrase.head])
        joint = phrase.words["joint"]
        if joint not in joints:
            raise InputError(f"{phrase.place}: {no_such_name('joint', joint, joints)}")
        if joint not in pitching:
            listed = ", ".join(pitching) or "none"
            raise InputError(
                f"{phrase.place}: {joint} does not pitch; loops stand at joints that do: {listed}"
            )
        loops.append(ArmLoop(number, phrase.head, joint, phrase))
    if len(loops) > MOST:
        raise InputError(f"there are {len(loops)} loops; expected {MOST} at most")
    for joint in pitching:
        _require_company(joint, [loop for loop in loops if loop.joint == joint])
    return tuple(loops)


def _require_company(joint: str, loops: Sequence[ArmLoop]) -> None:
    """Raise InputError for loops that cannot stand at one joint together."""
    types = sorted(loop.type for loop in loops)
    if len(types) > 1 and types != ["A", "B"]:
        raise InputError(
            f"loops of types {', '.join(types)} stand at {joint}; expected one, or an A that drives"
            " it and a B that carries the arm on"
        )
