"""The result of a calibration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..description.model import RobotDescription
from ..ground.arrays import Array
from .adjustable import AdjustableRobot, FreeParameter
from .unseen import Unseen


@dataclass(frozen=True)
class Estimate:
    """A parameter.

    Attributes:
        value: its estimate [rad, m].
        interval: where it lies with 95 % confidence [rad, m].
        start: value in the file [rad, m].
        deviation: standard deviation [rad, m].
        identifiable: whether the measurements show it. If not, the value is the one nearest to the
            file with which the others fit.
        unit: `m` or `rad`; empty if the file does not say.
    """

    value: float
    interval: tuple[float, float]
    start: float
    deviation: float
    identifiable: bool
    unit: str

    @property
    def change(self) -> float:
        """The value less that of the file [rad, m]."""
        return self.value - self.start

    @property
    def half(self) -> float:
        """Half the width of the interval [rad, m]."""
        low, high = self.interval
        return 0.5 * (high - low)


@dataclass(frozen=True)
class Misfit:
    """Residuals of one quantity, root mean squares [m or rad].

    Attributes:
        before: with the file as it is.
        after: with the estimate.
        held_out: of each row, with the estimate from all other rows.
        sigma: standard deviation of the noise, given or estimated.
        unit: `m` or `rad`.
    """

    before: float
    after: float
    held_out: float
    sigma: float
    unit: str


@dataclass(frozen=True)
class OutlyingRow:
    """A measurement that does not fit the others.

    Attributes:
        place: file and line, or number of the row.
        line: line in the file, or number of the row from 1.
        quantity: what was measured.
        deviations: its residual over the deviation of the noise.
    """

    place: str
    line: int
    quantity: str
    deviations: float


@dataclass(frozen=True, eq=False)
class Calibration:
    """Geometric parameters from measurements.

    Attributes:
        parameters: estimates by path.
        chi2: reduced chi-squared: 1 if the residuals are as large as the noise.
        freedom: degrees of freedom.
        unseen: combinations that no measurement shows.
        fixed: reason by path of each parameter that the structure of the robot does not allow to
            change; it keeps its value.
        outliers: measurements that do not fit the others.
        misfits: residuals by quantity.
        covariance: of the parameters (k, k), in the order of `parameters`.
        residuals: model minus measurement (N, c) [m, rad]; NaN where nothing was measured.
        components: name of each column of the residuals.
        measured: columns of the data that were measured.
        unused: columns of the data that are not used.
        description: the robot with the estimates.
        free: the free parameters.
        robot: the robot that was calibrated.
    """

    parameters: Mapping[str, Estimate]
    chi2: float
    freedom: float
    unseen: tuple[Unseen, ...]
    fixed: Mapping[str, str]
    outliers: tuple[OutlyingRow, ...]
    misfits: Mapping[str, Misfit]
    covariance: Array
    residuals: Array
    components: tuple[str, ...]
    measured: tuple[str, ...]
    unused: tuple[str, ...]
    description: RobotDescription
    free: tuple[FreeParameter, ...]
    robot: AdjustableRobot

    @property
    def identifiable(self) -> Mapping[str, bool]:
        """Whether the measurements show a parameter, by path."""
        return {name: one.identifiable for name, one in self.parameters.items()}

    @property
    def values(self) -> Array:
        """The estimates (k,) [rad, m]."""
        return np.array([one.value for one in self.parameters.values()])
