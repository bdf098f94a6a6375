"""Errors with evidence: what was wrong and where, what was expected, and what to do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray


class HybridDynamicsError(Exception):
    """Base class of all errors of this package."""


class DescriptionError(HybridDynamicsError):
    """A robot description is wrong.

    Attributes:
        problem: description of the error.
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
    """A description does not determine the assembly mode of a loop.

    It has the attributes of DescriptionError, and these:

    Attributes:
        loop: name of the loop.
        modes: possible values of `assembly`.
    """

    def __init__(self, error: DescriptionError, *, loop: str, modes: tuple[str, ...]) -> None:
        self.loop = loop
        self.modes = modes
        super().__init__(error.problem, key=error.key, file=error.file, line=error.line)


class InputError(HybridDynamicsError, ValueError):
    """An argument is wrong: its shape, a value that is not finite, an unknown name."""


class UnknownNameError(InputError, KeyError):
    """A name is unknown; the message lists the existing names."""

    def __str__(self) -> str:
        return str(self.args[0])  # KeyError would show it in quotes


class StateError(HybridDynamicsError, ArithmeticError):
    """The mechanism has no usable state at an input.

    Attributes:
        loop: name of the loop.
        index: row in a batch, or None.
    """

    def __init__(self, message: str, *, loop: str, index: int | None = None) -> None:
        self.loop = loop
        self.index = index
        super().__init__(_with_row(message, index))

    def place_in_row(self, index: int) -> None:
        """Set the row of a batch in which the error occurred."""
        self.index = index
        self.args = (_with_row(str(self), index),)


class ClosureError(StateError):
    """A loop cannot be closed at the given coordinates.

    Attributes:
        loop: name of the loop.
        coordinate: name of the coordinate that is out of range; None if several together are.
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
        direction: (n,) that motion of the active joints.
        eigenvalues: (n,) eigenvalues of M-bar, ascending.
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
    """An optional package is not installed.

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
    """`FILE:LINE`, or the part that is known."""
    name = "" if file is None else str(file)
    if line is None:
        return name
    return f"{name}:{line}" if name else f"line {line}"


def _with_row(message: str, index: int | None) -> str:
    if index is None:
        return message
    return f"row {index}: {message}"
