"""Everything that belongs to one configured robot: made whole at configure, thrown away whole at cleanup.

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
    ParameterError,
    Settings,
)
from .conditions import Change, Conditions, calibration_of, loads_of
from .monitor import Monitor
from .pipeline import Pipeline
from .results import MotionResult
from .situation import Situation
from .stroke_margins import Strokes


class Runtime:
    """One robot at work: pipeline, conditions, settings, and what was seen last."""

    def __init__(self, robot: Robot, settings: Settings) -> None:
        """Make it, and have the robot's code generated now, not while the first message waits for it.

        Raises:
            HybridDynamicsError: the measured joints do not determine the others, or the payload is
            none.
            ParameterError: a parameter does not go with this robot.
        """
        self.robot = robot
        self.settings = settings
        measured = settings[MEASURED] or robot.active
        _require_known("measured", "joint", measured, robot.coordinates)
        self.pipeline = Pipeline(robot, settings[BANDWIDTH], settings[MAX_GAP], measured)
        self.evaluator = self.pipeline.evaluator
        self.monitor = Monitor(Strokes(robot))
        self.lock = threading.RLock()  # the stream and calls that change something take turns
        self.result: MotionResult | None = None
        self.conditions = Conditions()
        self._taken: Settings | None = None
        self.take(settings)
        self._warm_up()

    @property
    def measured(self) -> tuple[str, ...]:
        """Joints that the input gives."""
        return self.evaluator.measured

    def problem(self, settings: Settings) -> str:
        """Why the robot cannot work with these settings, or ""."""
        try:
            self._conditions(settings)
        except (HybridDynamicsError, ParameterError) as error:
            return one_line(error)
        return ""

    def _conditions(self, settings: Settings) -> tuple[Conditions, Loads]:
        frame = settings[PAYLOAD_FRAME] or self.robot.end_effector
        _require_known(PAYLOAD_FRAME.name, "frame", (frame,), self.robot.frames)
        conditions = self.conditions.with_settings(settings, self._taken, self.robot.end_effector)
        return conditions, loads_of(self.robot, conditions)

    def take(self, settings: Settings) -> None:
        """Work with these settings from now on.

        Raises:
            HybridDynamicsError: the payload is none.
            ParameterError: its frame is none of the robot.
        """
        with self.lock:
            self._take(settings)

    def _take(self, settings: Settings) -> None:
        conditions, loads = self._conditions(settings)
        self.evaluator.loads = loads
        self.evaluator.calibrate(calibration_of(settings, self.measured))
        if any(settings[row] != self.settings[row] for row in (BANDWIDTH, MAX_GAP)):
            self.evaluator.set_filter(settings[BANDWIDTH], settings[MAX_GAP])
        self.conditions, self.settings, self._taken = conditions, settings, settings

    def prepare(self, change: Change) -> None:
        """Have the code for a change generated while the stream goes on."""
        self._generate(loads_of(self.robot, change.applied(self.conditions)))

    def change(self, change: Change) -> None:
        """Work under changed conditions from now on; they were checked by whoever made the change."""
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
        """Whether a joint moved at the newest input; one whose rate is not known counts as moving."""
        if self.result is None:
            return False
        rates = self.result.velocity
        return rates is None or bool(np.abs(rates).max() > self.settings[STILL])

    def situation(self) -> Situation:
        """How things stand, for whoever answers a call."""
        return Situation(
            conditions=self.conditions,
            settings=self.settings,
            measured=self.measured,
            newest=None if self.result is None else self.result.active.position,
            moving=self.moving,
        )

    def reset(self) -> None:
        """Forget what was seen; the counts stay."""
        self.evaluator.reset()
        self.result = None

    def _warm_up(self) -> None:
        robot = self.robot
        state = robot.close(robot.reference)
        robot.forward_kinematics(state)
        robot.jacobian(state)
        robot.hydraulics(state, np.zeros(state.n))
        bare, frame = (
            loads_of(robot, Conditions(gravity=self.conditions.gravity)),
            self.settings[PAYLOAD_FRAME],
        )
        for loads in (
            bare,
            bare.with_payload(Payload(1.0), frame or robot.end_effector),
            self.evaluator.loads,
        ):
            self._generate(loads)  # what parameters may bring while messages flow

    def _generate(self, loads: Loads) -> None:
        self.evaluator.prepare(loads)
        state = self.robot.close(self.robot.reference)
        self.robot.reactions(state, np.zeros(state.n), loads)


def _require_known(
    parameter: str, kind: str, names: tuple[str, ...], known: tuple[str, ...]
) -> None:
    for name in names:
        if name not in known:
            raise ParameterError(f"parameter {parameter}: {no_such_name(kind, name, known)}")
        if names.count(name) > 1:
            raise ParameterError(f"parameter {parameter}: joint '{name}' is named twice")
