"""Errors that carry their evidence: what was wrong, where, what was expected, what to do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class HybridDynamicsError(Exception):
    """Base of every error this package raises on purpose."""


class DescriptionError(HybridDynamicsError):
    """A robot description is wrong.

    Attributes: ``file`` (path or None), ``line`` (1-based or None), ``key`` (dotted path of the
    entry), ``problem``.
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
        where = "" if file is None else str(file)
        if line is not None:
            where += f":{line}" if where else f"line {line}"
        super().__init__(": ".join(part for part in (where, key, problem) if part))


class UndecidedModeError(DescriptionError):
    """A description leaves open in which of its assembly modes a loop closes.

    Attributes beside those of DescriptionError: ``loop`` (name), ``modes`` (names that can stand as
    ``assembly``).
    """

    def __init__(self, error: DescriptionError, *, loop: str, modes: tuple[str, ...]) -> None:
        self.loop = loop
        self.modes = modes
        super().__init__(error.problem, key=error.key, file=error.file, line=error.line)


class InputError(HybridDynamicsError, ValueError):
    """An argument cannot be used: wrong shape, not finite, unknown name."""


class UnknownNameError(InputError, KeyError):
    """There is nothing of that name; the message has the names that there are."""

    def __str__(self) -> str:
        return str(self.args[0])  # a KeyError alone would show it in quotes


class StateError(HybridDynamicsError, ArithmeticError):
    """The mechanism has no usable answer at this input; ``index`` is the row in a batch, or None."""

    def __init__(self, message: str, *, loop: str, index: int | None = None) -> None:
        self.loop = loop
        self.index = index
        super().__init__(message if index is None else f"row {index}: {message}")


class ClosureError(StateError):
    """A loop cannot be closed at the given coordinates.

    Attributes: ``loop``; ``coordinate`` whose value is out of range (None when several given
    coordinates act together), its ``value`` and the ``allowed`` (lower, upper) range, where the
    loop closes [rad or m].
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

    Attributes: ``loop``; ``distance``, the reciprocal condition number of the loop's scaled
    Jacobian.
    """

    def __init__(
        self, message: str, *, loop: str, distance: float, index: int | None = None
    ) -> None:
        self.distance = distance
        super().__init__(message, loop=loop, index=index)


class MassSingularityError(HybridDynamicsError, ArithmeticError):
    """M-bar cannot be inverted: some motion of the active joints moves no mass, so forces give no acceleration.

    Attributes: ``joint``, the active joint that moves most in it; ``direction`` (n,), that motion;
    ``eigenvalues`` (n,) of M-bar, ascending; ``index``, the row in a batch, or None.
    """

    def __init__(
        self,
        message: str,
        *,
        joint: str,
        direction: Array,
        eigenvalues: Array,
        index: int | None = None,
    ) -> None:
        self.joint = joint
        self.direction = direction
        self.eigenvalues = eigenvalues
        self.index = index
        super().__init__(message if index is None else f"row {index}: {message}")


class MissingPackageError(HybridDynamicsError, ImportError):
    """A package that only some functions need is not installed; `extra` is the extra that brings it."""

    def __init__(self, package: str, extra: str, what: str) -> None:
        self.extra = extra
        super().__init__(
            f"{what} need {package}: pip install {package}, or this package with its extra"
            f" '{extra}'",
            name=package,
        )
