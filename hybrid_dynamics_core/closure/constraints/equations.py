"""What every loop closure can say of itself: its equations, their Jacobian and their bias, at any configuration."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from ...algebra.scalar import Scalar
from ...mechanism.configuration import Configuration

Row = dict[int, Scalar]  # coordinate -> coefficient, zeros left out


class Linearised(NamedTuple):
    """Rows of J_s (J_s s' = 0) and residuals of the equations; lengths are divided by the loop's length."""

    rows: list[Row]
    residual: list[Scalar]


class LoopEquations(ABC):
    """Some scalar equations of one loop.

    `involved`: per equation, the coordinates it can depend on.
    """

    name: str
    length: float  # [m], makes the equations dimensionless
    involved: tuple[frozenset[int], ...]

    @property
    def size(self) -> int:
        """Number of equations."""
        return len(self.involved)

    @property
    def coordinates(self) -> list[int]:
        """All coordinates of the loop, in order."""
        return sorted(frozenset().union(*self.involved))

    @abstractmethod
    def linearise(self, configuration: Configuration) -> Linearised:
        """Rows of J_s and residuals."""

    @abstractmethod
    def bias(self, configuration: Configuration, rates: Sequence[Scalar]) -> list[Scalar]:
        """(d/dt J_s) s' of each equation [1/s^2] at a closed configuration."""

    def marks(self, configuration: Configuration) -> list[Scalar]:  # noqa: ARG002
        """Where the loop puts its links: equal where two sets of joint values mean the same configuration."""
        return []

    def gaps(self, configuration: Configuration) -> list[float]:
        """How far each equation is from closed, at a configuration of floats: where a search from afar has to go.

        The residuals, unless these vanish at places that the guards refuse.
        """
        return [float(r) for r in self.linearise(configuration).residual]

    def guards(self, configuration: Configuration) -> list[Scalar]:  # noqa: ARG002  most closures need none
        """Scalars that must be positive: what the equations alone cannot tell, such as a frame turned half round."""
        return []


@dataclass(frozen=True)
class Equation:
    """One scalar equation of a loop."""

    loop: LoopEquations
    index: int

    @property
    def involved(self) -> frozenset[int]:
        """Coordinates it can depend on."""
        return self.loop.involved[self.index]
