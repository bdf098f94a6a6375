"""Tables of numbers: CSV files with a header, values in SI units or in that of the header."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ..description.expressions import evaluate
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.decimal_commas import with_point
from ..ground.regular_files import read_regular

MAX_BYTES = 200_000_000
LARGEST = 1e12  # in any unit
EXPECTED = "expected a size that can be measured, or an empty cell"
_HEADER = re.compile(r"^(?P<name>[^\[\]]*?)\s*(?:\[(?P<unit>[^\]]*)\])?$")
_SEPARATORS = (",", ";", "\t")
_FACTOR = re.compile(r"([A-Za-z]+|1)\^?([123])?")
_POWERS = {"²": "2", "³": "3", "°": "deg", "µ": "u", "·": " "}

UnitsOf = Callable[[str], Sequence[str]]  # the allowed units of a column; empty: any


def geometric_units(name: str) -> Sequence[str]:  # noqa: ARG001 - the same for all columns
    """The units of a length or an angle, for columns of any name."""
    return ("m", "rad")


@dataclass(frozen=True, eq=False)
class Table:
    """Columns of numbers, and of texts.

    Attributes:
        columns: (N,) by name, in SI units; NaN where a cell is empty.
        units: units in the header, by name.
        lines: line of each row in the file, or its number from 1.
        source: name of the file, for messages.
        texts: N texts by name, of columns that are no numbers.
    """

    columns: Mapping[str, Array]
    units: Mapping[str, str]
    lines: tuple[int, ...]
    source: str
    texts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def without(self, rows: list[int]) -> Table:
        """The table without some rows."""
        columns: dict[str, Array] = {}
        for name, values in self.columns.items():
            columns[name] = np.delete(values, rows)
        lines = np.delete(self.lines, rows).tolist()
        return Table(columns, self.units, tuple(lines), self.source)

    def row(self, index: int) -> str:
        """The place of a row, for messages."""
        return f"{self.source}:{self.lines[index]}"

    def rows(self, names: Sequence[str]) -> Array:
        """The rows (N, k) of k columns. Raises InputError if a cell of them is empty."""
        rows = np.stack([self.columns[name] for name in names], axis=1)
        empty = np.argwhere(np.isnan(rows))
        if len(empty):
            row, column = empty[0].tolist()
            raise InputError(f"{self.row(row)}: {names[column]} is empty; expected a number")
        return rows


def table_of(
    data: str | Path | Mapping[str, Sequence[float] | Array],
    units_of: UnitsOf = geometric_units,
    texts: Collection[str] = (),
) -> Table:
    """A table from a file, or from columns by name in SI units.

    Args:
        data: the file, or the columns.
        units_of: the SI units that a column of a file may have.
        texts: names of columns of a file whose cells are texts.

    Raises:
        InputError: the file cannot be read, a cell is no number, or a unit does not fit.
    """
    if isinstance(data, Mapping):
        return _from_columns(data)
    path = Path(data)
    try:
        text = read_regular(path, MAX_BYTES).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is no text file; expected CSV with a header") from error
    except FileNotFoundError as error:
        raise InputError(f"{path}: there is no such file or folder") from error
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from error
    return _Reader(path, text, units_of, texts).table()


def _from_columns(data: Mapping[str, Sequence[float] | Array]) -> Table:
    columns: dict[str, Array] = {}
    for name, values in data.items():
        column = np.asarray(values, dtype=float)
        if column.ndim != 1:
            raise InputError(f"data: column {name} has shape {column.shape}; expected (N,)")
        _require_size(name, column)
        columns[name] = column
    lengths = {len(column) for column in columns.values()}
    if len(lengths) != 1 or lengths == {0}:
        counts = ", ".join(f"{name}: {len(column)}" for name, column in columns.items())
        raise InputError(f"data: expected columns of one length, with rows; there are {counts}")
    (count,) = lengths
    return Table(columns, {}, tuple(range(1, count + 1)), "row")


def _require_size(name: str, column: Array) -> None:
    large = np.flatnonzero(np.abs(column) > LARGEST)
    if len(large):
        row = int(large[0])
        raise InputError(f"row {row + 1}: {name} is {column[row]:g}; {EXPECTED}")


class _Reader:
    """Reads one text."""

    def __init__(self, path: Path, text: str, units_of: UnitsOf, texts: Collection[str]) -> None:
        self.path = path
        self.units_of = units_of
        self.texts = texts
        lines = text.splitlines()
        self.numbered = []
        for number, line in enumerate(lines, start=1):
            if line.strip() and not line.lstrip().startswith("#"):
                self.numbered.append((number, line))

    def table(self) -> Table:
        """The table."""
        if len(self.numbered) < 2:
            raise InputError(f"{self.path}: has no rows; expected CSV with a header and a row each")
        (line, header), *rows = self.numbered
        separator = max(_SEPARATORS, key=header.count)
        names, units = self.header(line, self.cells(header, separator))
        cells: list[list[str]] = []
        for number, row in rows:
            cells.append(self.cells(row, separator))
            if len(cells[-1]) != len(names):
                problem = f"has {len(cells[-1])} cells; the header has {len(names)}"
                raise InputError(f"{self.path}:{number}: {problem}")
        numbers = tuple(number for number, _ in rows)
        columns: dict[str, Array] = {}
        texts: dict[str, tuple[str, ...]] = {}
        for name, column in zip(names, zip(*cells, strict=True), strict=True):
            if name in self.texts:
                texts[name] = column
                continue
            factor = self.factor(line, name, units.get(name, ""))
            pairs = zip(numbers, column, strict=True)
            values = [self.number(number, name, cell) for number, cell in pairs]
            columns[name] = np.array(values) * factor
        return Table(columns, units, numbers, str(self.path), texts)

    @staticmethod
    def cells(line: str, separator: str) -> list[str]:
        """The cells of a line."""
        (cells,) = csv.reader([line], delimiter=separator)
        return [cell.strip() for cell in cells]

    def header(self, line: int, cells: Sequence[str]) -> tuple[list[str], dict[str, str]]:
        """Names of the columns, and the units that they have."""
        names: list[str] = []
        units: dict[str, str] = {}
        for cell in cells:
            match = _HEADER.match(cell)
            name = cell if match is None else match["name"]
            if not name:
                raise InputError(f"{self.path}:{line}: a column has no name")
            if name in names:
                raise InputError(f"{self.path}:{line}: there are two columns {name}")
            names.append(name)
            if match is not None and match["unit"]:
                units[name] = match["unit"]
        return names, units

    def number(self, line: int, name: str, cell: str) -> float:
        """The number of a cell; NaN if it is empty."""
        if not cell:
            return math.nan
        try:
            value = float(cell)
        except ValueError:
            point = with_point(cell)
            hint = f"; decimals have a point: {point}" if point else ""
            problem = f"{name} is '{cell}', which is no number{hint}"
            raise InputError(f"{self.path}:{line}: {problem}") from None
        if abs(value) > LARGEST:
            raise InputError(f"{self.path}:{line}: {name} is {cell}; {EXPECTED}")
        return value

    def factor(self, line: int, name: str, unit: str) -> float:
        """The factor from a unit to SI units."""
        if not unit:
            return 1.0
        try:
            return evaluate(unit_term(unit), {}, names_are="", units=self.units_of(name))
        except ValueError as error:
            raise InputError(f"{self.path}:{line}: column {name} [{unit}]: {error}") from error


def unit_term(unit: str) -> str:
    """A unit as an expression: `mm/s^2` is 1*mm/s/s, `N m` is 1*N*m.

    Raises:
        ValueError: it is no unit.
    """
    text = unit
    for sign, plain in _POWERS.items():
        text = text.replace(sign, plain)
    above, *below = text.split("/")
    term = "1"
    for part, sign in [(above, "*"), *((part, "/") for part in below)]:
        for factor in part.replace("*", " ").split():
            match = _FACTOR.fullmatch(factor)
            if match is None:
                raise ValueError(f"'{unit}' is no unit")
            term += f"{sign}{match[1]}" * int(match[2] or 1)
    return term
