"""The interface of loop closures: equations, Jacobian and bias at any configuration."""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from ...algebra.scalar import Scalar, Scalars
from ...mechanism.configuration import Configuration

# residual, in lengths of the loop, above which an equation does not hold
OPEN = 1e-6

Row = dict[int, Scalar]  # coordinate -> coefficient, zeros omitted


def coefficients(row: Row, coordinates: Iterable[int]) -> list[Scalar]:
    """The coefficients of some coordinates in a row."""
    return [row.get(k, 0.0) for k in coordinates]


class Linearised(NamedTuple):
    """Equations at a configuration, lengths divided by the loop's length.

    Attributes:
        rows: rows of J_s, where J_s s' = 0.
        residual: value of each equation.
    """

    rows: list[Row]
    residual: list[Scalar]


class LoopEquations(ABC):
    """Some scalar equations of one loop.

    Attributes:
        name: name of the closure.
        length: a length [m] that makes the equations dimensionless, by closure/loop_length.py.
        involved: per equation, the coordinates it can depend on.
    """

    name: str
    length: float
    involved: tuple[frozenset[int], ...]
    # coordinates whose whole turns change the equations
    counted_turns: frozenset[int] = frozenset()
    has_length = True  # False for equations of angles alone

    @property
    def size(self) -> int:
        """Number of equations."""
        return len(self.involved)

    @property
    def unit(self) -> float:
        """The factor that makes the equations dimensionless."""
        return 1.0

    def unscaled(self) -> LoopEquations:
        """The same equations without that factor."""
        other = copy.copy(self)
        other.length = 1.0
        return other

    @property
    def coordinates(self) -> list[int]:
        """All coordinates of the loop, in order."""
        return sorted(frozenset().union(*self.involved))

    @abstractmethod
    def linearise(self, configuration: Configuration) -> Linearised:
        """Rows of J_s and residuals."""

    @abstractmethod
    def bias(self, configuration: Configuration, rates: Scalars) -> list[Scalar]:
        """(d/dt J_s) s' of each equation [1/s^2] at a closed configuration."""

    def extent(self, configuration: Configuration) -> float:
        """Largest constant distance [m] between joint axes and pins of the loop, or 0.

        It does not depend on origins of frames. The configuration is of floats.
        """
        return 0.0

    def reach(self, configuration: Configuration) -> float:
        """The extent [m], or the length where there is none: how far a search should go."""
        return self.extent(configuration) or self.length

    def marks(self, configuration: Configuration) -> list[Scalar]:
        """Numbers that are equal for two sets of joint values if the links have the same poses."""
        return []

    def gaps(self, configuration: Configuration, residual: list[Scalar]) -> list[Scalar]:
        """Gaps of the equations, for searches that start far away.

        They are the residuals, unless these vanish where the guards are negative.

        Args:
            configuration: configuration of floats or arrays.
            residual: residual of the equations there, as `linearise` gives it.
        """
        return residual

    def guards(self, configuration: Configuration) -> list[Scalar]:
        """Scalars that must be positive where the equations hold.

        They exclude solutions that do not close the loop, such as a frame turned by half a turn.
        """
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


def equations_of(loops: Iterable[LoopEquations]) -> list[Equation]:
    """All equations of some loops, in order."""
    equations: list[Equation] = []
    for loop in loops:
        equations += [Equation(loop, k) for k in range(loop.size)]
    return equations


def loops_of(equations: Sequence[Equation]) -> list[LoopEquations]:
    """The loops of some equations, each once, in order."""
    return list(dict.fromkeys(equation.loop for equation in equations))
