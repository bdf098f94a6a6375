"""What every program works on: the model of a robot, its named input vectors, its status codes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..algebra.scalar import Scalar
from ..closure.plan import ClosurePlan
from ..kernels.trace import Results
from ..mechanism.tree import Tree

Scalars = Sequence[Scalar]


@dataclass(frozen=True)
class Model:
    """What the programs compute with: the tree and the plan that closes its loops."""

    tree: Tree
    plan: ClosurePlan

    def size(self, name: str) -> int:
        """Length of an input vector."""
        n = len(self.plan.given)
        sizes = {"branch": len(self.plan.steps), "guess": len(self.tree.coordinates), "gravity": 3}
        return sizes.get(name, n)


@dataclass(frozen=True)
class Inputs:
    """Input vectors; a program has those that it names.

    Active coordinates, rates, accelerations; branch sign of each step; s where iterations start; gravity [m/s^2].
    """

    u: Scalars = ()
    du: Scalars = ()
    ddu: Scalars = ()
    branch: Scalars = ()
    guess: Scalars = ()
    gravity: Scalars = ()


@dataclass(frozen=True)
class Program:
    """The names of the input vectors it needs, in order, and the text."""

    inputs: tuple[str, ...]
    run: Callable[[Model, Inputs], Results]


def closure_code(step: int) -> int:
    """Status of a state in which the step cannot close."""
    return 2 * step + 1


def singular_code(step: int) -> int:
    """Status of a state in which the step is singular."""
    return 2 * step + 2
