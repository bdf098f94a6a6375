"""Base parameters: the combinations of parameters that motion and efforts can show, by QR with column pivoting.

Gautier (1991), doi 10.1002/rob.4620080405, on the regressor of the closed mechanism.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr, solve_triangular

from ..dynamics.loads import Loads
from ..dynamics.parameters import Parameters, described_parameters
from ..errors import InputError
from ..ground.arrays import Array
from ..robot.robot import Robot
from .excite import random_motion

RANK = 1e-9  # far above rounding, and below what any measurement could tell
NO_EFFECT = (
    1e-12  # largest entry of a column, in parts of the largest of all, below which it has no effect
)
RATE, ACCELERATION = (
    3.0,
    10.0,
)  # [rad or m per second, per second squared] fast enough to show every product of rates
SHOWN = 1e-9  # coefficient below which a term is left out of a name


@dataclass(frozen=True, eq=False)
class BaseParameters:
    """b combinations beta = `combine` pi of the p parameters, of which tau is the linear function Y[:, `kept`] beta.

    Attributes:
        parameters: the p parameters they are made of.
        kept: (b,) indices of the parameter that leads each combination (its coefficient is 1).
        combine: (b, p).
        invisible: names of the parameters that no motion shows, in any combination.
        condition: condition number of the columns kept, over random motion.
    """

    parameters: Parameters
    kept: np.ndarray
    combine: Array
    invisible: tuple[str, ...]
    condition: float

    @property
    def size(self) -> int:
        """How many there are, b."""
        return len(self.kept)

    @property
    def names(self) -> tuple[str, ...]:
        """Each combination in words, such as 'l2.mx + 0.7 l3.m'."""
        return tuple(self._name(row) for row in self.combine)

    def values(self, parameters: Array) -> Array:
        """beta (b,) of parameters (p,)."""
        return np.asarray(self.combine @ parameters)

    def _name(self, row: Array) -> str:
        lead = int(
            np.argmax((np.arange(len(row))[:, None] == self.kept).any(axis=1) & (row == 1.0))
        )
        text = self.parameters.names[lead]
        for k, factor in enumerate(row):
            if k != lead and abs(factor) > SHOWN:
                size = "" if abs(abs(factor) - 1.0) < SHOWN else f"{abs(factor):.4g} "
                text += f" {'+' if factor > 0 else '-'} {size}{self.parameters.names[k]}"
        return text


def base_parameters(
    robot: Robot,
    parameters: Parameters | None = None,
    loads: Loads | None = None,
    count: int = 0,
    seed: int = 0,
    tolerance: float = RANK,
) -> BaseParameters:
    """The base parameters of a robot, found over `count` random states (0: enough for the number of parameters).

    tolerance: pivot, in parts of the largest, below which a column counts as a combination of those
    before.
    """
    parameters = described_parameters(robot.description) if parameters is None else parameters
    names = parameters.names
    count = count or 20 + 4 * len(names) // max(len(robot.active), 1)
    state, ddu = random_motion(robot, count, seed, RATE, ACCELERATION)
    matrix = robot.regressor(state, ddu, parameters, loads).reshape(-1, len(names))
    sizes = np.linalg.norm(matrix, axis=0)
    seen = np.flatnonzero(sizes > NO_EFFECT * sizes.max(initial=0.0))
    if not len(seen):
        raise InputError("no parameter has any effect on tau")
    triangle, order = qr(matrix[:, seen] / sizes[seen], mode="r", pivoting=True)
    pivots = np.abs(np.diag(triangle))
    rank = int((pivots > tolerance * pivots[0]).sum())
    kept, others = seen[order[:rank]], seen[order[rank:]]
    mixing = solve_triangular(triangle[:rank, :rank], triangle[:rank, rank:])
    combine = np.zeros((rank, len(names)))
    combine[np.arange(rank), kept] = 1.0
    combine[:, others] = mixing * sizes[others] / sizes[kept][:, None]
    combine[np.abs(combine) < SHOWN] = 0.0
    by_index = np.argsort(kept)
    kept, combine = kept[by_index], combine[by_index]
    condition = float(np.linalg.cond(triangle[:rank, :rank]))
    invisible = tuple(names[k] for k in range(len(names)) if k not in seen)
    return BaseParameters(parameters, kept, combine, invisible, condition)
