"""What may vary: a number of the description within its tolerance, a pin within its hole."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Final, Literal, get_args

import numpy as np

from ..description.expressions import evaluate
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arguments import require_type
from ..ground.suggestions import suggestion

Law = Literal["normal", "uniform", "truncated"]
LAWS: Final[tuple[Law, ...]] = get_args(Law)
PLAY: Final = ".play"  # end of the path of a pin's play
UNITS: Final = ("m", "rad")
NUMBERS: Final = (int, float, np.integer, np.floating)
EXAMPLE: Final = "{'L2': 1e-4, 'joints.q2.play': 5e-5}"
SIGMAS: Final = 3.0  # standard deviations in a tolerance
SHORT: Final = 1e-200  # square of a direction below which its length is lost to rounding
Direction = tuple[float, float, float]

_TEXT = re.compile(
    r"(?P<value>.*?)(?:\s+(?P<law>[a-z]+)|\s+towards(?P<way>(?:\s+\S+){3}))?\s*", re.DOTALL
)
_FORM = "expected as 0.1*mm, 0.1*mm uniform, or of a play 0.05*mm towards 0 0 -1"


@dataclass(frozen=True)
class Tolerance:
    """A number that is within `half` of what the description says.

    Attributes:
        half: half of the width of the tolerance [m or rad].
        law: `normal` with the standard deviation half / sigmas, `uniform` within the tolerance, or
            `truncated`: the normal law without what is outside.
        sigmas: standard deviations in `half`.
    """

    half: float
    law: Law = "normal"
    sigmas: float = SIGMAS

    @property
    def deviation(self) -> float:
        """Standard deviation of the normal law."""
        return self.half / self.sigmas

    @property
    def outside(self) -> float:
        """Probability of a number outside the tolerance."""
        if self.law != "normal":
            return 0.0
        return math.erfc(self.sigmas / math.sqrt(2.0))

    def variance(self, size: int) -> float:  # noqa: ARG002 - as Play
        """Variance of the number."""
        if self.law == "uniform":
            return self.half**2 / 3.0
        variance = self.deviation**2
        if self.law == "truncated":
            variance *= _share_within(self.sigmas)
        return variance

    def drawn(self, rng: np.random.Generator, count: int, size: int) -> Array:
        """Random changes (count, size)."""
        shape = (count, size)
        if self.law == "uniform":
            return rng.uniform(-self.half, self.half, shape)
        if self.law == "normal":
            return self.deviation * rng.standard_normal(shape)
        from scipy.special import ndtr, ndtri  # noqa: PLC0415  slow to import

        low = float(ndtr(-self.sigmas))
        probability = rng.uniform(low, 1.0 - low, shape)
        drawn: Array = self.deviation * ndtri(probability)
        return drawn


def _share_within(sigmas: float) -> float:
    """Variance of the normal law of deviation 1 that is cut off beyond so many deviations."""
    from scipy.special import ndtr  # noqa: PLC0415  slow to import

    within = 2.0 * float(ndtr(sigmas)) - 1.0
    density = math.exp(-0.5 * sigmas**2) / math.sqrt(2.0 * math.pi)
    return 1.0 - 2.0 * sigmas * density / within


@dataclass(frozen=True)
class Play:
    """A pin that is anywhere in its hole, or is pressed to one side of it.

    Attributes:
        half: largest distance of the axes of pin and hole [m]: half of the difference of their
            diameters.
        towards: direction (3,) in base axes in which the child of the joint, or the second link of
            the closure, is pressed; None if the pin is free: uniform within the circle.
    """

    half: float
    towards: Direction | None = None
    outside: ClassVar[float] = 0.0  # probability of a pin outside its hole

    def variance(self, size: int) -> float:
        """Variance of each component of the displacement, in `size` dimensions."""
        if self.towards is not None:
            return 0.0
        return self.half**2 / (size + 2.0)

    def drawn(self, rng: np.random.Generator, count: int, size: int) -> Array:
        """Random displacements (count, size); zero for a pressed pin."""
        if self.towards is not None:
            return np.zeros((count, size))
        directions = rng.standard_normal((count, size))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        share = rng.uniform(0.0, 1.0, (count, 1)) ** (1.0 / size)
        drawn: Array = self.half * share * directions
        return drawn


Entry = Tolerance | Play
Table = Mapping[str, float | str | Entry]


def checked_table(table: Table, law: str, unit_of: Callable[[str], str]) -> dict[str, Entry]:
    """The entries of a table by path.

    Args:
        table: numbers [m or rad], texts such as `0.1*mm uniform`, or entries.
        law: the law of numbers without one.
        unit_of: gives the unit of a path, `m` or `rad`; empty if it may be either.

    Raises:
        InputError: the table is empty, or a value is no tolerance.
    """
    require_type("tolerances", table, Mapping, EXAMPLE)
    if not table:
        raise InputError(f"tolerances: expected a table such as {EXAMPLE}")
    entries: dict[str, Entry] = {}
    for path, value in table.items():
        name = str(path).strip()
        if name in entries:
            raise InputError(f"tolerances: '{name}' is given twice")
        if isinstance(value, str):
            entry = _read(name, value, law, unit_of(name))
        else:
            entry = _entry(name, value, law)
        entries[name] = _checked(name, entry)
    return entries


def _entry(name: str, value: float | Entry, law: str) -> Entry:
    """The entry of a value that is no text."""
    is_play = name.endswith(PLAY)
    if isinstance(value, (Tolerance, Play)):
        if is_play != isinstance(value, Play):
            raise InputError(f"tolerances: {name} is {value!r}; a Play is of a path NAME{PLAY}")
        return value
    if isinstance(value, bool) or not isinstance(value, NUMBERS):
        raise InputError(f"tolerances: {name} is {value!r}; {_FORM}, or a number in m or rad")
    half = float(value)
    if is_play:
        return Play(half)
    return Tolerance(half, _law(name, law))


def _read(name: str, text: str, law: str, unit: str) -> Entry:
    """The entry of a text."""
    match = _TEXT.fullmatch(text.strip())
    assert match is not None  # noqa: S101 - its value takes any text
    units = (unit,) if unit else UNITS
    half = _value(name, text, match["value"], units)
    if name.endswith(PLAY):
        if match["law"]:
            raise InputError(f"tolerances: {name} is '{text}': a play has no law; {_FORM}")
        if not match["way"]:
            return Play(half)
        x, y, z = (_value(name, text, word, ("1",)) for word in match["way"].split())
        return Play(half, (x, y, z))
    if match["way"]:
        raise InputError(f"tolerances: {name} is '{text}': only a play is towards a side; {_FORM}")
    return Tolerance(half, _law(name, match["law"] or law))


def _value(name: str, text: str, term: str, units: Sequence[str]) -> float:
    """The value of a term in the text of an entry."""
    try:
        return evaluate(term, {}, names_are="", units=units)
    except (ValueError, ArithmeticError) as error:
        raise InputError(f"tolerances: {name} is '{text}': {error}; {_FORM}") from error


def _law(name: str, law: str) -> Law:
    for one in LAWS:
        if law == one:
            return one
    laws = ", ".join(LAWS)
    raise InputError(f"tolerances: {name}: no law '{law}'{suggestion(law, LAWS)}; laws are {laws}")


def _checked(name: str, entry: Entry) -> Entry:
    half = float(entry.half)
    if not (math.isfinite(half) and half >= 0.0):
        raise InputError(f"tolerances: {name} is {half:g}; expected a finite size, zero or more")
    if isinstance(entry, Tolerance):
        _law(name, entry.law)
        if not (math.isfinite(entry.sigmas) and entry.sigmas > 0.0):
            raise InputError(f"tolerances: {name}: sigmas is {entry.sigmas:g}; expected above zero")
    elif entry.towards is not None:
        way = np.asarray(entry.towards, dtype=float)
        if way.shape != (3,) or not np.isfinite(way).all() or not way @ way > SHORT:
            raise InputError(
                f"tolerances: {name}: towards is {entry.towards}; expected a direction (3,)"
            )
    return entry
