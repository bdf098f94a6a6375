"""One block of the closure plan: as many equations as unknown coordinates, solved together."""

from __future__ import annotations

from abc import ABC, abstractmethod

from ...algebra.scalar import Scalar, Scalars
from ...mechanism.configuration import Configuration
from ..constraints.equations import Equation

# names of assembly modes
ONLY = ("only",)
ORIENTATIONS = ("counterclockwise", "clockwise")
STROKES = ("extended", "retracted")
SIDES = ("front", "back")


class BlockSolver(ABC):
    """Solves some unknowns from the coordinates that come before them.

    Attributes:
        equations: its part of J_z.
        unknowns: the coordinates it solves for, as many as there are equations, or fewer where
            redundant ones are solved by least squares with the others.
        modes: names of its assembly modes, the first for the branch sign +1, the second for -1.
        iterates: whether it is solved by iteration; the margin is then the number of iterations.
        modes_fixed: the mode that the plan chose is kept, since another one gives the same poses.
        order: order of the equations in which elimination needs not pivot near the reference; empty
            for the order that they have.
        length: length of its loops [m] where it is an argument of programs, otherwise None.
        meets_guards: whether its solution makes the guards of its loop positive.
        needs_mode: whether the file must name the mode; if not, the one nearest to zero is taken.
    """

    equations: tuple[Equation, ...]
    unknowns: tuple[int, ...]
    modes: tuple[str, ...] = ONLY
    iterates = False
    modes_fixed = False
    meets_guards = False
    needs_mode = False
    order: tuple[int, ...] = ()
    length: Scalar = None

    @property
    def loops(self) -> tuple[str, ...]:
        """Names of the loops that this block closes."""
        return tuple(dict.fromkeys(equation.loop.name for equation in self.equations))

    @property
    def name(self) -> str:
        """The loops' names, joined."""
        return "+".join(self.loops)

    @property
    def row_loops(self) -> list[str]:
        """The loop of each row of J_s; of combined equations all of their loops, joined."""
        if len(self.equations) > len(self.unknowns):
            return [self.name] * len(self.unknowns)
        return [equation.loop.name for equation in self.equations]

    @property
    def inputs(self) -> list[int]:
        """Coordinates that the equations depend on besides the unknowns."""
        involved = frozenset().union(*(equation.involved for equation in self.equations))
        return sorted(involved - set(self.unknowns))

    @property
    def counted_turns(self) -> frozenset[int]:
        """Coordinates whose whole turns change the equations, such as those of gears."""
        return frozenset().union(*(equation.loop.counted_turns for equation in self.equations))

    @property
    def signs(self) -> tuple[float, ...]:
        """The branch signs of the modes."""
        return (1.0, -1.0)[: len(self.modes)]

    @abstractmethod
    def solve(self, configuration: Configuration, branch: Scalar, guess: Scalars) -> Scalar:
        """Fill in the unknowns.

        Args:
            configuration: coordinates, with all `inputs` set.
            branch: sign of the assembly mode, +1 or -1.
            guess: all coordinates s (n_s,) of a configuration nearby [rad, m]. Iterations start
                there, and angles are within half a turn of it.

        Returns:
            The margin, dimensionless. It is positive where the block closes, negative or NaN where
            it cannot.
        """
