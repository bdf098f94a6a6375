"""Equations of weighing: measured efforts less those of the model, linear in what is unknown."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..closed_state.state import ClosedState
from ..dynamics.load_pattern import INERTIAL
from ..dynamics.loads import Loads
from ..ground.arrays import Array
from ..robot.robot import Robot
from .run import MeasuredRun, Rows
from .tolerances import Tolerances
from .unknowns import (
    LOAD,
    LoadFrame,
    Unknowns,
    friction_deviations,
    link_deviations,
    parameters_of,
    share_deviations,
)

LENGTH = 0.5  # [s] of a block
LEAST_BLOCKS = 12  # of a run; short runs have shorter blocks
MOST_BLOCKS = 240  # of a run; long runs have longer blocks
LEAST_RATE = 1e-6  # [rad/s, m/s] as which the rate of a drive counts that rests in all samples
RESTING = 0.5  # share of friction that a block leaves open, above which a drive rests
TURNING = 0.02  # share above which a drive stops or turns within a block
SLOW = 0.05  # of a drive's mean rate: width around zero in which its friction is open


@dataclass(frozen=True, eq=False)
class Blocks:
    """Means of the equations over short stretches of time: B blocks, k drives, p unknowns.

    Attributes:
        matrix: (B, k, p) change of each effort with each unknown.
        target: (B, k) measured efforts less those of the model [N m, N].
        at_rest: (B, k) share of Coulomb friction that is open: 1 at rest, 0 in motion.
        samples: (B,) number of samples of each block.
        start: (B,) first sample of each block.
    """

    matrix: Array
    target: Array
    at_rest: Array
    samples: Array
    start: Array

    def means(self, values: Array) -> Array:
        """Means (B, ...) of values (N, ...) of the samples."""
        return _means(values, self.start.astype(np.intp), self.samples.astype(np.intp))


@dataclass(frozen=True, eq=False)
class Equations:
    """Equations of the samples of a run: target = matrix @ unknowns + noise.

    There are N samples, k drives and p unknowns.

    Attributes:
        matrix: (N, k, p) change of each effort with each unknown, the last k shares of friction.
        target: (N, k) measured efforts less those of the model [N m, N].
        required: (N, k) efforts of the model without load [N m, N].
        at_rest: (N, k) share of Coulomb friction that is open: 1 at rest, 0 in motion.
    """

    matrix: Array
    target: Array
    required: Array
    at_rest: Array

    def blocks(self, time: Array | None) -> Blocks:
        """Means over blocks of time (N,) [s]; without times each sample is a block."""
        count = len(self.target)
        start: Rows = np.arange(count)
        if time is not None:
            start = _starts(time)
        samples = np.diff(np.append(start, count))
        return Blocks(
            matrix=_means(self.matrix, start, samples),
            target=_means(self.target, start, samples),
            at_rest=_means(self.at_rest, start, samples),
            samples=samples.astype(np.float64),
            start=start.astype(np.float64),
        )


def _starts(time: Array) -> Rows:
    """First sample (B,) of each block of a time (N,) [s]."""
    duration = float(time[-1] - time[0])
    length = max(LENGTH, duration / MOST_BLOCKS)
    length = min(length, duration / LEAST_BLOCKS)
    number = np.floor((time - time[0]) / length)
    return np.asarray(np.unique(number, return_index=True)[1])


def _means(values: Array, start: Rows, samples: Rows) -> Array:
    """Means (B, ...) of values (N, ...) over blocks, by their first samples and numbers (B,)."""
    sums = np.add.reduceat(values, start, axis=0)
    shape = (len(samples),) + (1,) * (values.ndim - 1)
    return np.asarray(sums / samples.reshape(shape))


class Modelling:
    """Makes the equations of runs of one robot with one set of unknowns.

    Attributes:
        robot: the robot.
        loads: loads besides the actuators and the one that is weighed.
        limits: tolerances of the model.
        drives: names of the k drives with efforts.
        frame: the frame that carries the load.
        parameters: names of the robot's parameters that are unknown.
        values: their values in the description.
    """

    def __init__(self, run: MeasuredRun, loads: Loads, frame: str, limits: Tolerances) -> None:
        """The equations for the drives of a run, with a load at a frame."""
        robot = run.robot
        self.robot = robot
        self.loads = loads
        self.limits = limits
        self.drives = run.drives
        self.frame = LoadFrame(robot.description, frame)
        self.parameters = parameters_of(robot, run.drives)
        self._indices = [robot.coordinates.index(name) for name in run.drives]
        self.values = self.parameters.values(robot.description, loads.effects)

    def unknowns(self, runs: list[MeasuredRun], load: Array) -> Unknowns:
        """The unknowns, with their deviations before the measurement.

        Those of friction and sensors follow from the mean sizes of efforts and rates.

        Args:
            runs: all runs.
            load: (10,) deviations of the load's parameters [kg, kg m, kg m^2].
        """
        efforts = np.concatenate([run.efforts for run in runs])
        rates = np.concatenate([run.state.ds[:, self._indices] for run in runs])
        effort = np.sqrt(np.mean(efforts**2, axis=0))
        rate = np.sqrt(np.mean(rates**2, axis=0))
        sizes = np.stack([effort, np.maximum(rate, LEAST_RATE)], axis=1)
        links = link_deviations(self.parameters, self.values, self.limits.links)
        friction = friction_deviations(self.robot, self.parameters, sizes, self.drives, self.limits)
        offsets = self.limits.offset * effort
        scales = np.full(len(self.drives), self.limits.scale)
        shares = share_deviations(self.robot, self.drives, self.limits)
        names = [*LOAD, *self.parameters.names]
        for kind in ("offset", "scale", "share"):
            names += [f"{name}.{kind}" for name in self.drives]
        parts = (load, links, friction, offsets, scales, shares)
        return Unknowns(tuple(names), np.concatenate(parts))

    def holding_friction(self, unknowns: Unknowns, size: Array) -> Array:
        """Largest dry friction (k,) that may hold each drive at rest [N m, N].

        Args:
            unknowns: the unknowns, with their deviations.
            size: (k,) mean effort of each drive [N m, N].
        """
        largest: list[float] = []
        for drive, effort in zip(self.drives, size.tolist(), strict=True):
            k = self.parameters.names.index(f"{drive}.coulomb")
            share = float(unknowns.deviation[unknowns.names.index(f"{drive}.share")])
            deviation = float(unknowns.deviation[INERTIAL + k])
            largest.append(float(self.values[k]) + deviation + share * effort)
        return np.array(largest)

    def equations(self, run: MeasuredRun, *, loaded: bool) -> Equations:
        """The equations of a run.

        Args:
            run: the run.
            loaded: whether the tool carries the load.
        """
        mapping = to_drives(self.robot, run.state, self.drives)
        regressor = self.robot.regressor(run.state, run.ddu, self.parameters, self.loads)
        of_parameters = mapping @ regressor
        required = self.robot.inverse_dynamics(run.state, run.ddu, self.loads)
        model = (mapping @ required[..., None])[..., 0]
        k = len(self.drives)
        load = np.zeros((len(model), k, INERTIAL))
        if loaded:
            # the load changes efforts as the parameters of its link do
            first = INERTIAL * self.parameters.links.index(self.frame.link)
            load = of_parameters[..., first : first + INERTIAL] @ self.frame.to_link
        rates = run.state.ds[:, self._indices]
        sensed = drive_columns(run.efforts, self._signs(rates), np.zeros(k))
        matrix = np.concatenate([load, of_parameters, sensed], axis=2)
        return Equations(
            matrix=matrix,
            target=run.efforts - model,
            required=model,
            at_rest=self._standstill(rates),
        )

    def with_shares(self, blocks: Blocks, run: MeasuredRun, shares: Array) -> Blocks:
        """The blocks of a run at estimated shares (k,) of friction."""
        signs = self._signs(run.state.ds[:, self._indices])
        column = blocks.means(share_column(run.efforts, signs, shares))
        matrix = blocks.matrix.copy()
        matrix[..., -len(shares) :] = np.eye(len(shares)) * column[..., None]
        return replace(blocks, matrix=matrix)

    def _signs(self, rates: Array) -> Array:
        """Smoothed signs (N, k) of rates (N, k)."""
        return rates / np.hypot(rates, self.loads.effects.smoothing[self._indices])

    def _standstill(self, rates: Array) -> Array:
        """Share (N, k) of friction that is open at rates (N, k): what a smoothed sign lacks to 1.

        Near standstill no law of friction is exact, nor is the sign of a measured rate.
        """
        usual = np.sqrt(np.mean(rates**2, axis=0))
        width = np.maximum(self.loads.effects.smoothing[self._indices], SLOW * usual)
        return np.asarray(1.0 - np.abs(rates) / np.hypot(rates, width))


def drive_columns(efforts: Array, signs: Array, shares: Array) -> Array:
    """Change (N, k, 3 k) of k efforts with offsets, scales, and shares of friction.

    Args:
        efforts: (N, k) measured efforts [N m, N].
        signs: (N, k) signs of the rates.
        shares: (k,) estimated shares of friction.
    """
    k = efforts.shape[1]
    offsets = np.broadcast_to(np.eye(k), (len(efforts), k, k))
    scales = offsets * efforts[:, :, None]
    friction = offsets * share_column(efforts, signs, shares)[:, :, None]
    return np.concatenate([offsets, scales, friction], axis=2)


def share_column(efforts: Array, signs: Array, shares: Array) -> Array:
    """Forces (N, k) that friction is a share of, against the motion [N m, N].

    Friction is a share of the size of the force without friction. That force F gives the measured
    effort F + share |F| sign(rate).

    Args:
        efforts: (N, k) measured efforts [N m, N].
        signs: (N, k) signs of the rates.
        shares: (k,) estimated shares.
    """
    with_friction = 1.0 + shares * signs * np.sign(efforts)
    return np.asarray(np.abs(efforts) / with_friction * signs)


def to_drives(robot: Robot, state: ClosedState, drives: tuple[str, ...]) -> Array:
    """Maps (N, k, n) from tau to the efforts of drives.

    By virtual work tau = R_d^T f. R_d (n, n) has the rows of R of drives and idle joints.

    Args:
        robot: the robot.
        state: closed states, a batch of N.
        drives: names of the k drives.
    """
    determining = [*robot.drives, *robot.idle]
    rows = [robot.coordinates.index(name) for name in determining]
    transposed = np.swapaxes(state.R[:, rows], -1, -2)
    inverse = np.linalg.inv(transposed)
    chosen = [determining.index(name) for name in drives]
    return np.asarray(inverse[:, chosen])


def standstill_columns(blocks: Blocks, friction: Array) -> tuple[Array, Array]:
    """An unknown friction for each stretch in which a drive rests, or block in which it turns.

    Args:
        blocks: blocks of a run.
        friction: (k,) largest friction of each drive at rest [N m, N].

    Returns:
        Columns (B, k, r) for r such frictions, and their deviations (r,) [N m, N].
    """
    count, drives = blocks.at_rest.shape
    columns: list[Array] = []
    deviations: list[float] = []
    for drive in range(drives):
        rests = blocks.at_rest[:, drive] > RESTING
        # moving before and after: each stretch has a start and an end
        padded = np.concatenate([[0], rests.astype(int), [0]])
        changes = np.flatnonzero(np.diff(padded))
        turns = np.flatnonzero(~rests & (blocks.at_rest[:, drive] > TURNING))
        stretches = changes.reshape(-1, 2).tolist()
        for turn in turns.tolist():
            stretches.append([turn, turn + 1])
        for start, end in stretches:
            column = np.zeros((count, drives))
            column[start:end, drive] = blocks.at_rest[start:end, drive]
            columns.append(column)
            # that of a uniform distribution between minus and plus the friction
            deviations.append(float(friction[drive]) / np.sqrt(3.0))
    if not columns:
        return np.zeros((count, drives, 0)), np.zeros(0)
    return np.stack(columns, axis=2), np.array(deviations)
