"""Designs of a study, and what is computed of them."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import DescriptionError, InputError, StateError
from ..ground.arrays import Array
from ..ground.suggestions import no_such_name
from ..programs.outcome import OutcomeKind
from ..robot.parameters import RobotFamily
from ..robot.robot import Robot

CLOSED = OutcomeKind.CLOSED.name.lower()
OPEN = OutcomeKind.UNREACHABLE.name.lower()
Texts = NDArray[np.str_]
_NAME = re.compile(r"[^,\"\r\n]+")


@dataclass(eq=False)
class Designs:
    """Some designs of a study, as a function of the study gets them.

    Attributes:
        names: the parameters that vary.
        values: their values (N, k) [SI units].
        u: active coordinates (P, n) of the poses [rad, m].
        described: the robot as it is described.
        family: the robot as a function of the parameters; None if one of them cannot be free.
        status: N texts, `closed` where all loops close at all poses.
    """

    names: tuple[str, ...]
    values: Array
    u: Array
    described: Robot
    family: RobotFamily | None
    status: Texts

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, name: str) -> Array:
        """Values (N,) of a parameter. Raises InputError if it does not vary."""
        if name not in self.names:
            raise InputError(no_such_name("parameter", name, self.names))
        return self.values[:, self.names.index(name)]

    def robot(self, row: int) -> Robot:
        """The robot of one design, analysed anew.

        Raises:
            DescriptionError: the numbers do not fit; the loops do not close with them, for example.
        """
        values = self.values[row].tolist()
        return self.described.with_parameters(dict(zip(self.names, values, strict=True)))


Function = Callable[[Designs], Mapping[str, Any]]


@dataclass(frozen=True)
class EachRobot:
    """A function of designs from one of a robot; it is slower, and takes any change of structure.

    Attributes:
        function: takes a robot and gives numbers by name. Where it raises a StateError, or the
            design has no robot, the design is `unreachable`, and its numbers are NaN.
    """

    function: Callable[[Robot], Mapping[str, float]]

    def __call__(self, designs: Designs) -> Mapping[str, Array]:
        """The numbers (N,) of all designs, by name."""
        rows: dict[int, Mapping[str, float]] = {}
        for row in range(len(designs)):
            try:
                result: Any = self.function(designs.robot(row))
            except (DescriptionError, StateError):
                designs.status[row] = OPEN
                continue
            if not isinstance(result, Mapping):
                kind = type(result).__name__
                raise InputError(f"of each robot: gave a {kind}; expected numbers by name")
            rows[row] = result
        names: dict[str, None] = {}
        for result in rows.values():
            names.update(dict.fromkeys(result))
        columns = {name: np.full(len(designs), np.nan) for name in names}
        for row, result in rows.items():
            for name, value in result.items():
                columns[name][row] = value
        return columns


def _numbers(name: Any, values: Any) -> Array:
    """An array of real numbers."""
    column = np.asarray(values)
    if column.dtype.kind not in "biuf":
        raise InputError(f"function: '{name}' has {column.dtype} values; expected real numbers")
    return column.astype(np.float64)


def checked_columns(results: Any, designs: Designs) -> dict[str, Array]:
    """The columns that a function has given.

    Raises:
        InputError: they are no columns of one number a design.
    """
    if not isinstance(results, Mapping):
        kind = type(results).__name__
        raise InputError(f"function: gave a {kind}; expected arrays (N,) by name")
    columns: dict[str, Array] = {}
    for name, values in results.items():
        if not _NAME.fullmatch(str(name)):
            raise InputError(
                f"function: a column is named {name!r}; expected a name without commas, quotes and"
                " line breaks"
            )
        column = _numbers(name, values)
        if column.shape != (len(designs),):
            expected = f"({len(designs)},), one number a design"
            raise InputError(f"function: '{name}' has shape {column.shape}; expected {expected}")
        columns[str(name)] = column
    return columns
