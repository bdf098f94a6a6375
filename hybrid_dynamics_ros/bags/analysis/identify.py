"""Identification of parameters from a recording, with the last part held out for testing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from operator import attrgetter
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import Loads
from hybrid_dynamics_core.dynamics.parameters import Parameters, described_parameters
from hybrid_dynamics_core.errors import InputError
from hybrid_dynamics_core.ground.suggestions import suggestion
from hybrid_dynamics_core.ground.wording import counted, singular_or_plural
from hybrid_dynamics_core.identification import (
    identify,
    least_deviation,
    noise_limit,
    robust_deviation,
)
from hybrid_dynamics_core.robot.robot import Robot

from ...messages.joint_samples import FloatArray
from ...messages.pressures import PRESSURES
from ..errors import BagError
from .identification_result import ExcludedSample, IdentificationResult
from .recording import EvaluatedRecording

_MIN_SAMPLES: Final = 10
_MARGIN: Final = 0.02  # share of the samples before the held-out part that neither part uses
_MOST: Final = 0.5  # least share of samples with efforts that makes a joint count as measured
_TINY: Final = 1e-300

Rows = NDArray[np.intp]


def requested_parameters(
    robot: Robot, links: Sequence[str] = (), friction: Sequence[str] = ()
) -> Parameters:
    """Inertias of some links and friction of some joints.

    Args:
        robot: the robot.
        links: names of links; empty: all links with mass.
        friction: names of joints.

    Raises:
        InputError: a name is no moving link or no joint.
    """
    description = robot.description
    moving = [name for name in description.links if name != description.base]
    _require_names(links, moving, "moving link")
    _require_names(friction, list(description.joints), "joint")
    parameters = described_parameters(description, tuple(dict.fromkeys(friction)))
    if links:
        parameters = replace(parameters, links=tuple(dict.fromkeys(links)))
    return parameters


def _require_names(names: Sequence[str], candidates: Sequence[str], what: str) -> None:
    for name in names:
        if name not in candidates:
            hint = suggestion(name, candidates)
            raise InputError(f"'{name}' is not a {what}{hint}; they are {', '.join(candidates)}")


def identify_recording(
    recording: EvaluatedRecording, parameters: Parameters | None = None, hold_out: float = 0.25
) -> IdentificationResult:
    """Identify parameters from recorded efforts; the last part of the recording is held out.

    Args:
        recording: a recording with efforts.
        parameters: see `requested_parameters`; None: inertias of all links with mass.
        hold_out: share of held-out samples.

    Raises:
        BagError: there are no recorded efforts.
        InputError: the motion does not determine the parameters.
    """
    robot = recording.robot
    columns = _measured_columns(recording)
    joints = tuple(robot.active[k] for k in columns)
    recorded = recording.recorded[:, columns]
    training, test = _split(_usable_rows(recording, columns), hold_out)
    if parameters is None:
        parameters = requested_parameters(robot)
    identification = identify(
        robot,
        recording.state.rows(training),
        recording.acceleration[training],
        recorded[training],
        parameters,
        recording.loads,
        joints,
    )
    identified = Robot(identification.described(robot.description))
    loads = identified.loads.with_gravity(recording.loads.gravity)
    residual = _residual(identified, recording, test, loads)[:, columns]
    file_residual = _residual(robot, recording, test, recording.loads)[:, columns]
    is_outlier = _is_unexplained(residual, file_residual, recorded[test])
    excluded = _excluded_outliers(recording)
    excluded += _excluded_efforts(
        recording,
        joints,
        training[identification.outlying],
        identification.residual[identification.outlying],
        identification.noise,
    )
    excluded += _excluded_efforts(
        recording, joints, test[is_outlier], file_residual[is_outlier], file_residual.std(axis=0)
    )
    test = test[~is_outlier]
    return IdentificationResult(
        identification=identification,
        joints=joints,
        training_count=int((~identification.outlying).sum()),
        test_count=len(test),
        residual=residual[~is_outlier].std(axis=0),
        file_residual=file_residual[~is_outlier].std(axis=0),
        effort_deviation=recorded[test].std(axis=0),
        excluded=tuple(sorted(excluded, key=attrgetter("time"))),
        file_values=np.asarray(identification.base.values(parameters.values(robot.description))),
    )


def _measured_columns(recording: EvaluatedRecording) -> list[int]:
    """Indices of active joints with efforts in most samples; all if no sample has any."""
    counts = np.isfinite(recording.recorded).sum(axis=0)
    columns = np.flatnonzero(counts > _MOST * counts.max(initial=0))
    if not len(columns):
        columns = np.arange(len(counts))
    return [int(column) for column in columns]


def _usable_rows(recording: EvaluatedRecording, columns: Sequence[int]) -> Rows:
    """Samples with accelerations and efforts of some joints; raises BagError if there are none."""
    has_efforts = np.isfinite(recording.recorded[:, columns]).all(axis=1)
    has_accelerations = np.isfinite(recording.acceleration).all(axis=1)
    rows = np.flatnonzero(has_efforts & has_accelerations)
    if len(rows) >= _MIN_SAMPLES:
        return rows
    have = singular_or_plural(len(rows), "has", "have")
    text = (
        f"{recording.topic}: {counted(len(rows), 'sample')} {have} recorded efforts of"
        f" {', '.join(recording.robot.active[k] for k in columns)} and accelerations;"
        " identification needs the effort field of the recorded joint states, or pressures of"
        f" the cylinders ({PRESSURES})"
    )
    if recording.is_computed:
        text += (
            "; these are what `bag process` computed: process the recording with --keep, which"
            " takes its topics over too, or identify from the recording itself"
        )
    raise BagError(text)


def _split(rows: Rows, hold_out: float) -> tuple[Rows, Rows]:
    """Rows for training and, after a margin, held-out rows."""
    cut = round(len(rows) * (1.0 - hold_out))
    margin = round(_MARGIN * len(rows))
    return rows[: max(cut - margin, 1)], rows[cut:]


def _residual(robot: Robot, recording: EvaluatedRecording, rows: Rows, loads: Loads) -> FloatArray:
    """Recorded efforts of some rows minus those of a robot (k, n) [N m or N]."""
    state = robot.close(recording.state.u[rows], recording.state.du[rows])
    computed = robot.inverse_dynamics(state, recording.acceleration[rows], loads)
    residual: FloatArray = recording.recorded[rows] - computed
    return residual


def _is_unexplained(
    residual: FloatArray, file_residual: FloatArray, efforts: FloatArray
) -> NDArray[np.bool_]:
    """Mask (N,) of samples whose efforts neither the estimates nor the robot file explain.

    The smaller residual counts, so that a systematic error of one model excludes no sample.

    Args:
        residual: recorded efforts less those of the estimates (N, n) [N m or N].
        file_residual: the same of the robot file (N, n) [N m or N].
        efforts: recorded ones (N, n) [N m or N].
    """
    centred = np.abs(residual - np.median(residual, axis=0))
    file_centred = np.abs(file_residual - np.median(file_residual, axis=0))
    least = np.minimum(centred, file_centred)
    deviation = np.maximum(robust_deviation(least), _TINY)
    deviation = least_deviation(deviation, robust_deviation(efforts), least.size)
    limit = noise_limit(least.size) * deviation
    return np.asarray((least > limit).any(axis=1))


def _excluded_outliers(recording: EvaluatedRecording) -> list[ExcludedSample]:
    """The outliers of the motion."""
    excluded = []
    for outlier in recording.outliers:
        what = "velocity" if outlier.rate else "position"
        joint = recording.measured[outlier.joint]
        time = outlier.at(recording.start_ns)
        excluded.append(ExcludedSample(time, joint, outlier.off, what, outlier.late))
    return excluded


def _excluded_efforts(
    recording: EvaluatedRecording,
    joints: Sequence[str],
    rows: Rows,
    residual: FloatArray,
    noise: FloatArray,
) -> list[ExcludedSample]:
    """Samples with outlying efforts.

    Args:
        recording: the recording.
        joints: joints with efforts.
        rows: rows of the samples (k,).
        residual: residuals of their efforts (k, n) [N m or N].
        noise: standard deviation of each joint's effort (n,) [N m or N].
    """
    excluded = []
    scale = np.maximum(noise, _TINY)
    for row, values in zip(rows.tolist(), residual, strict=True):
        joint = int(np.argmax(np.abs(values) / scale))
        time = float(recording.time[row])
        name = joints[joint]
        excluded.append(ExcludedSample(time, name, float(values[joint]), "effort"))
    return excluded
