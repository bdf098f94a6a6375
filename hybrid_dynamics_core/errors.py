"""Errors that carry their evidence: what was wrong, where, what was expected, what to do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray


class HybridDynamicsError(Exception):
    """Base of every error this package raises on purpose."""


class DescriptionError(HybridDynamicsError):
    """A robot description is wrong.

    Attributes:
        problem: what is wrong.
        key: dotted path of the entry, empty for the whole file.
        file: path of the file, or None.
        line: line of the entry (1-based), or None.
    """

    def __init__(
        self,
        problem: str,
        *,
        key: str = "",
        file: str | Path | None = None,
        line: int | None = None,
    ) -> None:
        self.problem = problem
        self.key = key
        self.file = file
        self.line = line
        parts = (_location(file, line), key, problem)
        super().__init__(": ".join(part for part in parts if part))


class UndecidedModeError(DescriptionError):
    """A description leaves open in which of its assembly modes a loop closes.

    Its attributes are those of DescriptionError, and these:

    Attributes:
        loop: name of the loop.
        modes: names that can stand as ``assembly``.
    """

    def __init__(self, error: DescriptionError, *, loop: str, modes: tuple[str, ...]) -> None:
        self.loop = loop
        self.modes = modes
        super().__init__(error.problem, key=error.key, file=error.file, line=error.line)


class InputError(HybridDynamicsError, ValueError):
    """An argument cannot be used: wrong shape, not finite, unknown name."""


class UnknownNameError(InputError, KeyError):
    """There is nothing of this name; the message lists the names that exist."""

    def __str__(self) -> str:
        return str(self.args[0])  # a KeyError alone would show it in quotes


class StateError(HybridDynamicsError, ArithmeticError):
    """The mechanism has no usable answer at this input.

    Attributes:
        loop: name of the loop.
        index: row in a batch, or None.
    """

    def __init__(self, message: str, *, loop: str, index: int | None = None) -> None:
        self.loop = loop
        self.index = index
        super().__init__(_with_row(message, index))

    def place_in_row(self, index: int) -> None:
        """Say in which row of a batch the error is, where one row after another is computed."""
        self.index = index
        self.args = (_with_row(str(self), index),)


class ClosureError(StateError):
    """A loop cannot be closed at the given coordinates.

    Attributes:
        loop: name of the loop.
        coordinate: the one that is out of range; None when several act together.
        value: its value [rad or m], or None.
        allowed: (lower, upper) range in which the loop closes [rad or m], or None.
        index: row in a batch, or None.
    """

    def __init__(
        self,
        message: str,
        *,
        loop: str,
        coordinate: str | None = None,
        value: float | None = None,
        allowed: tuple[float, float] | None = None,
        index: int | None = None,
    ) -> None:
        self.coordinate = coordinate
        self.value = value
        self.allowed = allowed
        super().__init__(message, loop=loop, index=index)


class SingularityError(StateError):
    """A loop is at, or too near, a singular configuration: rates and forces have no finite answer.

    Attributes:
        loop: name of the loop.
        distance: reciprocal condition number of the loop's scaled Jacobian.
        index: row in a batch, or None.
    """

    def __init__(
        self, message: str, *, loop: str, distance: float, index: int | None = None
    ) -> None:
        self.distance = distance
        super().__init__(message, loop=loop, index=index)


class MassSingularityError(HybridDynamicsError, ArithmeticError):
    """M-bar cannot be inverted, so forces give no acceleration.

    Some motion of the active joints moves no mass.

    Attributes:
        joint: the active joint that moves most in that motion.
        direction: (n,) that motion, over the active joints.
        eigenvalues: (n,) of M-bar, ascending.
        index: row in a batch, or None.
    """

    def __init__(
        self,
        message: str,
        *,
        joint: str,
        direction: NDArray[np.float64],
        eigenvalues: NDArray[np.float64],
        index: int | None = None,
    ) -> None:
        self.joint = joint
        self.direction = direction
        self.eigenvalues = eigenvalues
        self.index = index
        super().__init__(_with_row(message, index))


class MissingPackageError(HybridDynamicsError, ImportError):
    """A package that only some functions need is not installed.

    Attributes:
        extra: the extra of this package that installs it.
    """

    def __init__(self, package: str, extra: str, what: str) -> None:
        self.extra = extra
        super().__init__(
            f"{what} need {package}: pip install {package}, or this package with its extra"
            f" '{extra}'",
            name=package,
        )


def _location(file: str | Path | None, line: int | None) -> str:
    """`FILE:LINE`, or what there is of it."""
    name = "" if file is None else str(file)
    if line is None:
        return name
    return f"{name}:{line}" if name else f"line {line}"


def _with_row(message: str, index: int | None) -> str:
    if index is None:
        return message
    return f"row {index}: {message}"
