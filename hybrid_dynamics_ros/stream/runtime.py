"""Everything that belongs to one configured robot: made at configure, thrown away at cleanup.

Knows no rclpy.
"""

from __future__ import annotations

import threading

import numpy as np

from hybrid_dynamics_core import Loads, Payload, Robot
from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_core.ground.suggestions import no_such_name
from hybrid_dynamics_core.ground.wording import one_line

from ..messages.joint_samples import JointSample, Rejection
from ..parameters import (
    BANDWIDTH,
    MAX_GAP,
    MEASURED,
    PAYLOAD_FRAME,
    STILL,
    NodeSettings,
    ParameterError,
)
from .conditions import ConditionChange, Conditions, calibration_of, loads_of
from .monitor import Monitor
from .pipeline import Pipeline
from .results import MotionResult
from .situation import Situation
from .stroke_margins import StrokeMargins


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
        self.pipeline = Pipeline(robot, settings[BANDWIDTH], settings[MAX_GAP], measured)
        self.evaluator = self.pipeline.evaluator
        self.monitor = Monitor(StrokeMargins(robot))
        self.lock = threading.RLock()  # the stream and calls that change something take turns
        self.result: MotionResult | None = None
        self.conditions = Conditions()
        self._taken: NodeSettings | None = None
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
        if any(settings[row] != self.settings[row] for row in (BANDWIDTH, MAX_GAP)):
            self.evaluator.set_filter(settings[BANDWIDTH], settings[MAX_GAP])
        self.conditions, self.settings, self._taken = conditions, settings, settings

    def prepare(self, change: ConditionChange) -> None:
        """Have the code for a change generated while the stream goes on."""
        self._generate(loads_of(self.robot, change.applied(self.conditions)))

    def change(self, change: ConditionChange) -> None:
        """Work under changed conditions from now on; whoever made the change has checked them."""
        with self.lock:
            conditions = change.applied(self.conditions)
            self.evaluator.loads = loads_of(self.robot, conditions)
            if conditions.mode is not self.conditions.mode:
                self.evaluator.set_mode(conditions.mode)
            self.conditions = conditions

    def process(self, sample: JointSample) -> MotionResult | Rejection:
        """The result of one sample, under the conditions of now."""
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
        return rates is None or bool(np.abs(rates).max() > self.settings[STILL])

    def situation(self) -> Situation:
        """How things stand, for whoever answers a call."""
        result = self.result
        return Situation(
            conditions=self.conditions,
            settings=self.settings,
            measured=self.measured,
            newest=None if result is None else result.active.position,
            moving=self.moving,
        )

    def reset(self) -> None:
        """Forget the samples so far; the counts stay."""
        self.evaluator.reset()
        self.result = None

    def _warm_up(self) -> None:
        robot = self.robot
        state = robot.close(robot.reference)
        robot.forward_kinematics(state)
        robot.jacobian(state)
        robot.hydraulics(state, np.zeros(state.n))
        bare = loads_of(robot, Conditions(gravity=self.conditions.gravity))
        frame = self.settings[PAYLOAD_FRAME] or robot.end_effector
        loaded = bare.with_payload(Payload(1.0), frame)
        # What parameters may bring while messages flow.
        for loads in (bare, loaded, self.evaluator.loads):
            self._generate(loads)

    def _generate(self, loads: Loads) -> None:
        self.evaluator.prepare(loads)
        state = self.robot.close(self.robot.reference)
        self.robot.reactions(state, np.zeros(state.n), loads)


def _require_names(
    parameter: str, kind: str, names: tuple[str, ...], allowed: tuple[str, ...]
) -> None:
    for name in names:
        if name not in allowed:
            raise ParameterError(f"parameter {parameter}: {no_such_name(kind, name, allowed)}")
        if names.count(name) > 1:
            raise ParameterError(f"parameter {parameter}: joint '{name}' is named twice")
