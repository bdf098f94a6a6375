"""Residuals on measurements that had no part in a calibration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..formats.tables import table_of
from .calibrate import Data
from .free_robot import FreeRobot
from .noise import rms
from .observations import observe
from .result import Calibration


@dataclass(frozen=True)
class Validation:
    """Residuals of one quantity on other measurements, root mean squares [m or rad].

    Attributes:
        before: with the file as it was.
        after: with the estimates.
        unit: `m` or `rad`.
    """

    before: float
    after: float
    unit: str


def validate(calibration: Calibration, data: Data) -> dict[str, Validation]:
    """Residuals on other measurements, by quantity.

    Args:
        calibration: the result.
        data: a CSV file with a header, or columns (N,) by name, as in `calibrate`.

    Raises:
        InputError: a column is wrong, or a row does not close.
    """
    free_robot = FreeRobot(calibration.robot, calibration.free)
    table = table_of(data)
    old = observe(free_robot, table)
    new = observe(free_robot, table, calibration.values)
    before = old.differences(old.closed.poses())
    after = new.differences(new.closed.poses())
    owners = np.array(new.owners())
    results: dict[str, Validation] = {}
    for k, quantity in enumerate(new.quantities):
        mine = owners == k
        sizes = rms(before[:, mine]), rms(after[:, mine])
        results[quantity.name] = Validation(*sizes, quantity.unit)
    return results
