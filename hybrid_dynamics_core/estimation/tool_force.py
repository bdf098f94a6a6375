"""Force at the tool from a momentum observer, with covariance, and whether the tool has contact.

The residual r of the observer is J^T w plus what the model is off by. Drives without measured
efforts are left out: the residual is mapped to the others. The wrench w follows by least squares
with the covariance of all errors.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..control.momentum_observer import MAX_GAP, MomentumObserver, Residuals
from ..dynamics.loads import Loads
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arguments import real_number, require_type
from ..ground.check_arrays import real_array
from ..ground.suggestions import no_such_name
from ..robot.robot import Robot
from .equations import Modelling, drive_columns, to_drives
from .misfit import check_units, exchanged_chambers
from .run import MeasuredRun
from .tolerances import Tolerances
from .unknowns import parameters_of
from .wrench import SIX, DriveEfforts, Mask, ToolForce, transposed
from .zeroing import Deviation, deviation_before, deviation_of

CUTOFF = 4.0  # [Hz]
FALSE_ALARMS = 1e-4
UNSURE = 3.0  # times the smoothing of friction, up to which the sign of a rate is unsure
PERMANENT = 0.9  # share of samples with contact, above which sensors are doubted
FREE = 0.5  # share of samples with contact, below which exchanged chambers explain the efforts
END = 0.3  # periods of the bandwidth at the ends of a run, where a spline is less exact


@dataclass(frozen=True)
class ToolForceOptions:
    """How a force at the tool is found.

    Attributes:
        frame: name of the frame or link where the force acts; the end effector if None.
        moments: whether moments act too. If None, they do where six drives or more are measured;
            else a force acts at the frame's origin.
        cutoff: bandwidth of the force [Hz].
        false_alarms: share of samples without contact that are beyond the threshold.
        max_gap: time between samples [s] beyond which the observer starts anew.

    Raises:
        InputError: a share is not between 0 and 1.
    """

    frame: str | None = None
    moments: bool | None = None
    cutoff: float = CUTOFF
    false_alarms: float = FALSE_ALARMS
    max_gap: float = MAX_GAP

    def __post_init__(self) -> None:
        share = real_number("false_alarms", self.false_alarms)
        if not 0.0 < share < 1.0:
            raise InputError(f"false_alarms is {share:g}; expected a share between 0 and 1")


class ToolForceModel:
    """From residuals of an observer to the force at a frame.

    Attributes:
        robot: the robot.
        drives: the k drives with measured efforts.
        options: how the force is found.
        loads: loads besides the actuators and this force.
        frame: name of the frame.
        deviation: errors of the model.
        threshold: squared deviations of the efforts above which there is contact.

    Raises:
        InputError: a name is unknown, or no drive is measured.
    """

    def __init__(
        self,
        robot: Robot,
        drives: tuple[str, ...],
        options: ToolForceOptions | None = None,
        loads: Loads | None = None,
        deviation: Deviation | None = None,
    ) -> None:
        """Prepare for some drives.

        Args:
            robot: the robot.
            drives: the k drives with measured efforts.
            options: how the force is found.
            loads: loads besides the actuators and this force; `robot.loads` if None.
            deviation: errors of the model; those that usual tolerances allow if None.
        """
        self.robot = robot
        self.drives = drives
        self.options = options or ToolForceOptions()
        self.loads = robot.loads if loads is None else loads
        self.frame = self.options.frame or robot.end_effector
        _check(robot, drives, self.frame)
        if deviation is None:
            deviation = deviation_before(robot, drives, self.loads, Tolerances())
        self.deviation = deviation
        self.threshold = _threshold(len(drives), self.options.false_alarms)
        self._axes = self._count_axes()
        pose = robot.forward_kinematics(robot.close(robot.reference), self.frame)
        self._length = float(np.linalg.norm(pose.position)) or 1.0
        self._indices = [robot.coordinates.index(name) for name in drives]
        self._parameters = parameters_of(robot, drives)
        self._friction = self._holding_friction()
        # largest friction at rest as a share of each effort
        of_shares = slice(-len(drives), None)
        errors = np.sqrt((self.deviation.factor[of_shares] ** 2).sum(axis=1))
        self._share = np.abs(self.deviation.values[of_shares]) + errors

    def forces(self, residuals: Residuals, state: ClosedState, efforts: Array) -> ToolForce:
        """The force at N samples.

        Args:
            residuals: residuals of the observer.
            state: closed states with rates, a batch of N.
            efforts: (N, k) measured efforts of the drives [N m, N].
        """
        mapping = to_drives(self.robot, state, self.drives)
        mapped = mapping @ residuals.values[..., None]
        columns = self._columns(mapping, state, efforts)
        # the residual is what the model needs less what is measured
        expected = columns @ self.deviation.values[:, None]
        along = mapped[..., 0] + expected[..., 0]
        errors = columns @ self.deviation.factor
        of_model = errors @ transposed(errors)
        of_noise = mapping @ residuals.noise @ transposed(mapping)
        covariance = of_model + of_noise + self._at_standstill(state, efforts)
        effect = self._effect(mapping, state)
        sensed = DriveEfforts(
            along,
            covariance,
            effect,
            residuals.is_ready,
            self._length,
        )
        return sensed.force(self.frame, self.threshold)

    def _count_axes(self) -> int:
        """Number of axes of the wrench: forces alone, or moments too."""
        moments = self.options.moments
        if moments is None:
            moments = len(self.drives) >= SIX
        return SIX if moments else SIX // 2

    def _columns(self, mapping: Array, state: ClosedState, efforts: Array) -> Array:
        """Change (N, k, p) of the efforts with each error of the model.

        The share of accelerations is left out: a hundredth of inertial efforts is small.
        """
        still = np.zeros_like(state.u)
        regressor = self.robot.regressor(state, still, self._parameters, self.loads)
        rates = state.ds[:, self._indices]
        signs = rates / np.hypot(rates, self.loads.effects.smoothing[self._indices])
        shares = self.deviation.values[-len(self.drives) :]
        sensed = drive_columns(efforts, signs, shares)
        return np.concatenate([mapping @ regressor, sensed], axis=2)

    def _at_standstill(self, state: ClosedState, efforts: Array) -> Array:
        """Covariance (N, k, k) of the friction that holds drives at rest, by efforts (N, k)."""
        rates = state.ds[:, self._indices]
        width = UNSURE * self.loads.effects.smoothing[self._indices]
        is_open = 1.0 - np.abs(rates) / np.hypot(rates, width)
        # that of a uniform distribution between minus and plus the friction
        friction = self._friction + self._share * np.abs(efforts)
        variance = (is_open * friction) ** 2 / 3.0
        return np.asarray(variance[:, :, None] * np.eye(len(self.drives)))

    def _holding_friction(self) -> Array:
        """Largest Coulomb friction (k,) that may hold each drive at rest [N m, N]."""
        values = self._parameters.values(self.robot.description, self.loads.effects)
        deviations = np.sqrt((self.deviation.factor**2).sum(axis=1))
        largest: list[float] = []
        for drive in self.drives:
            k = self._parameters.names.index(f"{drive}.coulomb")
            offset = abs(float(self.deviation.values[k]))
            error = offset + float(deviations[k])
            largest.append(float(values[k]) + error)
        return np.array(largest)

    def _effect(self, mapping: Array, state: ClosedState) -> Array:
        """Change (N, k, c) of the efforts with force and moment in the axes of the frame."""
        jacobian = self.robot.jacobian(state, self.frame)
        pose = self.robot.forward_kinematics(state, self.frame)
        to_frame = transposed(pose.rotation)
        linear = to_frame @ jacobian[:, :3]
        angular = to_frame @ jacobian[:, 3:]
        in_frame = np.concatenate([linear, angular], axis=1)
        sensed = in_frame[:, : self._axes]
        return np.asarray(mapping @ transposed(sensed))


class ToolForceObserver:
    """Observer and model in one: the force at the tool, sample by sample or on arrays.

    Attributes:
        model: from residuals to the force.
        observer: the momentum observer, of order 2.
    """

    def __init__(self, model: ToolForceModel) -> None:
        require_type("model", model, ToolForceModel, "ToolForceModel(robot, drives)")
        self.model = model
        options = model.options
        self.observer = MomentumObserver(
            model.robot,
            options.cutoff,
            2,
            options.max_gap,
            model.loads,
        )

    def step(self, time: float, state: ClosedState, efforts: ArrayLike) -> ToolForce:
        """The force after one more sample, as a batch of one.

        Args:
            time: [s], later than that of the sample before.
            state: closed state with rates.
            efforts: (k,) measured efforts of the drives [N m, N].

        Raises:
            InputError: the clock does not rise, a shape is wrong, or an effort is not finite.
        """
        require_type("state", state, ClosedState, "robot.close(u, du)")
        row = real_array("efforts", efforts)
        batch = ClosedState.joined([state])
        return self.run([time], batch, row[None])

    def run(self, time: ArrayLike, state: ClosedState, efforts: ArrayLike) -> ToolForce:
        """The force at N more samples; equal to `step` bit by bit.

        Args:
            time: (N,) [s], rising.
            state: closed states with rates, a batch of N.
            efforts: (N, k) measured efforts of the drives [N m, N].

        Raises:
            InputError: the clock does not rise, a shape is wrong, or an effort is not finite.
        """
        measured = real_array("efforts", efforts)
        residuals = self.residuals(time, state, measured)
        return self.model.forces(residuals, state, measured)

    def residuals(self, time: ArrayLike, state: ClosedState, efforts: Array) -> Residuals:
        """The residuals at N more samples; arguments and errors are those of `run`."""
        expected = (len(state.u), len(self.model.drives))
        if efforts.shape != expected:
            raise InputError(f"efforts has shape {efforts.shape}; expected {expected}")
        named = dict(zip(self.model.drives, efforts.T, strict=True))
        tau = self.model.robot.generalised_forces(state, named)
        return self.observer.run(time, state, tau)


def tool_force(
    run: MeasuredRun,
    empty: MeasuredRun | None = None,
    options: ToolForceOptions | None = None,
    loads: Loads | None = None,
    tolerances: Tolerances | None = None,
) -> ToolForce:
    """The force of the surroundings on the tool in a measured run.

    Args:
        run: the run, a motion with times; all samples have efforts of all its drives.
        empty: a run of the same machine without contact. It shows the errors of the model.
        options: how the force is found.
        loads: loads besides the actuators and this force, such as the load in the bucket.
        tolerances: how wrong the model may be.

    Raises:
        SensorError: chambers are exchanged, or a unit is wrong. It is an InputError.
        InputError: the run has no times, or a sample lacks an effort.
    """
    require_type("run", run, MeasuredRun, "MeasuredRun.from_samples(...)")
    if run.time is None:
        raise InputError("run has no times: a momentum observer takes a motion")
    robot = run.robot
    limits = tolerances or Tolerances()
    given = robot.loads
    if loads is not None:
        given = loads
    if empty is None:
        deviation = deviation_before(robot, run.drives, given, limits)
    else:
        same_drives = empty.of_drives(run.drives)
        deviation = deviation_of(same_drives, given, limits)
    model = ToolForceModel(
        robot,
        run.drives,
        options,
        given,
        deviation,
    )
    observer = ToolForceObserver(model)
    residuals = observer.residuals(run.time, run.state, run.efforts)
    is_ready = residuals.is_ready & ~_at_ends(run.time, run.bandwidth)
    inner = residuals._replace(is_ready=is_ready)
    answer = model.forces(inner, run.state, run.efforts)
    if _is_permanent(answer):
        _check_sensors(run, model, limits)
    return answer


def _is_permanent(answer: ToolForce) -> bool:
    """Whether nearly all samples have contact, as with a sensor that is off."""
    ready = answer.contact[answer.is_ready]
    return len(ready) > 0 and float(ready.mean()) > PERMANENT


def _check_sensors(run: MeasuredRun, model: ToolForceModel, limits: Tolerances) -> None:
    """Raise SensorError for efforts in another unit, or for exchanged chambers.

    Chambers are exchanged if the other way round at least half of the samples have no contact.
    """
    modelling = Modelling(run, model.loads, model.frame, limits)
    check_units(run, modelling.equations(run, loaded=False))
    assert run.time is not None  # noqa: S101 - a motion has times
    names = [name for name in run.drives if name in run.exchanged]
    for count in range(1, len(names) + 1):
        for exchanged in combinations(names, count):
            efforts = run.efforts.copy()
            for name in exchanged:
                efforts[:, run.drives.index(name)] = run.exchanged[name]
            answer = ToolForceObserver(model).run(run.time, run.state, efforts)
            contact = answer.contact[answer.is_ready]
            if float(contact.mean()) < FREE:
                raise exchanged_chambers(exchanged)


def _at_ends(time: Array, bandwidth: float) -> Mask:
    """Mask (N,) of samples near the ends of a run that was smoothed to a bandwidth [Hz]."""
    near = END / bandwidth
    at_start = time < time[0] + near
    at_end = time > time[-1] - near
    return np.asarray(at_start | at_end)


def _threshold(count: int, false_alarms: float) -> float:
    """The value that a sum of `count` squares of normal numbers passes with this probability."""
    from scipy.special import chdtri  # noqa: PLC0415  slow to import

    return float(chdtri(count, false_alarms))


def _check(robot: Robot, drives: tuple[str, ...], frame: str) -> None:
    """Raise InputError if no drive is measured, or a name is unknown."""
    require_type("robot", robot, Robot, "load(...)")
    if not drives:
        raise InputError(f"no drive is measured; expected some of {', '.join(robot.drives)}")
    for name in drives:
        if name not in robot.drives:
            raise InputError(f"drives: {no_such_name('drive', name, robot.drives)}")
    if frame not in robot.frames:
        raise InputError(f"frame: {no_such_name('frame', frame, robot.frames)}")
