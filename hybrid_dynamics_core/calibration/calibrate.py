"""Geometric parameters of a robot from measurements, through its closed loops."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import DescriptionError, InputError
from ..formats.tables import Table, table_of
from ..ground.arrays import Array
from ..ground.file_options import PathText
from .adjustable import AdjustableRobot
from .fit import Fitted, Fitter
from .free_robot import FreeRobot
from .loop_choices import with_general_bars
from .noise import Sigma, noise_of, rms
from .observations import WEIGHT, Observations, OpenRowsError, observe
from .outlying import LOSSES, Loss, outliers_of, without_outliers
from .result import Calibration, Estimate, Misfit, OutlyingRow
from .sensitivity import Sensitivity
from .unseen import identifiable, unseen_combinations

Data = str | Path | Mapping[str, Sequence[float] | Array]
CONFIDENCE = 0.95
LEAST_PROBABILITY = 1e-3  # probability of a chi-squared above which the given noise is believed
LEAST_FREE = 1e-9  # 1 - leverage of a row that alone determines a parameter
MOST_OPEN = 0.3  # share of rows that may close with the estimates only


def calibrate(
    robot: PathText,
    data: Data,
    free: str | Iterable[str],
    sigma: Sigma = None,
    loss: Loss = "reject",
) -> Calibration:
    """Estimate geometric parameters of a robot from measured rows.

    Each row has the given coordinates, and what was measured there: `tool.x`, `tool.y`, `tool.z`
    [m] and `tool.qx` to `tool.qw` of the end effector in base axes, the same of any other frame by
    its name, `distance.A.B` of two frames, `inclination.FRAME.x` of an axis above the horizontal
    [rad], and further coordinates, which have encoders of their own. `weight` counts a row more or
    less. What is NaN was not measured.

    Args:
        robot: name of a shipped robot, or path of a file.
        data: a CSV file with a header, or columns (N,) by name.
        free: paths of the parameters, in one text with commas or one by one.
        sigma: standard deviation of the measurements [m, rad], or by unit `m`, `rad` or by
            quantity. What is not given is estimated from the residuals.
        loss: `reject` leaves outliers out, `huber` gives them less weight, `linear` trusts all.

    Returns:
        The estimates.

    Raises:
        InputError: a path, column or option is wrong, or there are too few rows.
        DescriptionError: the robot's file is wrong.
    """
    if loss not in LOSSES:
        raise InputError(f"loss: is {loss!r}; expected one of {', '.join(LOSSES)}")
    adjustable = AdjustableRobot(robot)
    free_robot = FreeRobot(adjustable, adjustable.parameters(names_of(free)))
    table = table_of(data)
    try:
        fit = _fitted(observe(free_robot, table), free_robot, sigma, loss)
        return _Results(free_robot, fit, fit.fitter.first.differences).calibration()
    except OpenRowsError as error:
        if len(error.rows) > MOST_OPEN * len(table.lines):
            raise
        return _with_open_rows(free_robot, table, error, sigma, loss)


@dataclass(frozen=True, eq=False)
class _Fit:
    """A fit with what it was made from."""

    observations: Observations
    fitter: Fitter
    fitted: Fitted


def _fitted(observations: Observations, free_robot: FreeRobot, sigma: Sigma, loss: Loss) -> _Fit:
    """The fit to observations."""
    sensitivity = Sensitivity(free_robot, observations)
    fitter = Fitter(sensitivity, row_weights(observations.table))
    noise = noise_of(observations.quantities, sigma, fitter.first.differences)
    fitted = fitter.settled(fitter.first_fit(noise))
    owners = np.array(observations.owners())
    robust = without_outliers(fitter, fitted, owners, loss)
    return _Fit(observations, fitter, robust)


def _with_open_rows(
    free_robot: FreeRobot, table: Table, error: OpenRowsError, sigma: Sigma, loss: Loss
) -> Calibration:
    """The calibration where some rows close with the estimates only, as near a dead centre.

    Raises:
        OpenRowsError: they do not close with the estimates of the other rows either.
    """
    others = _fitted(observe(free_robot, table.without(error.rows)), free_robot, sigma, loss)
    values = others.fitted.predicted.values
    try:
        observations = observe(free_robot, table, values)
    except (OpenRowsError, DescriptionError):
        raise error from None
    fit = _fitted(observations, free_robot, sigma, loss)
    return _Results(free_robot, fit, others.fitter.first.differences).calibration()


def names_of(free: str | Iterable[str]) -> list[str]:
    """The paths of a text with commas, or of a list."""
    if isinstance(free, str):
        free = free.split(",")
    return [name.strip() for name in free if name.strip()]


def row_weights(table: Table) -> Array:
    """Square roots of the weights of the rows (N,).

    Raises:
        InputError: a weight is negative or missing.
    """
    if WEIGHT not in table.columns:
        return np.ones(len(table.lines))
    weights = table.columns[WEIGHT]
    wrong = np.flatnonzero(~(weights >= 0.0))
    if len(wrong):
        row = int(wrong[0])
        raise InputError(f"{table.row(row)}: weight is {weights[row]:g}; expected zero or more")
    if not weights.any():
        raise InputError(f"{table.source}: all weights are zero; expected some above zero")
    return np.asarray(np.sqrt(weights))


class _Results:
    """Makes the result of a fit."""

    def __init__(self, free_robot: FreeRobot, fit: _Fit, before: Array) -> None:
        self.free_robot = free_robot
        self.observations = fit.observations
        self.fitter = fit.fitter
        self.fitted = fit.fitted
        self.before = before
        self.owners = np.array(fit.observations.owners())
        self.factor = self._inflation()

    def calibration(self) -> Calibration:
        """The calibration."""
        free_robot = self.free_robot
        fitted = self.fitted
        names = [parameter.name for parameter in free_robot.parameters]
        scales = self.fitter.scales
        prior = self.fitter.deviation
        values = fitted.predicted.values
        variance = self.factor**2
        described = free_robot.adjustable.described(free_robot.parameters, values)
        return Calibration(
            parameters=self._estimates(),
            chi2=fitted.chi2,
            freedom=fitted.freedom,
            unseen=tuple(unseen_combinations(names, fitted.covariance, scales, prior)),
            fixed={names[k]: problem for k, problem in free_robot.fixed.items()},
            outliers=tuple(self._outliers()),
            misfits=self._misfits(),
            covariance=variance * fitted.covariance / np.outer(scales, scales),
            residuals=fitted.predicted.differences,
            components=self._components(),
            measured=self._measured(),
            unused=self.observations.unused,
            description=with_general_bars(described, free_robot.robot),
            free=free_robot.parameters,
            robot=free_robot.adjustable,
        )

    def _inflation(self) -> float:
        """The factor of all deviations where the residuals are larger than the given noise."""
        freedom = self.fitted.freedom
        if freedom < 1.0:
            return 1.0
        from scipy import stats  # noqa: PLC0415  slow to import

        limit = float(stats.chi2.isf(LEAST_PROBABILITY, freedom)) / freedom
        chi2 = self.fitted.chi2
        return float(np.sqrt(chi2)) if chi2 > limit else 1.0

    def _quantile(self) -> float:
        """Deviations on each side of an interval."""
        from scipy import stats  # noqa: PLC0415  slow to import

        tail = 0.5 * (1.0 - CONFIDENCE)
        is_certain = all(self.fitted.noise.is_given) and self.factor == 1.0
        if is_certain:
            return float(stats.norm.isf(tail))
        freedom = max(self.fitted.freedom, 1.0)
        return float(stats.t.isf(tail, freedom))

    def _estimates(self) -> dict[str, Estimate]:
        covariance = self.fitted.covariance
        is_shown = identifiable(covariance, self.fitter.deviation)
        natural = np.sqrt(np.diag(covariance))
        deviations = self.factor * natural / self.fitter.scales
        quantile = self._quantile()
        estimates: dict[str, Estimate] = {}
        values = self.fitted.predicted.values.tolist()
        for k, parameter in enumerate(self.free_robot.parameters):
            deviation = float(deviations[k])
            half = quantile * deviation
            interval = (values[k] - half, values[k] + half)
            start = parameter.start
            estimates[parameter.name] = Estimate(
                values[k], interval, start, deviation, is_shown[k], parameter.unit
            )
        return estimates

    def _outliers(self) -> list[OutlyingRow]:
        table = self.observations.table
        rows: list[OutlyingRow] = []
        for outlier in outliers_of(self.fitter, self.fitted, self.owners):
            name = self.observations.quantities[outlier.quantity].name
            place = table.row(outlier.row)
            rows.append(OutlyingRow(place, table.lines[outlier.row], name, outlier.size))
        return rows

    def _misfits(self) -> dict[str, Misfit]:
        fitted = self.fitted
        noise = fitted.noise
        after = fitted.predicted.differences
        held_out = self._held_out()
        misfits: dict[str, Misfit] = {}
        for k, quantity in enumerate(self.observations.quantities):
            mine = self.owners == k
            is_used = fitted.weights[:, mine] > 0.0
            misfits[quantity.name] = Misfit(
                before=rms(self.before[:, mine]),
                after=rms(after[:, mine][is_used]),
                held_out=rms(held_out[:, mine][is_used]),
                sigma=float(noise.by_component[mine][0]),
                unit=quantity.unit,
            )
        return misfits

    def _held_out(self) -> Array:
        """Residuals (N, c) of each row, with the parameters from all other rows."""
        fitted = self.fitted
        rows = fitted.rows
        transposed = np.swapaxes(rows, 1, 2)
        hats = rows @ fitted.covariance @ transposed
        count = hats.shape[1]
        shares = np.eye(count) - hats
        shares += LEAST_FREE * np.eye(count)
        residuals = fitted.normalised[..., None]
        without_row = np.linalg.solve(shares, residuals)[..., 0]
        is_used = fitted.weights > 0.0
        weights = np.where(is_used, fitted.weights, np.nan)
        factors = fitted.noise.by_component / weights
        return np.asarray(without_row * factors)

    def _measured(self) -> tuple[str, ...]:
        columns: list[str] = []
        for quantity in self.observations.quantities:
            columns += quantity.columns
        return tuple(columns)

    def _components(self) -> tuple[str, ...]:
        names: list[str] = []
        for quantity in self.observations.quantities:
            columns = quantity.columns
            if quantity.size != len(columns):
                columns = tuple(f"{quantity.name} {axis}" for axis in "xyz")
            names += columns
        return tuple(names)
