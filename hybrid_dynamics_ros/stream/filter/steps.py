"""The contract of a filter's formulas: what it does with a row of samples."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Protocol

from .scalars import Scalar, Scalars


class Steps(Hashable, Protocol):
    """A filter, written once over scalars (`scalars.Scalar`). Hashable.

    What depends on the stamps alone is done once a row, for all joints: `update` takes and gives
    floats or doubles of compiled code. `correct` is done for each joint: with arrays it takes all.
    """

    @property
    def channels(self) -> int:
        """Values that each joint has in a row of samples."""
        ...

    @property
    def constants(self) -> int:
        """Numbers that stay as they are."""
        ...

    @property
    def memory(self) -> int:
        """Numbers that the joints share. The last says how good the estimate is."""
        ...

    @property
    def derivatives(self) -> int:
        """Derivatives that each joint has, its value among them."""
        ...

    def update(self, constants: Scalars, memory: Scalars, dt: Scalar) -> tuple[Scalars, Scalars]:
        """Memory after an interval [s] and a row of samples, and the gains of that row."""
        ...

    def correct(
        self, derivatives: Scalars, dt: Scalar, gains: Scalars, samples: Scalars
    ) -> Scalars:
        """Derivatives of a joint after an interval [s] and its samples of a row."""
        ...
