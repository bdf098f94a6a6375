"""Weighing: the mass of a load at the tool from measured efforts or pressures.

Efforts are linear in the load's mass and first moment, and in what the model does not know exactly:
masses of links, friction, offsets and scales of sensors. All are estimated together, each with what
is known before, so the interval contains what they leave open. A run of the empty tool shows them
without the load: what it shares with the weighing cancels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

from ..dynamics.load_pattern import INERTIAL
from ..dynamics.loads import Loads
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arguments import require_type
from ..ground.check_arrays import real_array
from .equations import Modelling, standstill_columns
from .fit import Fit, System, fitted, unfitting
from .misfit import check_fit, check_result
from .plateau import loaded_blocks
from .run import MeasuredRun
from .tolerances import Tolerances
from .unknowns import SHARE_OF_REACH, Unknowns, load_deviations

CONFIDENCE = 0.95
ROUNDS = 3  # fits, each with the centre of mass of the one before
GOOD = 0.02  # half an interval over the mass of load and tool
FAIR = 0.06
LEAST_BLOCKS = 6  # of a motion
IMPOSSIBLE = 5.0  # deviations below zero that are no chance


@dataclass(frozen=True, eq=False)
class PayloadEstimate:
    """The load at the tool.

    Attributes:
        mass: [kg].
        interval: (low, high) where the mass lies with 95 % confidence [kg].
        deviation: standard deviation of the mass [kg].
        com: (3,) centre of mass in the frame [m]; NaN along axes that the motion does not show.
        com_deviation: (3,) its standard deviation [m].
        quality: "good", "fair" or "poor": half the interval is up to 2 %, up to 6 % or more of the
            mass of load and tool.
        friction: Coulomb friction [N m, N] by drive, as found.
        used: share of the samples that show the load.
        span: first and last time that shows the load [s]; (nan, nan) without times.
        noise: what the fit leaves of each drive's effort over a block, by drive [N m, N].
        frame: name of the frame that carries the load.
    """

    mass: float
    interval: tuple[float, float]
    deviation: float
    com: Array
    com_deviation: Array
    quality: str
    friction: dict[str, float]
    used: float
    span: tuple[float, float]
    noise: dict[str, float]
    frame: str


def estimate_payload(
    run: MeasuredRun,
    empty: MeasuredRun | None = None,
    frame: str | None = None,
    loads: Loads | None = None,
    tolerances: Tolerances | None = None,
    com: ArrayLike | None = None,
) -> PayloadEstimate:
    """Weigh the load at a frame.

    Where the run is longer than the load is carried, as a whole cycle of digging is, the part with
    the greatest load that stays the same is weighed.

    Args:
        run: the run with the load: a motion, or poses at rest.
        empty: a run of the same machine without the load. It shows what links, friction and sensors
            are off by.
        frame: name of the frame or link that carries the load; the end effector if None.
        loads: loads besides the actuators and this one; `robot.loads` if None.
        tolerances: how wrong the model may be.
        com: centre of mass (3,) of the load in the frame [m], if it is known.

    Returns:
        Mass and interval.

    Raises:
        SensorError: an InputError: chambers are exchanged, a unit is wrong, a sensor is stuck, or
            the efforts fit no load.
        InputError: the runs are of different robots or drives, or a name is unknown.
    """
    require_type("run", run, MeasuredRun, "MeasuredRun.from_samples(...)")
    robot = run.robot
    frame = robot.end_effector if frame is None else frame
    loads = robot.loads if loads is None else loads
    require_type("loads", loads, Loads, "robot.loads")
    runs = [run]
    if empty is not None:
        require_type("empty", empty, MeasuredRun, "MeasuredRun.from_samples(...)")
        runs.append(_matching(empty, run))
    weighing = _Weighing(runs, loads, frame, tolerances or Tolerances(), com)
    return weighing.estimate()


def _matching(empty: MeasuredRun, run: MeasuredRun) -> MeasuredRun:
    """The empty run, with the drives of the run; raises InputError."""
    if empty.robot.description is not run.robot.description and empty.robot.name != run.robot.name:
        raise InputError(f"empty is a run of {empty.robot.name}, the other of {run.robot.name}")
    missing = [name for name in run.drives if name not in empty.drives]
    if missing:
        raise InputError(f"empty: no effort of {', '.join(missing)}; expected those of the run")
    columns = [empty.drives.index(name) for name in run.drives]
    parts = (empty.robot, empty.state, empty.ddu, empty.efforts[:, columns], run.drives)
    return MeasuredRun(*parts, empty.time, empty.exchanged)


class _Weighing:
    """The fit of one load."""

    def __init__(
        self,
        runs: list[MeasuredRun],
        loads: Loads,
        frame: str,
        limits: Tolerances,
        com: ArrayLike | None,
    ) -> None:
        self.runs = [_complete(run) for run in runs]
        self.frame = frame
        self.limits = limits
        self.modelling = Modelling(self.runs[0], loads, frame, limits)
        self.com = None if com is None else _place(com)
        self.reach = limits.com or SHARE_OF_REACH * self._distance()
        robot = runs[0].robot
        link = robot.description.links[self.modelling.frame.link]
        self.tool_mass = link.mass
        efforts = np.concatenate([run.efforts for run in self.runs])
        self.size = np.sqrt(np.mean(efforts**2, axis=0))
        self.equations = [
            self.modelling.equations(one, loaded=k == 0) for k, one in enumerate(self.runs)
        ]
        self.blocks = [
            equation.blocks(one.time)
            for equation, one in zip(self.equations, self.runs, strict=True)
        ]

    def estimate(self) -> PayloadEstimate:
        """The load."""
        unknowns = self._unknowns(max(self.tool_mass, 1e-6))
        check_fit(self.runs, self.equations, self.blocks, unknowns)
        system = self._system(unknowns, np.zeros(INERTIAL))
        is_loaded = loaded_blocks(system, len(self.blocks[0].target), self.size)
        return self._weighed(system, is_loaded)

    def _weighed(self, system: System, rows: np.ndarray) -> PayloadEstimate:
        """The load from some of the blocks."""
        part = system.only(rows)
        fit = fitted(part)
        for _ in range(ROUNDS):
            outlying = unfitting(part, fit)
            if outlying.any() and (~outlying).sum() > LEAST_BLOCKS:
                rows = rows.copy()
                rows[np.flatnonzero(rows)[outlying]] = False
            mean, deviation = self._around(fit)
            unknowns = self._unknowns_with(deviation)
            system = self._system(unknowns, mean)
            part = system.only(rows)
            fit = fitted(part)
        return self._result(fit, rows)

    def _around(self, fit: Fit) -> tuple[Array, Array]:
        """Expected parameters (10,) of the load, with deviations, by the fit before."""
        mass = max(float(fit.values[0]), 0.05 * max(self.tool_mass, 1e-6))
        deviation = load_deviations(mass, self.reach)
        com = np.clip(fit.values[1:4] / mass, -self.reach, self.reach)
        if self.com is not None:
            com = self.com
        moments = mass * (float(com @ com) * np.eye(3) - np.outer(com, com))
        mean = np.zeros(INERTIAL)
        mean[4:] = moments[np.triu_indices(3)]
        deviation[4:] = 0.1 * deviation[4:]
        return mean, deviation

    def _unknowns(self, mass: float) -> Unknowns:
        return self._unknowns_with(load_deviations(mass, self.reach))

    def _unknowns_with(self, load: Array) -> Unknowns:
        return self.modelling.unknowns(self.runs, load)

    def _system(self, unknowns: Unknowns, load: Array) -> System:
        """Blocks of all runs, with a friction for each rest."""
        friction = self.modelling.holding_friction(unknowns)
        p = len(unknowns.deviation)
        rests = [standstill_columns(blocks, friction) for blocks in self.blocks]
        width = p + sum(len(deviations) for _, deviations in rests)
        matrices: list[Array] = []
        start = p
        for blocks, (columns, deviations) in zip(self.blocks, rests, strict=True):
            matrix = np.zeros((*blocks.target.shape, width))
            matrix[..., :p] = blocks.matrix
            matrix[..., start : start + len(deviations)] = columns
            start += len(deviations)
            matrices.append(matrix)
        deviation = np.concatenate([unknowns.deviation, *(one for _, one in rests)])
        mean = np.zeros(width)
        mean[:INERTIAL] = load
        matrix = np.concatenate(matrices)
        if self.com is not None:
            # the first moment is that of the mass: one column for both
            matrix[..., 0] += matrix[..., 1:4] @ self.com
            deviation[1:4] = 0.0
        run = np.concatenate([np.full(len(one.target), k) for k, one in enumerate(self.blocks)])
        target = np.concatenate([blocks.target for blocks in self.blocks])
        return System(matrix, target, mean, deviation, self._floor(), run)

    def _floor(self) -> Array:
        """Expected noise (k,) of a block."""
        size = self.size
        samples = np.median(np.concatenate([blocks.samples for blocks in self.blocks]))
        least = 1e-6 * float(size.max())
        return np.asarray(np.maximum(self.limits.noise * size / np.sqrt(samples), least))

    def _result(self, fit: Fit, rows: np.ndarray) -> PayloadEstimate:
        mass = float(fit.values[0])
        deviation = float(np.sqrt(fit.covariance[0, 0]))
        check_result(self.runs[0], fit.noise, mass, deviation, IMPOSSIBLE)
        reach = float(stats.t.ppf(0.5 + 0.5 * CONFIDENCE, fit.free)) * deviation
        com, com_deviation = _centre(fit, self.reach)
        if self.com is not None:
            com, com_deviation = self.com, np.zeros(3)
        used = rows[: len(self.blocks[0].target)]
        names = self.modelling.parameters.names
        friction = {}
        for drive in self.modelling.drives:
            k = names.index(f"{drive}.coulomb")
            friction[drive] = float(self.modelling.values[k] + fit.values[INERTIAL + k])
        share = reach / max(abs(mass) + self.tool_mass, 1e-12)
        quality = "poor"
        if share <= FAIR:
            quality = "fair"
        if share <= GOOD:
            quality = "good"
        return PayloadEstimate(
            mass=mass,
            interval=(mass - reach, mass + reach),
            deviation=deviation,
            com=com,
            com_deviation=com_deviation,
            quality=quality,
            friction=friction,
            used=float(self.blocks[0].samples[used].sum() / self.blocks[0].samples.sum()),
            span=self._span(used),
            noise=dict(zip(self.modelling.drives, fit.noise.tolist(), strict=True)),
            frame=self.frame,
        )

    def _span(self, used: np.ndarray) -> tuple[float, float]:
        time = self.runs[0].time
        if time is None:
            return np.nan, np.nan
        first = self.blocks[0].start.astype(int)
        after = np.append(first[1:], len(time)) - 1
        return float(time[first[used][0]]), float(time[after[used][-1]])

    def _distance(self) -> float:
        """Largest distance of the frame from the base [m]."""
        robot = self.runs[0].robot
        position = robot.forward_kinematics(self.runs[0].state, self.frame).position
        return float(np.linalg.norm(position, axis=-1).max())


def _complete(run: MeasuredRun) -> MeasuredRun:
    """The samples that have all efforts."""
    rows = np.flatnonzero(np.isfinite(run.efforts).all(axis=1))
    if len(rows) == len(run.efforts):
        return run
    if not len(rows):
        raise InputError(f"no sample has efforts of {', '.join(run.drives)}")
    return run.rows(rows)


def _place(com: ArrayLike) -> Array:
    values = real_array("com", com)
    if values.shape != (3,) or not np.isfinite(values).all():
        raise InputError(f"com has shape {values.shape}; expected 3 finite numbers")
    return values


def _centre(fit: Fit, reach: float) -> tuple[Array, Array]:
    """Centre of mass (3,) with deviation; NaN where the measurement says little."""
    mass = float(fit.values[0])
    if mass <= 0.0:
        return np.full(3, np.nan), np.full(3, np.nan)
    com = fit.values[1:4] / mass
    gradient = np.concatenate([-com[:, None], np.eye(3)], axis=1) / mass
    variance = np.einsum("ij,jk,ik->i", gradient, fit.covariance[:4, :4], gradient)
    deviation = np.sqrt(variance)
    is_shown = deviation < 0.5 * reach
    return np.where(is_shown, com, np.nan), np.where(is_shown, deviation, np.nan)
