"""Further poses to measure, chosen from candidates so that parameters become as exact as possible.

The choice is D-optimal: it makes the determinant of the information large, that is the volume of
the confidence region small. Poses are added one by one, then exchanged while that helps: Fedorov
(1972), Theory of Optimal Experiments.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..errors import InputError
from ..formats.tables import Table, table_of
from ..ground.arrays import Array
from ..ground.check_arguments import integer
from ..ground.file_options import PathText
from .adjustable import AdjustableRobot
from .calibrate import Data, names_of
from .fit import PRIOR
from .free_robot import FreeRobot
from .noise import Sigma, noise_of
from .observations import TOOL, Observations, observe
from .result import Calibration
from .sensitivity import Sensitivity

POINT = (f"{TOOL}.x", f"{TOOL}.y", f"{TOOL}.z")
ROUNDS = 20  # of exchanges
GAIN = 1e-9  # of the logarithm of the determinant that counts as better


@dataclass(frozen=True)
class PoseChoice:
    """Poses to measure.

    Attributes:
        rows: indices of the chosen candidates, the most useful first.
        lines: their lines in the file of candidates, or numbers from 1.
        poses: coordinates of each by name [rad, m].
        deviations: expected standard deviation of each parameter [rad, m].
        before: the deviations without the chosen poses [rad, m].
    """

    rows: tuple[int, ...]
    lines: tuple[int, ...]
    poses: tuple[dict[str, float], ...]
    deviations: dict[str, float]
    before: dict[str, float]


def choose_poses(
    robot: PathText,
    candidates: Data,
    free: str | Iterable[str],
    count: int,
    sigma: Sigma = 1e-4,
    after: Calibration | None = None,
) -> PoseChoice:
    """Choose the poses, of some candidates, that show the parameters best.

    Args:
        robot: name of a shipped robot, or path of a file.
        candidates: poses as columns of coordinates: a CSV file, or columns (N,) by name. Other
            columns say what will be measured, whatever their values; the tool's point by default.
        free: paths of the parameters.
        count: number of poses to choose; a candidate is chosen once at most.
        sigma: standard deviation of the measurements, as in `calibrate`.
        after: a calibration of the same parameters, whose measurements count too. The same will be
            measured.

    Raises:
        InputError: a path or column is wrong, or there are fewer candidates than poses.
    """
    adjustable = AdjustableRobot(robot)
    free_robot = FreeRobot(adjustable, adjustable.parameters(names_of(free)))
    table = table_of(candidates)
    number = integer("count", count)
    if number > len(table.lines):
        raise InputError(f"count: {number} poses of {len(table.lines)} candidates")
    coordinates = free_robot.robot.coordinates
    measured = tuple(name for name in table.columns if name not in coordinates)
    if after is not None:
        measured = after.measured
    observations = planned(free_robot, table, measured or POINT)
    sensitivity = Sensitivity(free_robot, observations)
    rows = _information(sensitivity, observations, sigma)
    start = _start(sensitivity, after)
    chosen = exchanged(rows, start, greedy(rows, start, number))
    total = start + rows[chosen].sum(axis=0)
    return PoseChoice(
        rows=tuple(chosen),
        lines=tuple(table.lines[k] for k in chosen),
        poses=tuple(_pose(observations, k) for k in chosen),
        deviations=_deviations(sensitivity, total),
        before=_deviations(sensitivity, start),
    )


def planned(free_robot: FreeRobot, table: Table, measured: Sequence[str]) -> Observations:
    """Observations of candidates, as if the robot of the file were measured without noise."""
    count = len(table.lines)
    columns: dict[str, Array] = {}
    for name in free_robot.robot.coordinates:
        if name in table.columns:
            columns[name] = table.columns[name]
    for name in measured:
        columns[name] = np.zeros(count)
        if name.endswith(".qw"):
            columns[name] += 1.0
    observations = observe(free_robot, replace(table, columns=columns))
    posed = observations.closed.poses()
    exact = tuple(quantity.predicted(posed) for quantity in observations.quantities)
    return replace(observations, measured=exact)


def _information(sensitivity: Sensitivity, observations: Observations, sigma: Sigma) -> Array:
    """Information (N, k, k) of each candidate, in natural units [1/m^2]."""
    start = sensitivity.at_start()
    noise = noise_of(observations.quantities, sigma, start.differences)
    rows = sensitivity.jacobian(start) / noise.by_component[:, None]
    transposed = np.swapaxes(rows, 1, 2)
    return np.asarray(transposed @ rows)


def _start(sensitivity: Sensitivity, after: Calibration | None) -> Array:
    """Information (k, k) before any candidate is measured: of former data, or of the prior."""
    scales = sensitivity.scales
    if after is None:
        deviation = PRIOR * sensitivity.reach
        unit = np.eye(len(scales))
        return np.asarray(unit / deviation**2)
    names = [one.name for one in sensitivity.free_robot.parameters]
    if list(after.parameters) != names:
        raise InputError("after: is a calibration of other parameters")
    natural = after.covariance * np.outer(scales, scales)
    return np.asarray(np.linalg.inv(natural))


def greedy(rows: Array, start: Array, count: int) -> list[int]:
    """The candidates that add most, one after the other."""
    chosen: list[int] = []
    total = start
    for _ in range(count):
        gains = _log_determinants(total + rows)
        gains[chosen] = -np.inf
        best = int(np.argmax(gains))
        chosen.append(best)
        total = total + rows[best]
    return chosen


def exchanged(rows: Array, start: Array, chosen: list[int]) -> list[int]:
    """The choice after exchanges with candidates that are better."""
    chosen = list(chosen)
    for _ in range(ROUNDS):
        is_better = False
        for place, row in enumerate(chosen):
            others = [one for one in chosen if one != row]
            total = start + rows[others].sum(axis=0)
            gains = _log_determinants(total + rows)
            gains[others] = -np.inf
            best = int(np.argmax(gains))
            if gains[best] > gains[row] + GAIN:
                chosen[place] = best
                is_better = True
        if not is_better:
            break
    return chosen


def _log_determinants(matrices: Array) -> Array:
    """Logarithms (N,) of determinants (N, k, k), whatever their units."""
    diagonals = np.sqrt(np.einsum("nii->ni", matrices))
    products = diagonals[:, :, None] * diagonals[:, None, :]
    _, logarithms = np.linalg.slogdet(matrices / products)
    of_diagonals = 2.0 * np.log(diagonals).sum(axis=1)
    return np.asarray(logarithms + of_diagonals)


def _deviations(sensitivity: Sensitivity, information: Array) -> dict[str, float]:
    """Deviation of each parameter [rad, m]."""
    covariance = np.linalg.inv(information)
    deviations = np.sqrt(np.diag(covariance)) / sensitivity.scales
    names = [parameter.name for parameter in sensitivity.free_robot.parameters]
    return dict(zip(names, deviations.tolist(), strict=True))


def _pose(observations: Observations, row: int) -> dict[str, float]:
    values = observations.readings[row].tolist()
    return dict(zip(observations.given, values, strict=True))
