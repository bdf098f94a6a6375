"""The interface of a filter's formulas for a row of samples."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Protocol

from .scalars import Scalar, Scalars


class Steps(Hashable, Protocol):
    """Formulas of a filter over scalars (`scalars.Scalar`); hashable.

    `update` depends on stamps only, and runs once for each row, on floats or traced doubles.
    `correct` runs for each joint; with arrays, for all joints at once.
    """

    @property
    def channels(self) -> int:
        """Number of values of each joint in a row."""
        ...

    @property
    def constants(self) -> int:
        """Number of constants."""
        ...

    @property
    def memory(self) -> int:
        """Number of values common to all joints; the last is the quality of the estimate."""
        ...

    @property
    def derivatives(self) -> int:
        """Number of derivatives of each joint, including its value."""
        ...

    def update(self, constants: Scalars, memory: Scalars, dt: Scalar) -> tuple[Scalars, Scalars]:
        """Memory after an interval [s] and a row of samples, and the gains of that row."""
        ...

    def correct(
        self, derivatives: Scalars, dt: Scalar, gains: Scalars, samples: Scalars
    ) -> Scalars:
        """Derivatives of a joint after an interval [s] and its samples of a row."""
        ...
