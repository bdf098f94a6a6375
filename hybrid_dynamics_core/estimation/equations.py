"""Equations of weighing: measured efforts less those of the model, linear in what is unknown."""

from __future__ import annotations

from dataclasses import dataclass

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
)

LENGTH = 0.5  # [s] of a block
LEAST_BLOCKS = 12  # of a run; short runs have shorter blocks
MOST_BLOCKS = 240  # of a run; long runs have longer blocks
LEAST_RATE = 1e-6  # [rad/s, m/s] of a drive that rests, since viscous friction is effort over rate
RESTING = 0.5  # share of friction that a block leaves open, above which a drive rests


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
        matrix: (N, k, p) change of each effort with each unknown.
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
        self.values = self.parameters.values(robot.description, loads.effects)

    def unknowns(self, runs: list[MeasuredRun], load: Array) -> Unknowns:
        """The unknowns, with their deviations before the measurement.

        Those of friction and sensors follow from the mean sizes of efforts and rates.

        Args:
            runs: all runs.
            load: (10,) deviations of the load's parameters [kg, kg m, kg m^2].
        """
        efforts = np.concatenate([run.efforts for run in runs])
        indices = [self.robot.coordinates.index(name) for name in self.drives]
        rates = np.concatenate([run.state.ds[:, indices] for run in runs])
        effort = np.sqrt(np.mean(efforts**2, axis=0))
        rate = np.sqrt(np.mean(rates**2, axis=0))
        sizes = np.stack([effort, np.maximum(rate, LEAST_RATE)], axis=1)
        links = link_deviations(self.parameters, self.values, self.limits.links)
        friction = friction_deviations(self.robot, self.parameters, sizes, self.drives, self.limits)
        offsets = self.limits.offset * effort
        scales = np.full(len(self.drives), self.limits.scale)
        names = [*LOAD, *self.parameters.names]
        names += [f"{name}.offset" for name in self.drives]
        names += [f"{name}.scale" for name in self.drives]
        parts = (load, links, friction, offsets, scales)
        return Unknowns(tuple(names), np.concatenate(parts))

    def holding_friction(self, unknowns: Unknowns) -> Array:
        """Largest Coulomb friction (k,) that may hold each drive at rest [N m, N]."""
        largest: list[float] = []
        names = self.parameters.names
        for drive in self.drives:
            k = names.index(f"{drive}.coulomb")
            value = float(self.values[k])
            deviation = float(unknowns.deviation[INERTIAL + k])  # after those of the load
            largest.append(value + deviation)
        return np.array(largest)

    def equations(self, run: MeasuredRun, *, loaded: bool) -> Equations:
        """The equations of a run.

        Args:
            run: the run.
            loaded: whether the tool carries the load.
        """
        mapping = to_drives(self.robot, run.state, self.drives)
        regressor = self.robot.regressor(run.state, run.ddu, self.parameters, self.loads)
        along = mapping @ regressor
        required = self.robot.inverse_dynamics(run.state, run.ddu, self.loads)
        model = (mapping @ required[..., None])[..., 0]
        k = len(self.drives)
        load = np.zeros((len(model), k, INERTIAL))
        if loaded:
            # the load changes efforts as the parameters of its link do
            first = INERTIAL * self.parameters.links.index(self.frame.link)
            load = along[..., first : first + INERTIAL] @ self.frame.to_link
        offsets = np.broadcast_to(np.eye(k), (len(model), k, k))
        scales = offsets * run.efforts[:, :, None]
        matrix = np.concatenate([load, along, offsets, scales], axis=2)
        return Equations(
            matrix=matrix,
            target=run.efforts - model,
            required=model,
            at_rest=self._standstill(run),
        )

    def _standstill(self, run: MeasuredRun) -> Array:
        """Share (N, k) of Coulomb friction that is open: what its smoothed sign lacks to 1."""
        indices = [self.robot.coordinates.index(name) for name in self.drives]
        rates = run.state.ds[:, indices]
        smoothing = self.loads.effects.smoothing[indices]
        return np.asarray(1.0 - np.abs(rates) / np.hypot(rates, smoothing))


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
    """An unknown friction for each stretch of time in which a drive rests.

    Args:
        blocks: blocks of a run.
        friction: (k,) largest friction of each drive at rest [N m, N].

    Returns:
        Columns (B, k, r) for r such stretches, and their deviations (r,) [N m, N].
    """
    count, k = blocks.at_rest.shape
    columns: list[Array] = []
    deviations: list[float] = []
    for drive in range(k):
        rests = blocks.at_rest[:, drive] > RESTING
        # moving before and after: each stretch has a start and an end
        padded = np.concatenate([[0], rests.astype(int), [0]])
        changes = np.flatnonzero(np.diff(padded))
        for start, end in changes.reshape(-1, 2).tolist():
            column = np.zeros((count, k))
            column[start:end, drive] = blocks.at_rest[start:end, drive]
            columns.append(column)
            # that of a uniform distribution between minus and plus the friction
            deviations.append(float(friction[drive]) / np.sqrt(3.0))
    if not columns:
        return np.zeros((count, k, 0)), np.zeros(0)
    return np.stack(columns, axis=2), np.array(deviations)
