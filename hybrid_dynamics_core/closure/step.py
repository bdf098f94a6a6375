"""One block of the closure plan: what every kind of block can do."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import NamedTuple

from ..algebra.scalar import Scalar
from .planar import PlanarLoop
from .posture import Posture

Row = dict[int, Scalar]  # coordinate -> coefficient, zeros left out


class Linearised(NamedTuple):
    """The block's equations at a posture, J s' = 0: one row an equation; dimensionless where lengths are scaled."""

    rows: list[Row]
    residual: list[Scalar]


class Step(ABC):
    """Solves `unknowns` (as many as its equations) from coordinates already known."""

    loop: str
    geometry: PlanarLoop
    unknowns: tuple[int, ...]
    modes: tuple[str, ...]  # assembly modes; the branch sign +1 is the first, -1 the second

    @abstractmethod
    def solve(self, posture: Posture, branch: Scalar) -> Scalar:
        """Fill in the unknowns on the branch (+1 or -1).

        Returns the margin, dimensionless: positive where the block closes, negative or NaN where it cannot.
        """

    @abstractmethod
    def linearise(self, posture: Posture) -> Linearised:
        """Rows of J_s and the residual at a closed posture."""

    @abstractmethod
    def bias(self, posture: Posture, rates: Sequence[Scalar]) -> list[Scalar]:
        """(d/dt J_s) s' for each row [1/s^2]."""
