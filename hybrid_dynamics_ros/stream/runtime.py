"""The runtime of one configured robot, from configure to cleanup.

This module does not depend on rclpy.
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
    NewZero,
    PayloadBody,
    calibration_of,
    kalman_of,
    loads_of,
    poses_of,
)
from .estimates.sensor_input import sensor_input_of
from .monitor import Monitor
from .pipeline import Pipeline
from .rehearsal import Rehearsal, rehearse
from .results import MotionResult
from .situation import Situation
from .stroke_margins import StrokeMargins

Kind = tuple[tuple[str, ...], bool]
_SOME_BODY: Final = PayloadBody(1.0, (0.0,) * 3, (0.0,) * 6)


class Runtime:
    """Pipeline, conditions, settings and newest result of one robot."""

    def __init__(self, robot: Robot, settings: NodeSettings) -> None:
        """Make the pipeline, and compile the robot's code before the first message.

        Raises:
            HybridDynamicsError: the measured joints do not determine the others, or the payload is
                impossible.
            ParameterError: a parameter does not fit this robot.
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
            poses_of(robot, settings),
        )
        self.sensors = sensor_input_of(robot, measured, settings)
        self.evaluator = self.pipeline.evaluator
        self.monitor = Monitor(StrokeMargins(robot))
        self.monitor.sensors = self.sensors
        self.monitor.tool = self.pipeline.tool
        self.monitor.chambers = self.pipeline.chambers
        self.monitor.supply = self.pipeline.pressures.supply
        self.lock = threading.RLock()  # for the stream and for calls with changes
        self.result: MotionResult | None = None
        self.conditions = Conditions()
        # Called with the payloads after each change.
        self.payloads_changed: Callable[[Mapping[str, PayloadBody]], None] = lambda _: None
        self._taken: NodeSettings | None = None
        self._prepared: set[Kind] = set()
        # Compiles code in another process into the cache; returns whether the robot is still in
        # use.
        self.make_code: Callable[[Rehearsal], bool] = lambda _: True
        self.take(settings)
        self._warm_up()

    @property
    def measured(self) -> tuple[str, ...]:
        """Names of the measured joints."""
        return self.evaluator.measured

    def problem(self, settings: NodeSettings) -> str:
        """The reason why the settings do not fit the robot; "" if they do."""
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
        """The conditions under some settings.

        Raises:
            HybridDynamicsError: the payload is none.
            ParameterError: its frame is none of the robot.
        """
        return self._conditions(settings)[0]

    def take(self, settings: NodeSettings) -> None:
        """Apply settings.

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
        for source in self.pipeline.poses.every:
            source.max_age = settings[PARTIAL_AGE]
        if settings[PASS_THROUGH]:
            self.pipeline.pass_through(settings[PARTIAL_AGE])
        if any(settings[row] != self.settings[row] for row in FILTER_ROWS):
            kalman = kalman_of(settings)
            self.evaluator.set_filter(settings[BANDWIDTH], settings[MAX_GAP], kalman)
            for source in self.pipeline.poses.every:
                source.set_filter(self.evaluator.estimator)
        self._hold(conditions)
        self.settings = self._taken = settings

    def is_prepared(self, conditions: Conditions) -> bool:
        """Whether all code for some conditions is ready, so that they take effect without delay."""
        return _kind(conditions) in self._prepared

    def prepare(self, conditions: Conditions) -> None:
        """Compile all code for some conditions, while the stream continues in another thread.

        Raises:
            HybridDynamicsError: the loads act on no frame of the robot, or are none.
        """
        if self.is_prepared(conditions):
            return
        posed = self.pipeline.poses.posed
        rehearsal = Rehearsal(self.measured, conditions, posed)
        try:
            with stored_only():
                rehearse(self.robot, rehearsal)
        except NotStoredError:
            if self.make_code(rehearsal):
                rehearse(self.robot, rehearsal)  # compiles code that the other process could not
        finally:
            self._prepared.add(_kind(conditions))

    def change(self, change: ConditionChange) -> bool:
        """Apply a checked change of conditions.

        Returns:
            True if it was applied; False if code must be prepared first.
        """
        with self.lock:
            if isinstance(change, NewZero):
                change.zero(self.pipeline.scale)
                return True
            conditions = change.applied(self.conditions)
            if not self.is_prepared(conditions):
                return False
            self.evaluator.loads = loads_of(self.robot, conditions)
            if conditions.mode is not self.conditions.mode:
                self.evaluator.set_mode(conditions.mode)
            self._hold(conditions)
            return True

    def _hold(self, conditions: Conditions) -> None:
        """Set the conditions."""
        before, self.conditions = self.conditions, conditions
        if conditions.payloads != before.payloads:
            self.payloads_changed(conditions.payloads)

    def process(self, sample: JointSample) -> MotionResult | Rejection | None:
        """The result of one sample, or its rejection; None if it waits for other joints."""
        with self.lock:
            return self.pipeline.process(sample)

    @property
    def moving(self) -> bool:
        """Whether a joint was moving at the newest input.

        A joint with unknown rate counts as moving.
        """
        if self.result is None:
            return False
        rates = self.result.velocity
        return rates is None or not np.abs(rates).max() <= self.settings[STILL]  # also true for NaN

    def situation(self) -> Situation:
        """The situation, for service calls."""
        result = self.result
        return Situation(
            conditions=self.conditions,
            settings=self.settings,
            measured=self.measured,
            newest=None if result is None else result.position[: len(self.robot.active)],
            moving=self.moving,
            weighed=self.pipeline.scale.duration,
        )

    def reset(self) -> None:
        """Discard the samples so far; counts are kept."""
        self.evaluator.reset()
        self.pipeline.readings.joiner.clear()
        self.pipeline.chambers.clear()
        self.pipeline.pressures.supply.clear()
        self.pipeline.tool.reset()
        self.pipeline.scale.reset()
        for source in self.pipeline.poses.every:
            source.clear()
        if self.sensors is not None:
            self.sensors.clear()
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
        # Conditions that most calls and parameters lead to.
        for conditions in (bare, loaded, self.conditions):
            self.prepare(conditions)


def _kind(conditions: Conditions) -> Kind:
    """The properties of conditions that decide their code; values of loads do not matter."""
    return tuple(conditions.payloads), conditions.mode is None


def _require_names(
    parameter: str, kind: str, names: tuple[str, ...], allowed: tuple[str, ...]
) -> None:
    for name in names:
        if name not in allowed:
            raise ParameterError(f"parameter {parameter}: {no_such_name(kind, name, allowed)}")
        if names.count(name) > 1:
            raise ParameterError(f"parameter {parameter}: joint '{name}' is named twice")
