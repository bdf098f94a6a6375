"""Everything that belongs to one configured robot: made at configure, thrown away at cleanup.

Knows no rclpy.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Final

import numpy as np

from hybrid_dynamics_core import Loads, Robot
from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_core.ground.suggestions import no_such_name
from hybrid_dynamics_core.ground.wording import one_line
from hybrid_dynamics_core.kernels.run import NotStoredError, stored_only

from ..messages.joint_samples import JointSample, Rejection
from ..parameters import (
    BANDWIDTH,
    FILTER_ROWS,
    MAX_GAP,
    MEASURED,
    PARTIAL_AGE,
    PASS_THROUGH,
    PAYLOAD_FRAME,
    STILL,
    NodeSettings,
    ParameterError,
)
from .conditions import (
    ConditionChange,
    Conditions,
    PayloadBody,
    calibration_of,
    kalman_of,
    loads_of,
    odometry_of,
)
from .monitor import Monitor
from .pipeline import Pipeline
from .rehearsal import Rehearsal, rehearse
from .results import MotionResult
from .situation import Situation
from .stroke_margins import StrokeMargins

Kind = tuple[tuple[str, ...], bool]
_SOME_BODY: Final = PayloadBody(1.0, (0.0,) * 3, (0.0,) * 6)


class Runtime:
    """One robot at work: pipeline, conditions, settings, and the newest result."""

    def __init__(self, robot: Robot, settings: NodeSettings) -> None:
        """Make it, and have the robot's code generated before the first message waits for it.

        Raises:
            HybridDynamicsError: the measured joints do not determine the others, or the payload is
                none.
            ParameterError: a parameter does not go with this robot.
        """
        self.robot = robot
        self.settings = settings
        measured = settings[MEASURED] or robot.active
        _require_names("measured", "joint", measured, robot.coordinates)
        self.pipeline = Pipeline(
            robot,
            settings[BANDWIDTH],
            settings[MAX_GAP],
            measured,
            kalman_of(settings),
            odometry_of(robot, settings),
        )
        self.evaluator = self.pipeline.evaluator
        self.monitor = Monitor(StrokeMargins(robot))
        self.lock = threading.RLock()  # the stream and calls that change something take turns
        self.result: MotionResult | None = None
        self.conditions = Conditions()
        # Is given the payloads whenever others are in effect.
        self.payloads_changed: Callable[[Mapping[str, PayloadBody]], None] = lambda _: None
        self._taken: NodeSettings | None = None
        self._prepared: set[Kind] = set()
        # Makes code elsewhere and keeps it on disk; whether the robot still needs it.
        self.make_code: Callable[[Rehearsal], bool] = lambda _: True
        self.take(settings)
        self._warm_up()

    @property
    def measured(self) -> tuple[str, ...]:
        """Joints that the input gives."""
        return self.evaluator.measured

    def problem(self, settings: NodeSettings) -> str:
        """Why the robot cannot work with these settings, or ""."""
        try:
            self._conditions(settings)
        except (HybridDynamicsError, ParameterError) as error:
            return one_line(error)
        return ""

    def _conditions(self, settings: NodeSettings) -> tuple[Conditions, Loads]:
        frame = settings[PAYLOAD_FRAME] or self.robot.end_effector
        _require_names(PAYLOAD_FRAME.name, "frame", (frame,), self.robot.frames)
        conditions = self.conditions.with_settings(settings, self._taken, self.robot.end_effector)
        return conditions, loads_of(self.robot, conditions)

    def conditions_under(self, settings: NodeSettings) -> Conditions:
        """What would hold with these settings.

        Raises:
            HybridDynamicsError: the payload is none.
            ParameterError: its frame is none of the robot.
        """
        return self._conditions(settings)[0]

    def take(self, settings: NodeSettings) -> None:
        """Work with these settings from now on.

        Raises:
            HybridDynamicsError: the payload is none.
            ParameterError: its frame is none of the robot.
        """
        with self.lock:
            self._take(settings)

    def _take(self, settings: NodeSettings) -> None:
        conditions, loads = self._conditions(settings)
        self.evaluator.loads = loads
        self.evaluator.calibrate(calibration_of(settings, self.measured))
        self.pipeline.readings.joiner.max_age = settings[PARTIAL_AGE]
        self.pipeline.pressures.max_age = settings[PARTIAL_AGE]
        odometry = self.pipeline.odometry
        if odometry is not None:
            odometry.max_age = settings[PARTIAL_AGE]
        if settings[PASS_THROUGH]:
            self.pipeline.pass_through(settings[PARTIAL_AGE])
        if any(settings[row] != self.settings[row] for row in FILTER_ROWS):
            kalman = kalman_of(settings)
            self.evaluator.set_filter(settings[BANDWIDTH], settings[MAX_GAP], kalman)
            if odometry is not None:
                odometry.set_filter(self.evaluator.estimator)
        self._hold(conditions)
        self.settings = self._taken = settings

    def is_prepared(self, conditions: Conditions) -> bool:
        """Whether all code for such conditions is here: taking them holds up nothing."""
        return _kind(conditions) in self._prepared

    def prepare(self, conditions: Conditions) -> None:
        """Have all code for conditions here, while the stream goes on in another thread.

        Raises:
            HybridDynamicsError: the loads act on no frame of the robot, or are none.
        """
        if self.is_prepared(conditions):
            return
        has_odometry = self.pipeline.odometry is not None
        rehearsal = Rehearsal(self.measured, conditions, has_odometry)
        try:
            with stored_only():
                rehearse(self.robot, rehearsal)
        except NotStoredError:
            if self.make_code(rehearsal):
                rehearse(self.robot, rehearsal)  # makes here what could not be made elsewhere
        finally:
            self._prepared.add(_kind(conditions))

    def change(self, change: ConditionChange) -> bool:
        """Work under changed conditions from now on; whoever made the change has checked them.

        Returns:
            Whether it is done: not where code has to be prepared first.
        """
        with self.lock:
            conditions = change.applied(self.conditions)
            if not self.is_prepared(conditions):
                return False
            self.evaluator.loads = loads_of(self.robot, conditions)
            if conditions.mode is not self.conditions.mode:
                self.evaluator.set_mode(conditions.mode)
            self._hold(conditions)
            return True

    def _hold(self, conditions: Conditions) -> None:
        """From now on these are the conditions."""
        before, self.conditions = self.conditions, conditions
        if conditions.payloads != before.payloads:
            self.payloads_changed(conditions.payloads)

    def process(self, sample: JointSample) -> MotionResult | Rejection | None:
        """The result of one sample under the conditions of now; None: it waits for other joints."""
        with self.lock:
            return self.pipeline.process(sample)

    @property
    def moving(self) -> bool:
        """Whether a joint moved at the newest input.

        One whose rate is not known counts as moving.
        """
        if self.result is None:
            return False
        rates = self.result.velocity
        return rates is None or not np.abs(rates).max() <= self.settings[STILL]  # NaN: not known

    def situation(self) -> Situation:
        """How things stand, for whoever answers a call."""
        result = self.result
        return Situation(
            conditions=self.conditions,
            settings=self.settings,
            measured=self.measured,
            newest=None if result is None else result.position[: len(self.robot.active)],
            moving=self.moving,
        )

    def reset(self) -> None:
        """Forget the samples so far; the counts stay."""
        self.evaluator.reset()
        self.pipeline.readings.joiner.clear()
        if self.pipeline.odometry is not None:
            self.pipeline.odometry.clear()
        self.result = None

    def _warm_up(self) -> None:
        robot = self.robot
        state = robot.close(robot.reference)
        robot.forward_kinematics(state)
        robot.jacobian(state)
        robot.hydraulics(state, np.zeros(state.n))
        bare = Conditions(gravity=self.conditions.gravity)
        frame = self.settings[PAYLOAD_FRAME] or robot.end_effector
        loaded = bare.with_payload(frame, _SOME_BODY)
        # What most calls and parameters bring while messages flow.
        for conditions in (bare, loaded, self.conditions):
            self.prepare(conditions)


def _kind(conditions: Conditions) -> Kind:
    """What decides which code conditions need; values of loads do not."""
    return tuple(conditions.payloads), conditions.mode is None


def _require_names(
    parameter: str, kind: str, names: tuple[str, ...], allowed: tuple[str, ...]
) -> None:
    for name in names:
        if name not in allowed:
            raise ParameterError(f"parameter {parameter}: {no_such_name(kind, name, allowed)}")
        if names.count(name) > 1:
            raise ParameterError(f"parameter {parameter}: joint '{name}' is named twice")
