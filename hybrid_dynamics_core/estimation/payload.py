"""Weighing: the mass of a load at the tool from measured efforts or pressures.

Efforts are linear in the load's mass and first moment. They are also linear in what the model does
not know exactly: masses of links, friction, offsets and scales of sensors. All are estimated
together, each with what is known before. So the interval contains what they leave open. A run of
the empty tool has the same errors without the load: what both runs share cancels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..dynamics.load_pattern import INERTIAL
from ..dynamics.loads import Loads
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arguments import require_type
from .centre import centre_of_mass, place_of
from .equations import Blocks, Equations, Modelling, standstill_columns
from .fit import Fit, System, fitted, unfitting
from .misfit import check_fit, check_place, check_result
from .plateau import loaded_blocks
from .run import MeasuredRun
from .sensors import SensorError
from .tolerances import Tolerances
from .unknowns import SHARE_OF_REACH, Unknowns, load_deviations

CONFIDENCE = 0.95  # probability that the mass lies in its interval
ROUNDS = 3  # fits, each with the centre of mass of the one before
GOOD = 0.02  # largest half interval over the mass of load and tool
FAIR = 0.06  # likewise
LEAST_BLOCKS = 6  # that stay when those that do not fit are left out
IMPOSSIBLE = 5.0  # deviations below zero that are no chance
LEAST_TOOL = 1e-6  # [kg] as which a tool without mass counts
LEAST_LOAD = 0.05  # share of the tool's mass, as which a smaller load counts for its moments
OF_MOMENTS = 0.1  # share of the second moments before: those of a point mass are nearly right


@dataclass(frozen=True, eq=False)
class PayloadEstimate:
    """The load at the tool.

    Attributes:
        mass: estimated mass [kg].
        interval: (low, high) where the mass lies with 95 % confidence [kg].
        deviation: standard deviation of the mass [kg].
        com: (3,) centre of mass in the frame [m]; NaN along axes that the motion does not show.
        com_deviation: (3,) its standard deviation [m].
        covariance: (4, 4) of mass and centre of mass; NaN where one of them is not shown.
        quality: half the interval as a share of the mass of load and tool: "good" up to 2 %,
            "fair" up to 6 %, "poor" above.
        friction: estimated dry friction by drive at its mean effort [N m, N].
        used: share of the samples that show the load.
        span: first and last time that shows the load [s]; (nan, nan) without times.
        noise: mean effort over a block that the fit leaves, by drive [N m, N].
        frame: name of the frame that carries the load.
    """

    mass: float
    interval: tuple[float, float]
    deviation: float
    com: Array
    com_deviation: Array
    covariance: Array
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

    A run may be longer than the load is carried, as a whole cycle of digging is. Then the part with
    the greatest load that stays the same is weighed.

    Args:
        run: the run with the load: a motion, or poses at rest.
        empty: a run of the same machine without the load. It shows the errors of links, friction
            and sensors.
        frame: name of the frame or link that carries the load; the end effector if None.
        loads: loads besides the actuators and this one; `robot.loads` if None.
        tolerances: how wrong the model may be.
        com: centre of mass (3,) of the load in the frame [m], if it is known.

    Returns:
        Mass and interval.

    Raises:
        SensorError: chambers are exchanged, a unit is wrong, a sensor is stuck, or the efforts fit
            no load. It is an InputError.
        InputError: the runs are of different robots or drives, or a name is unknown.
    """
    require_type("run", run, MeasuredRun, "MeasuredRun.from_samples(...)")
    robot = run.robot
    if frame is None:
        frame = robot.end_effector
    if loads is None:
        loads = robot.loads
    require_type("loads", loads, Loads, "robot.loads")
    runs = [run]
    if empty is not None:
        require_type("empty", empty, MeasuredRun, "MeasuredRun.from_samples(...)")
        runs.append(_matching(empty, run))
    weighing = _Weighing(
        runs,
        loads,
        frame,
        tolerances or Tolerances(),
        com,
    )
    return weighing.estimate()


def _matching(empty: MeasuredRun, run: MeasuredRun) -> MeasuredRun:
    """The empty run with the drives of the other one; raises InputError if it lacks some."""
    if empty.robot.description is not run.robot.description and empty.robot.name != run.robot.name:
        raise InputError(f"empty is a run of {empty.robot.name}, the other of {run.robot.name}")
    return empty.of_drives(run.drives)


class _Weighing:
    """The fit of one load.

    Attributes:
        runs: the run with the load, then perhaps the empty one; samples that have all efforts.
        frame: name of the frame that carries the load.
        limits: tolerances of the model.
        modelling: makes the equations.
        com: centre of mass (3,) of the load in the frame [m], if it is given.
        reach: deviation of the centre of mass along each axis [m].
        tool_mass: mass of the link that carries the load [kg].
        size: (k,) mean effort of each drive [N m, N].
        equations: equations of each run.
        blocks: their means.
    """

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
        self.com = None if com is None else place_of(com)
        self.reach = limits.com or SHARE_OF_REACH * self._distance()
        robot = runs[0].robot
        link = robot.description.links[self.modelling.frame.link]
        self.tool_mass = link.mass
        efforts = np.concatenate([run.efforts for run in self.runs])
        self.size = np.sqrt(np.mean(efforts**2, axis=0))
        self.equations: list[Equations] = []
        self.blocks: list[Blocks] = []
        for k, one in enumerate(self.runs):
            equations = self.modelling.equations(one, loaded=k == 0)
            self.equations.append(equations)
            self.blocks.append(equations.blocks(one.time))

    def estimate(self) -> PayloadEstimate:
        """The load, after checks of the sensors."""
        unknowns = self._unknowns(max(self.tool_mass, LEAST_TOOL))
        check_fit(self.runs, self.equations, self.blocks, unknowns)
        system = self._system(unknowns, np.zeros(INERTIAL))
        is_loaded = loaded_blocks(system, len(self.blocks[0].target), self.size)
        return self._weighed(system, is_loaded)

    def _weighed(self, system: System, rows: np.ndarray) -> PayloadEstimate:
        """The load from the blocks of a mask (B,)."""
        part = system.only(rows)
        fit = fitted(part)
        for _ in range(ROUNDS):
            outlying = unfitting(part, fit)
            if outlying.any() and (~outlying).sum() > LEAST_BLOCKS:
                chosen = np.flatnonzero(rows)
                rows = rows.copy()
                rows[chosen[outlying]] = False
            self._take_shares(fit)
            mean, deviation = self._around(fit)
            unknowns = self._unknowns_with(deviation)
            system = self._system(unknowns, mean)
            part = system.only(rows)
            fit = fitted(part)
        return self._result(fit, rows)

    def _shares(self, fit: Fit) -> Array:
        """Estimated shares (k,) of friction, which are the last columns of the blocks."""
        end = self.blocks[0].matrix.shape[-1]
        return fit.values[end - len(self.modelling.drives) : end]

    def _take_shares(self, fit: Fit) -> None:
        """Let the friction that is a share of forces start from the fit before."""
        shares = self._shares(fit)
        if not shares.any():
            return
        for number, run in enumerate(self.runs):
            blocks = self.blocks[number]
            self.blocks[number] = self.modelling.with_shares(blocks, run, shares)

    def _around(self, fit: Fit) -> tuple[Array, Array]:
        """Expected parameters (10,) of the load, and deviations (10,), by the fit before.

        The second moments are those of a point mass.
        """
        least = LEAST_LOAD * max(self.tool_mass, LEAST_TOOL)
        mass = max(float(fit.values[0]), least)
        deviation = load_deviations(mass, self.reach)
        com = np.clip(fit.values[1:4] / mass, -self.reach, self.reach)
        if self.com is not None:
            com = self.com
        square = float(com @ com)
        moments = mass * (square * np.eye(3) - np.outer(com, com))
        mean = np.zeros(INERTIAL)
        mean[4:] = moments[np.triu_indices(3)]
        deviation[4:] = OF_MOMENTS * deviation[4:]
        return mean, deviation

    def _unknowns(self, mass: float) -> Unknowns:
        """The unknowns with a load of about a mass [kg]."""
        return self._unknowns_with(load_deviations(mass, self.reach))

    def _unknowns_with(self, load: Array) -> Unknowns:
        """The unknowns with deviations (10,) of the load."""
        return self.modelling.unknowns(self.runs, load)

    def _system(self, unknowns: Unknowns, load: Array) -> System:
        """Blocks of all runs, with a friction for each stretch in which a drive rests.

        Args:
            unknowns: the p unknowns without these frictions.
            load: (10,) expected parameters of the load [kg, kg m, kg m^2].
        """
        friction = self.modelling.holding_friction(unknowns, self.size)
        rests = [standstill_columns(blocks, friction) for blocks in self.blocks]
        of_rests = [deviation for _, deviation in rests]
        deviation = np.concatenate([unknowns.deviation, *of_rests])
        width = len(deviation)
        p = start = len(unknowns.deviation)
        matrices: list[Array] = []
        runs: list[Array] = []
        for k, blocks in enumerate(self.blocks):
            columns, _ = rests[k]
            end = start + columns.shape[2]
            part = np.zeros((*blocks.target.shape, width))
            part[..., :p] = blocks.matrix
            part[..., start:end] = columns
            matrices.append(part)
            runs.append(np.full(len(part), float(k)))
            start = end
        mean = np.zeros(width)
        mean[:INERTIAL] = load
        matrix = np.concatenate(matrices)
        if self.com is not None:
            # the first moment is mass times com: one column for both
            matrix[..., 0] += matrix[..., 1:4] @ self.com
            deviation[1:4] = 0.0
        target = np.concatenate([blocks.target for blocks in self.blocks])
        return System(
            matrix=matrix,
            target=target,
            mean=mean,
            deviation=deviation,
            floor=self._floor(),
            run=np.concatenate(runs),
        )

    def _floor(self) -> Array:
        """Expected noise (k,) of a block [N m, N]."""
        counts = [blocks.samples for blocks in self.blocks]
        samples = np.median(np.concatenate(counts))
        noise = self.limits.noise * self.size / np.sqrt(samples)
        least = 1e-6 * float(self.size.max())
        return np.asarray(np.maximum(noise, least))

    def _result(self, fit: Fit, rows: np.ndarray) -> PayloadEstimate:
        """The estimate from a fit to the blocks of a mask (B,); raises SensorError."""
        from scipy.special import stdtrit  # noqa: PLC0415  slow to import

        if not rows[: len(self.blocks[0].target)].any():
            raise SensorError(
                "no part of the run fits a load and the run of the empty tool; is a sensor"
                f" off, or is one run of another machine than {self.runs[0].robot.name}?"
            )
        mass = float(fit.values[0])
        deviation = float(np.sqrt(fit.covariance[0, 0]))
        check_result(self.runs[0], fit.noise, mass, deviation, IMPOSSIBLE)
        quantile = float(stdtrit(fit.free, 0.5 + 0.5 * CONFIDENCE))
        half_interval = quantile * deviation
        com, covariance = centre_of_mass(fit, self.reach)
        if self.com is None and mass > IMPOSSIBLE * deviation:
            check_place(self.runs[0], com, np.sqrt(np.diagonal(covariance)[1:]), self.reach)
        if self.com is not None:
            com = self.com
            covariance = np.zeros((4, 4))
            covariance[0, 0] = deviation**2
        samples = self.blocks[0].samples
        used = rows[: len(samples)]
        names = self.modelling.parameters.names
        friction = {}
        sizes = self._shares(fit) * self.size
        for drive, size in zip(self.modelling.drives, sizes.tolist(), strict=True):
            k = names.index(f"{drive}.coulomb")
            change = fit.values[INERTIAL + k]
            friction[drive] = float(self.modelling.values[k] + change) + size
        share = half_interval / max(abs(mass) + self.tool_mass, 1e-12)
        return PayloadEstimate(
            mass=mass,
            interval=(mass - half_interval, mass + half_interval),
            deviation=deviation,
            com=com,
            com_deviation=np.sqrt(np.diagonal(covariance)[1:]),
            covariance=covariance,
            quality=_quality(share),
            friction=friction,
            used=float(samples[used].sum() / samples.sum()),
            span=self._span(used),
            noise=dict(zip(self.modelling.drives, fit.noise.tolist(), strict=True)),
            frame=self.frame,
        )

    def _span(self, used: np.ndarray) -> tuple[float, float]:
        """First and last time of the blocks of a mask [s]; (nan, nan) without times."""
        time = self.runs[0].time
        if time is None:
            return np.nan, np.nan
        first = self.blocks[0].start.astype(int)
        last = np.append(first[1:], len(time)) - 1
        start = time[first[used][0]]
        end = time[last[used][-1]]
        return float(start), float(end)

    def _distance(self) -> float:
        """Largest distance of the frame from the base [m]."""
        robot = self.runs[0].robot
        pose = robot.forward_kinematics(self.runs[0].state, self.frame)
        distances = np.linalg.norm(pose.position, axis=-1)
        return float(distances.max())


def _quality(share: float) -> str:
    """The quality by half the interval, as a share of the mass of load and tool."""
    if share <= GOOD:
        return "good"
    if share <= FAIR:
        return "fair"
    return "poor"


def _complete(run: MeasuredRun) -> MeasuredRun:
    """The samples that have all efforts."""
    rows = np.flatnonzero(np.isfinite(run.efforts).all(axis=1))
    if len(rows) == len(run.efforts):
        return run
    if not len(rows):
        raise InputError(f"no sample has efforts of {', '.join(run.drives)}")
    return run.rows(rows)
