"""Parts of a robot in words: `A: joint=q2 pivot=-0.7,0.3 pin=0.4,0 barrel=40*cm`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ...description.expressions import evaluate
from ...errors import InputError
from ...ground.suggestions import no_such_name


@dataclass(frozen=True)
class Phrase:
    """A part with its numbers.

    Attributes:
        place: what messages call it, as `loop 2 (A)`.
        head: its kind.
        words: values by key, as they were written.
    """

    place: str
    head: str
    words: Mapping[str, str]

    def require_keys(self, expected: Sequence[str], needed: Sequence[str] = ()) -> None:
        """Check the keys.

        Raises:
            InputError: one is unknown, or is missing.
        """
        for key in self.words:
            if key not in expected:
                raise InputError(f"{self.place}: {no_such_name('key', key, expected)}")
        missing = [key for key in needed if key not in self.words]
        if missing:
            raise InputError(f"{self.place}: give {missing[0]}=...; needed: {', '.join(needed)}")

    def word(self, key: str, otherwise: str) -> str:
        """A word."""
        return self.words.get(key, otherwise)

    def number(self, key: str, unit: str, otherwise: float = math.nan) -> float:
        """A number in SI units."""
        if key not in self.words:
            return otherwise
        (number,) = self.numbers(key, unit, 1)
        return number

    def size(self, key: str, unit: str, otherwise: float) -> float:
        """A number of zero or more."""
        number = self.number(key, unit, otherwise)
        if number < 0.0:
            raise InputError(f"{self.place}: {key} is {number:g}; expected zero or more")
        return number

    def positive(self, key: str, unit: str, otherwise: float = math.nan) -> float:
        """A number above zero."""
        number = self.number(key, unit, otherwise)
        if number <= 0.0:
            raise InputError(f"{self.place}: {key} is {number:g}; expected more than zero")
        return number

    def numbers(
        self, key: str, unit: str, count: int, otherwise: Sequence[float] = ()
    ) -> tuple[float, ...]:
        """Numbers in SI units, parted by commas."""
        if key not in self.words:
            return tuple(otherwise)
        terms = self.words[key].split(",")
        if len(terms) != count:
            raise InputError(
                f"{self.place}: {key} is '{self.words[key]}'; expected {count} numbers, with commas"
            )
        return tuple(self._value(key, term, unit) for term in terms)

    def _value(self, key: str, term: str, unit: str) -> float:
        try:
            value = evaluate(term, {}, names_are="", units=[unit])
        except (ValueError, ArithmeticError) as error:
            raise InputError(f"{self.place}: {key}: {error}") from error
        if not math.isfinite(value):
            raise InputError(f"{self.place}: {key} is {value}; expected a finite number")
        return value


def parse_phrases(kind: str, text: str) -> list[Phrase]:
    """The parts of a text, with semicolons between them.

    Args:
        kind: what a part is, for messages, as `loop`.
        text: `HEAD: KEY=VALUE KEY=VALUE; HEAD: ...`

    Raises:
        InputError: a part has another form.
    """
    phrases: list[Phrase] = []
    parts = [part.strip() for part in text.split(";")]
    for number, part in enumerate(filter(None, parts), start=1):
        head, _, rest = part.partition(":")
        place = f"{kind} {number} ({head.strip()})"
        words: dict[str, str] = {}
        for term in rest.split():
            key, equals, value = term.partition("=")
            if not equals or not key or not value:
                raise InputError(f"{place}: '{term}'; expected KEY=VALUE, as length=0.7")
            if key in words:
                raise InputError(f"{place}: {key} is given twice")
            words[key] = value
        phrases.append(Phrase(place, head.strip(), words))
    if not phrases:
        raise InputError(f"there is no {kind}; expected HEAD: KEY=VALUE ..., with semicolons")
    return phrases
