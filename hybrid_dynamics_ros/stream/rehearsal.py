"""Rehearsal: all code of a stream under some conditions is run once, to compile it.

This module does not depend on ROS.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from hybrid_dynamics_core import ClosedState, Loads, Robot
from hybrid_dynamics_core.errors import HybridDynamicsError

from ..messages.joint_samples import FloatArray, OrderedMotion, RejectedError
from ..parameters import BANDWIDTH, MAX_GAP, TF_RATE, NodeSettings
from .conditions import Conditions, loads_of
from .estimates.payload import LEAST, SPACING, PayloadInput, Window
from .estimates.tool_force import ToolForceInput
from .floating.base import PosedJoint
from .floating.evaluator import evaluator_of
from .results import MotionResult
from .topics import topics_of

_INTERVAL: Final = 10_000_000  # [ns] between samples
_SAMPLES: Final = 5  # number with velocities, and without: enough for the filters
_STEP: Final = 1e-4  # [rad or m] between samples, so that loops are followed
_FAR: Final = 1e3  # [rad or m] where loops do not close, to run the code of errors


@dataclass(frozen=True, eq=False)
class Rehearsal:
    """Parameters of a rehearsal: plain data for the compiling process.

    Attributes:
        measured: names of the measured joints.
        conditions: the conditions.
        posed: ball and free joints with measured poses.
    """

    measured: tuple[str, ...]
    conditions: Conditions
    posed: tuple[PosedJoint, ...] = ()


def rehearse(robot: Robot, rehearsal: Rehearsal) -> None:
    """Evaluate the model and encode every topic for a few samples of each kind.

    Raises:
        HybridDynamicsError: the loads are wrong, or act on an unknown frame.
        NotStoredError: code is missing from the cache, where compilation is not allowed.
    """
    conditions = rehearsal.conditions
    loads = loads_of(robot, conditions)
    evaluator = evaluator_of(
        robot, BANDWIDTH.default, MAX_GAP.default, rehearsal.measured, posed=rehearsal.posed
    )
    evaluator.prepare(loads)
    evaluator.loads = loads
    if conditions.mode is not None:
        evaluator.set_mode(conditions.mode)
    topics = topics_of(robot, NodeSettings({TF_RATE.name: 0.0}))
    tool, scale = ToolForceInput(robot), PayloadInput(robot)
    position = _start(robot, rehearsal)
    for k, motion in enumerate(_motions(position)):
        # Refused samples are rehearsed too.
        with suppress(HybridDynamicsError, RejectedError), np.errstate(all="ignore"):
            result = evaluator.step(k * _INTERVAL, motion)
            if robot.cylinders:
                result.measured_forces = np.ones(len(robot.drives))
                result.observe(tool, scale, True)
                _force_of(result)
            for topic in topics:
                topic.fill(result)
    if robot.cylinders and conditions.mode is None:
        _weigh(robot, loads)


def _weigh(robot: Robot, loads: Loads) -> None:
    """Compile the code of weighing, by a window of samples at the reference."""
    count = int(2.0 * LEAST / SPACING)
    stamps = (np.arange(count) * SPACING * 1e9).astype(np.int64)
    travel = _STEP * np.sin(np.arange(count))[:, None]
    position = robot.reference + travel
    forces = np.where([name in robot.cylinders for name in robot.drives], 1.0 + travel, np.nan)
    Window(robot, loads, stamps, position, forces, None, in_file_modes=True).reading()


def _force_of(result: MotionResult) -> None:
    """Compile the code of the force at the tool."""
    residue = result.residue
    if residue is None:
        return
    ready = np.ones_like(residue.residuals.is_ready)
    residuals = residue.residuals._replace(is_ready=ready)
    replace(residue, residuals=residuals).force(ClosedState.joined([result.state]))


def _start(robot: Robot, rehearsal: Rehearsal) -> FloatArray:
    """Positions of the measured joints at the first sample."""
    state = rehearsal.conditions.mode or robot.close(robot.reference)
    return np.array([state.s[robot.coordinates.index(name)] for name in rehearsal.measured])


def _motions(position: FloatArray) -> Iterator[OrderedMotion]:
    """Samples without rates, with velocities, with accelerations, and one out of reach."""
    still = np.zeros_like(position)
    for k in range(_SAMPLES):
        yield OrderedMotion(position + k * _STEP, None, None)
    for k in range(_SAMPLES):
        yield OrderedMotion(position + k * _STEP, still, None)
    yield OrderedMotion(position, still, still)
    yield OrderedMotion(position + _FAR, still, still)
