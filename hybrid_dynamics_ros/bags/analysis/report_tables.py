"""The tables of a report: facts, errors of efforts, outliers and refused samples."""

from __future__ import annotations

from typing import Final

import numpy as np

from hybrid_dynamics_core.ground.units import coordinate_unit, effort_unit
from hybrid_dynamics_core.ground.wording import singular_or_plural

from ...messages.joint_samples import FloatArray
from ..sample_outliers import SampleOutlier
from .effort_error import EffortError, effort_errors
from .html_page import digits, quiet, table
from .recording import EvaluatedRecording

_MAX_LISTED: Final = 20  # samples in a table
_MAX_OUTLIERS: Final = 3  # times in the table of facts
_MAX_MISSING: Final = 4
_ERROR_HEAD: Final = (
    "recorded less computed",
    "unit",
    "50 % within",
    "95 % within",
    "far off",
    "RMS",
    "mean",
    "largest",
    "variance explained",
    "samples",
)
_ERROR_NOTE: Final = (
    "Far off: beyond what noise of this median stays within. A few such samples make most of the"
    " RMS, and hardly move what 50 % and 95 % are within."
)
_OUTLIER_HEAD: Final = ("off the motion", "joint", "off by", "stamp is")

_Row = tuple[str, str]  # name and value of a fact


def facts_table(recording: EvaluatedRecording) -> str:
    """The table of facts and numbers of a recording."""
    rows: list[_Row] = [
        ("samples", recording.counts.summary()),
        ("stamps", _stamps(recording)),
        ("missing samples", _missing(recording)),
    ]
    if not recording.is_causal:
        rows.append(("samples off the motion", _outlier_times(recording)))
    rows.append(("gaps", _gaps(recording)))
    if recording.pressed:
        rows.append(("recorded efforts", recording.pressure_source))
    if recording.robot.loops:
        residual = float(np.max(recording.state.residual))
        rows.append(("largest residual", f"{residual:.2g}"))
        rows.append(("nearest singularity", _nearest_singularity(recording)))
    joints, margins = recording.margins
    if joints:
        rows.append(("least range left", _least_margin(recording, joints, margins)))
    power = recording.power[np.isfinite(recording.power)]
    if len(power):
        largest = float(np.abs(power).max())
        rows.append(("largest power", f"{digits(largest)} W"))
    return table([], rows)


def _stamps(recording: EvaluatedRecording) -> str:
    longest, begin = recording.stamps.longest
    nominal = recording.stamps.nominal
    return (
        f"{1e3 * nominal:.4g} ms apart (median); the longest interval is {1e3 * longest:.4g} ms at"
        f" {begin:.3f} s"
    )


def _missing(recording: EvaluatedRecording) -> str:
    intervals = recording.stamps.missing
    if not intervals:
        return "0 (no interval is longer than 1.5 times the median)"
    count = recording.stamps.missing_count
    listed = ", ".join(f"{interval.begin:.3f} s" for interval in intervals[:_MAX_MISSING])
    text = f"{count}, in intervals of more than 1.5 times the median, at {listed}"
    if len(intervals) > _MAX_MISSING:
        text += f" and {len(intervals) - _MAX_MISSING} more"
    return text


def _outlier_times(recording: EvaluatedRecording) -> str:
    outliers = recording.outliers
    text = str(len(outliers))
    times = [f"{outlier.at(recording.start_ns):.3f} s" for outlier in outliers[:_MAX_OUTLIERS]]
    if times:
        text += f", at {'; '.join(times)}"
    if len(outliers) > _MAX_OUTLIERS:
        text += " ..."
    return text


def _gaps(recording: EvaluatedRecording) -> str:
    meaning = f"stamps that go back, or are more than {recording.max_gap:g} s apart"
    return f"{len(recording.gaps)} ({meaning}: estimates start anew there)"


def _nearest_singularity(recording: EvaluatedRecording) -> str:
    distances = np.asarray(recording.state.singularity)
    row = int(np.argmin(distances))
    loop = recording.state.singular_loop[row]
    return f"{float(distances[row]):.3g} of loop {loop} at {recording.time[row]:.2f} s"


def _least_margin(
    recording: EvaluatedRecording, joints: tuple[str, ...], margins: FloatArray
) -> str:
    row, column = np.unravel_index(int(np.argmin(margins)), margins.shape)
    joint = joints[column]
    unit = coordinate_unit(recording.robot.joint_types[joint])
    return f"{margins[row, column]:.4g} {unit} of {joint} at {recording.time[row]:.2f} s"


def outliers_table(recording: EvaluatedRecording) -> str:
    """The table of outliers; requires some."""
    listed = recording.outliers[:_MAX_LISTED]
    rows = [_outlier_row(recording, outlier) for outlier in listed]
    text = (
        "These samples contradict their neighbours. Accelerations are computed without them, and"
        " there are no efforts at their stamps."
    )
    unlisted = len(recording.outliers) - len(listed)
    if unlisted:
        text += f" {unlisted} more {singular_or_plural(unlisted, 'is', 'are')} not listed."
    return f"<p>{text}</p>" + table(_OUTLIER_HEAD, rows)


def _outlier_row(recording: EvaluatedRecording, outlier: SampleOutlier) -> list[str]:
    joint = recording.measured[outlier.joint]
    rate = "/s" if outlier.rate else ""
    unit = coordinate_unit(recording.robot.joint_types[joint], rate)
    late = ""
    if not np.isnan(outlier.late):
        late = f"{1e3 * abs(outlier.late):.1f} ms {outlier.word}"
    time = f"{outlier.at(recording.start_ns):.3f} s"
    return [time, joint, f"{outlier.off:.3g} {unit}", late]


def errors_table(recording: EvaluatedRecording) -> str:
    """The table of recorded minus computed efforts, for joints with both."""
    rows = [_error_row(recording, error) for error in effort_errors(recording)]
    return table(_ERROR_HEAD, rows) + quiet(_ERROR_NOTE)


def _error_row(recording: EvaluatedRecording, error: EffortError) -> list[str]:
    k = recording.robot.active.index(error.joint)
    errors = recording.errors
    largest_time = (errors.largest_ns[k] - recording.start_ns) * 1e-9
    explained = "-"
    if np.isfinite(errors.explained[k]):
        explained = f"{100.0 * errors.explained[k]:.2f} %"
    return [
        error.joint,
        effort_unit(recording.robot.joint_types[error.joint]),
        digits(error.median),
        digits(error.near),
        f"{error.far} of {error.count}, beyond {digits(error.limit)}",
        digits(errors.rms[k]),
        digits(errors.mean[k]),
        f"{digits(errors.largest[k])} at {largest_time:.3f} s",
        explained,
        str(errors.count[k]),
    ]


def refused_table(recording: EvaluatedRecording) -> str:
    """The table of refused samples, by reason; requires some."""
    times_by_reason: dict[str, list[float]] = {}
    for time, why in recording.refused:
        times_by_reason.setdefault(why, []).append(time)
    rows = []
    for why, times in times_by_reason.items():
        rows.append([why, str(len(times)), f"{times[0]:.3f} s", f"{times[-1]:.3f} s"])
    return table(["refused", "samples", "first", "last"], rows)
