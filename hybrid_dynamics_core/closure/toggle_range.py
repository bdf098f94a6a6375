"""How far a coordinate may go before its loop opens: the range between the toggle points."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from ..ground.arrays import Array
from ..mechanism.configuration import Configuration
from ..mechanism.tree import Tree
from .blocks.block_solver import BlockSolver

Flags = NDArray[np.bool_]
_SAMPLES = 2001  # a range narrower than 1/2000 of the searched one may be missed
_SPAN = 6.0  # searched displacements, in lengths of the loop
_PRECISION = 1e-14  # [rad or m] of an end of the range


class _ClosingMargin:
    """The margin of a block as a function of one coordinate it depends on."""

    def __init__(
        self, tree: Tree, block: BlockSolver, configuration: Configuration, coordinate: int
    ) -> None:
        self.block = block
        self.configuration = configuration
        self.coordinate = coordinate
        self.guess = [0.0] * len(tree.coordinates)
        self.revolute = tree.is_revolute(coordinate)

    def of(self, values: Array) -> Array:
        """Margins (N,) at values (N,) [rad or m]."""
        trial = self.configuration.copy()
        trial.set_value(self.coordinate, values, revolute=self.revolute)
        with np.errstate(all="ignore"):
            margin = self.block.solve(trial, 1.0, self.guess)
        return np.broadcast_to(np.asarray(margin, dtype=float), values.shape)

    def at(self, value: float) -> float:
        """Margin at one value [rad or m]."""
        return float(self.of(np.array([value]))[0])

    def searched(self, near: float) -> Array:
        """Values about `near` that are tried (N,) [rad or m]."""
        half = math.pi
        if not self.revolute:
            half = _SPAN * max(equation.loop.length for equation in self.block.equations)
        return near + half * np.linspace(-1.0, 1.0, _SAMPLES)


def allowed_range(
    tree: Tree, block: BlockSolver, configuration: Configuration, coordinate: int, near: float
) -> tuple[float, float] | None:
    """The interval of a coordinate in which a block closes.

    Args:
        tree: the spanning tree.
        block: the block.
        configuration: values of all other coordinates that the block depends on, floats.
        coordinate: the coordinate, one that the block depends on.
        near: of several intervals, the one nearest to this [rad or m].

    Returns:
        Its ends [rad or m]. (-inf, inf) where the block always closes, None where it never does.
    """
    margin = _ClosingMargin(tree, block, configuration, coordinate)
    values = margin.searched(near)
    closes = margin.of(values) > 0.0
    if closes.all():
        return -math.inf, math.inf
    if not closes.any():
        return None
    distances = np.where(closes, np.abs(values - near), np.inf)
    inside = int(np.argmin(distances))
    lower = _end(margin, values, closes, inside, -1)
    upper = _end(margin, values, closes, inside, 1)
    return lower, upper


def _end(margin: _ClosingMargin, values: Array, closes: Flags, inside: int, way: int) -> float:
    """The end of the interval around a value inside, in one direction (-1 or +1)."""
    k = inside
    while 0 <= k + way < len(values) and closes[k + way]:
        k += way
    if not 0 <= k + way < len(values):
        return way * math.inf
    low, high = sorted((values[k], values[k + way]))
    end: float = brentq(margin.at, low, high, xtol=_PRECISION)
    return end
