"""Base parameters: the combinations of parameters that motion and efforts can identify.

They come from a QR decomposition with column pivoting, Gautier (1991), doi 10.1002/rob.4620080405,
of the regressor of the closed mechanism.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..dynamics.loads import Loads
from ..dynamics.parameters import Parameters, described_parameters
from ..errors import InputError
from ..ground.arrays import Array
from ..robot.robot import Robot
from ..robot.taken import AnyRobot, robot_of
from .excite import random_motion

RANK = 1e-9  # share of the largest pivot: far above rounding, far below errors of measurements
NO_EFFECT = 1e-12  # a column shorter than this share of the longest has no effect
# largest values in random states, fast enough to excite every product of rates
RATE = 3.0  # [rad/s or m/s]
ACCELERATION = 10.0  # [rad/s^2 or m/s^2]
SHOWN = 1e-9  # coefficients below this are set to zero in `combine`


@dataclass(frozen=True, eq=False)
class BaseParameters:
    """The b combinations of p parameters that the efforts depend on.

    With the regressor Y, tau = Y pi for all parameters pi. With the combinations
    beta = `combine` pi, tau = Y[:, `kept`] beta.

    Attributes:
        parameters: the p parameters.
        kept: (b,) index of the leading parameter of each combination. It has the coefficient 1, and
            is in no other combination.
        combine: (b, p) coefficients.
        invisible: names of the parameters in no combination, which no motion can identify.
        condition: condition number of the regressor columns `kept`, scaled to unit length, over
            random motion.
    """

    parameters: Parameters
    kept: np.ndarray
    combine: Array
    invisible: tuple[str, ...]
    condition: float

    @property
    def size(self) -> int:
        """The number of combinations, b."""
        return len(self.kept)

    @property
    def names(self) -> tuple[str, ...]:
        """Each combination in words, such as 'l2.mx + 0.7 l3.m'."""
        return tuple(self._name(row) for row in self.combine)

    def values(self, parameters: Array) -> Array:
        """beta (b,) of parameters (p,)."""
        return np.asarray(self.combine @ parameters)

    def _name(self, row: Array) -> str:
        indices = np.arange(len(row))
        leads = np.isin(indices, self.kept) & (row == 1.0)
        lead = int(np.argmax(leads))
        text = self.parameters.names[lead]
        for k, factor in enumerate(row):
            if k != lead and abs(factor) > SHOWN:
                text += _term(factor, self.parameters.names[k])
        return text


def _term(factor: float, name: str) -> str:
    """A further term of a combination: ` + 0.7 l3.m`, ` - l3.m`."""
    sign = "+" if factor > 0 else "-"
    size = abs(factor)
    if abs(size - 1.0) < SHOWN:
        return f" {sign} {name}"
    return f" {sign} {size:.4g} {name}"


def joint_rows(robot: Robot, joints: Sequence[str]) -> list[int]:
    """Indices of some joints in `robot.active`; raises InputError for other names."""
    for name in joints:
        if name not in robot.active:
            raise InputError(f"'{name}' is no active joint; they are {', '.join(robot.active)}")
    return [robot.active.index(name) for name in joints]


def base_parameters(  # noqa: PLR0913, PLR0917 - a question with details
    robot: AnyRobot,
    parameters: Parameters | None = None,
    loads: Loads | None = None,
    count: int = 0,
    seed: int = 0,
    tolerance: float = RANK,
    joints: Sequence[str] | None = None,
) -> BaseParameters:
    """The base parameters of a robot, from its regressor in random states.

    Args:
        robot: the model, or its description.
        parameters: the parameters to combine; None: inertias of all links with mass.
        loads: loads besides the actuators; None: those of the description.
        count: number of states; 0: enough for the number of parameters.
        seed: seed of the random states.
        tolerance: a column whose pivot is below this share of the largest counts as a combination
            of the columns before it.
        joints: active joints whose efforts are measured; None: all.

    Returns:
        The combinations.

    Raises:
        InputError: no parameter has any effect on tau.
    """
    from scipy.linalg import qr, solve_triangular  # noqa: PLC0415  slow to import

    robot = robot_of(robot)
    if parameters is None:
        parameters = described_parameters(robot.description)
    names = parameters.names
    rows = joint_rows(robot, robot.active if joints is None else joints)
    if not count:
        equations = max(len(rows), 1)
        count = 20 + 4 * len(names) // equations
    state, ddu = random_motion(robot, count, seed, RATE, ACCELERATION)
    regressor = robot.regressor(state, ddu, parameters, loads)[:, rows]
    matrix = regressor.reshape(-1, len(names))
    sizes = np.linalg.norm(matrix, axis=0)
    effective = np.flatnonzero(sizes > NO_EFFECT * sizes.max(initial=0.0))
    if not len(effective):
        raise InputError("no parameter has any effect on tau")
    scaled = matrix[:, effective] / sizes[effective]  # makes units of parameters irrelevant
    triangle, order = qr(scaled, mode="r", pivoting=True)
    rank = numerical_rank(triangle, tolerance)
    leads = effective[order[:rank]]
    others = effective[order[rank:]]
    # scaled columns: others = leads @ mixing, so parameters of `others` add to those of `leads`
    lead_triangle = triangle[:rank, :rank]
    mixing = solve_triangular(lead_triangle, triangle[:rank, rank:])
    combine = np.zeros((rank, len(names)))
    combine[np.arange(rank), leads] = 1.0
    lead_sizes = sizes[leads][:, None]
    combine[:, others] = mixing * sizes[others] / lead_sizes
    combine[np.abs(combine) < SHOWN] = 0.0
    by_index = np.argsort(leads)
    invisible = [name for k, name in enumerate(names) if k not in effective]
    return BaseParameters(
        parameters=parameters,
        kept=leads[by_index],
        combine=combine[by_index],
        invisible=tuple(invisible),
        condition=float(np.linalg.cond(lead_triangle)),
    )


def numerical_rank(triangle: Array, tolerance: float) -> int:
    """Rank of the triangle of a QR decomposition with column pivoting.

    Args:
        triangle: (k, p).
        tolerance: pivots above this share of the largest count.
    """
    pivots = np.abs(np.diag(triangle))
    return int((pivots > tolerance * pivots[0]).sum())
