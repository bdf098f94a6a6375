"""One block of the closure plan: as many equations as unknown coordinates, solved together."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from ...algebra.scalar import Scalar
from ...mechanism.configuration import Configuration
from ..constraints.equations import Equation

ONLY = ("only",)


class Step(ABC):
    """Solves `unknowns` from coordinates already known.

    `equations` give its part of J_z; `modes` are its assembly modes: the branch sign +1 is the
    first, -1 the second.
    """

    equations: tuple[Equation, ...]
    unknowns: tuple[int, ...]
    modes: tuple[str, ...] = ONLY
    iterates = False  # whether the margin is a number of iterations
    needs_mode = (
        False  # whether the file must tell the mode; otherwise the one nearest zero is taken
    )

    @property
    def loops(self) -> tuple[str, ...]:
        """Names of the loops that this block closes."""
        return tuple(dict.fromkeys(equation.loop.name for equation in self.equations))

    @property
    def name(self) -> str:
        """The loops' names, joined."""
        return "+".join(self.loops)

    @property
    def known(self) -> list[int]:
        """Coordinates that the block's equations depend on and that must be known before."""
        involved = frozenset().union(*(equation.involved for equation in self.equations))
        return sorted(involved - set(self.unknowns))

    @abstractmethod
    def solve(
        self, configuration: Configuration, branch: Scalar, guess: Sequence[Scalar]
    ) -> Scalar:
        """Fill in the unknowns on the branch (+1 or -1); `guess`: per coordinate, where an iteration starts.

        Returns the margin, dimensionless: positive where the block closes, negative or NaN where it
        cannot.
        """
