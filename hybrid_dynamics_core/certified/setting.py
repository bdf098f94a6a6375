"""Where a block is solved, and what is known of its solutions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ..ground.arrays import Array
from ..mechanism.configuration import Configuration
from ..mechanism.tree import Tree


class BlockModes(NamedTuple):
    """Certified solutions of a block.

    Attributes:
        solutions: values of the unknowns (modes, unknowns) [rad, m].
        complete: whether they were proved to be all.
        reason: why, in a clause.
    """

    solutions: Array
    complete: bool
    reason: str


class Setting(NamedTuple):
    """Where a block is solved.

    Attributes:
        tree: the spanning tree.
        given: coordinates whose values are exact.
        configuration: values of all coordinates before the block.
        guess: all coordinates nearby [rad, m].
    """

    tree: Tree
    given: Sequence[int]
    configuration: Configuration
    guess: Sequence[float]
