"""Sets of designs: a grid of ranges, random values in them, or the rows of a table."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..formats.tables import UnitsOf, table_of
from ..ground.arrays import Array
from ..ground.check_arguments import integer, real_number

MOST = 10**12  # designs of a study
_WORDS = 4  # random numbers in a block of Philox

Bounds = Mapping[str, Sequence[float]]


@dataclass(frozen=True)
class Range:
    """Values from `low` to `high`, both included.

    Attributes:
        low: the least value [SI units].
        high: the largest value.
        count: number of values of a grid; 0 in a random study.
    """

    low: float
    high: float
    count: int = 0

    def values(self, indices: Array) -> Array:
        """The values (N,) at indices (N,) of a grid."""
        share = indices / (self.count - 1)
        values: Array = self.low * (1.0 - share) + self.high * share
        return values


class Space(ABC):
    """Designs by number.

    Attributes:
        names: the parameters that vary.
        count: number of designs.
    """

    names: tuple[str, ...]
    count: int

    @abstractmethod
    def designs(self, first: int, end: int) -> Array:
        """Values (end - first, k) of the parameters of some designs."""

    @abstractmethod
    def extremes(self) -> Array:
        """The least and largest values (2, k)."""

    @abstractmethod
    def content(self) -> Any:
        """What decides the designs, as plain data."""


@dataclass(frozen=True)
class Grid(Space):
    """All combinations of equally spaced values; the last parameter changes fastest."""

    ranges: Mapping[str, Range]

    @property
    def names(self) -> tuple[str, ...]:  # type: ignore[override]
        """The parameters that vary."""
        return tuple(self.ranges)

    @property
    def count(self) -> int:  # type: ignore[override]
        """Number of designs."""
        return math.prod(one.count for one in self.ranges.values())

    def designs(self, first: int, end: int) -> Array:
        """Values (end - first, k) of the parameters of some designs."""
        shape = [one.count for one in self.ranges.values()]
        places = np.unravel_index(np.arange(first, end), shape)
        pairs = zip(self.ranges.values(), places, strict=True)
        columns = [one.values(place.astype(np.float64)) for one, place in pairs]
        return np.stack(columns, axis=1)

    def extremes(self) -> Array:
        """The least and largest values (2, k)."""
        return _ends(self.ranges)

    def content(self) -> Any:
        """What decides the designs, as plain data."""
        return {"grid": {name: [*_plain(one), one.count] for name, one in self.ranges.items()}}


@dataclass(frozen=True)
class Random(Space):
    """Uniform random values. A design depends on its number and the seed only."""

    ranges: Mapping[str, Range]
    count: int
    seed: int = 0

    @property
    def names(self) -> tuple[str, ...]:  # type: ignore[override]
        """The parameters that vary."""
        return tuple(self.ranges)

    def designs(self, first: int, end: int) -> Array:
        """Values (end - first, k) of the parameters of some designs."""
        k = len(self.ranges)
        skipped, rest = divmod(first * k, _WORDS)
        bits = np.random.Philox(key=self.seed)
        bits.advance(skipped)
        drawn = np.random.Generator(bits).random(rest + (end - first) * k)
        share = drawn[rest:].reshape(end - first, k)
        low, high = _ends(self.ranges)
        values: Array = low * (1.0 - share) + high * share
        return values

    def extremes(self) -> Array:
        """The least and largest values (2, k)."""
        return _ends(self.ranges)

    def content(self) -> Any:
        """What decides the designs, as plain data."""
        ranges = {name: _plain(one) for name, one in self.ranges.items()}
        return {"random": ranges, "count": self.count, "seed": self.seed}


@dataclass(frozen=True, eq=False)
class Listed(Space):
    """Designs as rows of a table.

    Attributes:
        names: the parameters that vary.
        rows: values (N, k) of each design [SI units].
    """

    names: tuple[str, ...]
    rows: Array

    @property
    def count(self) -> int:  # type: ignore[override]
        """Number of designs."""
        return len(self.rows)

    def designs(self, first: int, end: int) -> Array:
        """Values (end - first, k) of the parameters of some designs."""
        return self.rows[first:end]

    def extremes(self) -> Array:
        """The least and largest values (2, k)."""
        return np.stack([self.rows.min(axis=0), self.rows.max(axis=0)])

    def content(self) -> Any:
        """What decides the designs, as plain data."""
        return {"names": list(self.names), "rows": self.rows.tobytes().hex()}


def grid(bounds: Bounds) -> Grid:
    """All combinations of equally spaced values.

    Args:
        bounds: low, high and number of values, by name or path of the parameter.

    Raises:
        InputError: a range is empty or has no number of values, or there are too many designs.
    """
    ranges: dict[str, Range] = {}
    for name, numbers in _entries(bounds).items():
        if len(numbers) != 3:
            raise InputError(f"vary: {name} is {tuple(numbers)}; expected low, high and count")
        low, high, count = numbers
        ends = _range(name, low, high)
        ranges[name] = Range(ends.low, ends.high, integer(f"vary: count of {name}", count, least=2))
    space = Grid(ranges)
    if space.count > MOST:
        raise InputError(f"vary: this grid has {space.count:.3g} designs; at most {MOST:g}")
    return space


def random(bounds: Bounds, count: int, seed: int = 0) -> Random:
    """Uniform random values.

    Args:
        bounds: low and high by name or path of the parameter.
        count: number of designs.
        seed: seed of the random numbers.

    Raises:
        InputError: a range is empty, or a number is wrong.
    """
    ranges: dict[str, Range] = {}
    for name, numbers in _entries(bounds).items():
        if len(numbers) != 2:
            raise InputError(f"vary: {name} is {tuple(numbers)}; expected low and high")
        low, high = numbers
        ranges[name] = _range(name, low, high)
    return Random(ranges, integer("count", count), integer("seed", seed, least=0))


def listed(
    data: str | Path | Mapping[str, Sequence[float] | Array],
    units_of: UnitsOf | None = None,
) -> Listed:
    """Designs as rows of a table.

    Args:
        data: a CSV file whose header has names or paths of parameters, or columns (N,) by name.
        units_of: the SI units that a column of a file may have; any if None.

    Raises:
        InputError: the file cannot be read, a cell is empty or no number, or a unit is wrong.
    """
    table = table_of(data, units_of or _any_units)
    names = tuple(table.columns)
    return Listed(names, table.rows(names))


def _any_units(name: str) -> Sequence[str]:  # noqa: ARG001 - one answer for all columns
    return ()


def _entries(bounds: Bounds) -> Bounds:
    if not bounds:
        raise InputError("vary: no parameter varies; name at least one, as {'L2': (0.6, 0.9, 10)}")
    return bounds


def _range(name: str, low: float, high: float) -> Range:
    """A range. Raises InputError if it is empty or not finite."""
    first = real_number(f"vary: {name}", low)
    last = real_number(f"vary: {name}", high)
    if not (math.isfinite(first) and math.isfinite(last)):
        raise InputError(f"vary: {name} from {first:g} to {last:g}; expected finite bounds")
    if last < first:
        raise InputError(f"vary: {name} ends at {last:g}, below its start {first:g}")
    if last == first:
        raise InputError(f"vary: {name} from {first:g} to {last:g} has no range")
    return Range(first, last)


def _ends(ranges: Mapping[str, Range]) -> Array:
    """The ends (2, k) of all ranges."""
    pairs = [_plain(one) for one in ranges.values()]
    return np.array(pairs).T


def _plain(one: Range) -> list[float]:
    return [one.low, one.high]
