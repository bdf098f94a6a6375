"""How far a coordinate may go before its loop opens: the range between the toggle points of the loop."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq

from ..ground.arrays import Array
from ..mechanism.configuration import Configuration
from ..mechanism.tree import Tree
from .blocks.block_solver import BlockSolver

_SAMPLES = 2001  # a range narrower than 1/2000 of the searched one is not told apart
_SPAN = 6.0  # searched displacements, in lengths of the loop


def allowed_range(
    tree: Tree, step: BlockSolver, configuration: Configuration, coordinate: int, near: float
) -> tuple[float, float] | None:
    """The interval of a known coordinate, nearest to `near`, in which the step closes with all else as in `configuration`.

    (-inf, inf) where it always closes, None where it never does. [rad or m]
    """
    revolute = tree.is_revolute(coordinate)
    length = max(equation.loop.length for equation in step.equations)
    half = math.pi if revolute else _SPAN * length
    grid = near + half * np.linspace(-1.0, 1.0, _SAMPLES)
    good = _margin(step, configuration, coordinate, revolute, grid) > 0.0
    if good.all():
        return -math.inf, math.inf
    if not good.any():
        return None
    inside = int(np.argmin(np.where(good, np.abs(grid - near), np.inf)))

    def edge(way: int) -> float:
        k = inside
        while 0 <= k + way < len(grid) and good[k + way]:
            k += way
        if not 0 <= k + way < len(grid):
            return way * math.inf
        bracket = sorted((grid[k], grid[k + way]))
        root: float = brentq(
            lambda q: float(_margin(step, configuration, coordinate, revolute, np.array([q]))[0]),
            *bracket,
            xtol=1e-14,
        )
        return root

    return edge(-1), edge(1)


def _margin(
    step: BlockSolver, configuration: Configuration, coordinate: int, revolute: bool, values: Array
) -> Array:
    trial = configuration.copy()
    put = trial.set_angle if revolute else trial.set_length
    put(coordinate, values)
    with np.errstate(all="ignore"):
        return np.broadcast_to(
            np.asarray(step.solve(trial, 1.0, configuration.q), dtype=float), values.shape
        )
