"""A report on a recording, as self-contained HTML."""

from __future__ import annotations

import html
from datetime import UTC, datetime
from pathlib import Path
from typing import Final, NamedTuple

from hybrid_dynamics_core.ground.atomic_files import atomic_file

from .figures import closure, efforts, energy, margins, sampling, trajectories
from .html_page import page, quiet, warning, wide
from .plotting import Draw, svg_of
from .pressure_figure import pressures
from .recording import EvaluatedRecording
from .report_tables import errors_table, facts_table, outliers_table, refused_table

_EFFORTS: Final = "What the model says the actuators gave, beside what was recorded."
_COMPUTED_ONLY: Final = (
    "What the model says the actuators gave. No efforts were recorded, or <code>bag process</code>"
    " was called without <code>--keep</code>, which takes them over: there is nothing to compare"
    " with."
)


class _Section(NamedTuple):
    """A figure of the page with its heading and a sentence."""

    heading: str
    text: str
    draw: Draw


_TRAJECTORIES: Final = _Section(
    "Trajectories", "The active joints, as measured or as estimated from positions.", trajectories
)
_PRESSURES: Final = _Section(
    "Pressures",
    (
        "Recorded pressures of the cylinders. Beside that on the cap side is the one that the"
        " computed force needs, with the recorded pressure on the rod side."
    ),
    pressures,
)
_ENERGY: Final = _Section(
    "Energy and power", "Of the whole robot; power of the actuators, positive into it.", energy
)
_LOOPS: Final = _Section(
    "Loops",
    "How well they are closed, and how far from a singularity: 0 singular, 1 best.",
    closure,
)
_MARGINS: Final = _Section(
    "Joints and strokes",
    "What is left to the nearer end of each range; below the orange line at 0 it is beyond.",
    margins,
)
_SAMPLES: Final = _Section(
    "Samples",
    (
        "How regular the stamps are, where samples are missing, do not fit the motion around"
        " them, or were refused."
    ),
    sampling,
)


def report(recording: EvaluatedRecording, title: str) -> str:
    """The HTML of the report.

    Args:
        recording: the recording.
        title: plain text.
    """
    parts = [f"<h1>{html.escape(title)}</h1>", quiet(_subtitle(recording))]
    if recording.losses:
        parts.append(warning("Not all of the bag could be read:", recording.losses))
    else:
        parts.append("")
    if recording.beyond:
        parts.append(warning("Beyond limits, furthest where it says:", recording.beyond))
    parts.append(facts_table(recording))
    for section in _sections(recording):
        parts += _section_parts(recording, section)
    if recording.outliers:
        parts.append(outliers_table(recording))
    if recording.refused:
        parts.append(refused_table(recording))
    return page(title, parts)


def write_report(recording: EvaluatedRecording, title: str, path: Path) -> None:
    """Write the report; the file appears only when it is complete."""
    with atomic_file(path) as new:
        new.write_text(report(recording, title), encoding="utf-8")


def _sections(recording: EvaluatedRecording) -> list[_Section]:
    """The sections for a recording."""
    joints, _ = recording.margins
    text = _EFFORTS if _has_errors(recording) else _COMPUTED_ONLY
    sections = [_TRAJECTORIES, _Section("Efforts", text, efforts)]
    if recording.pressures:
        sections.append(_PRESSURES)
    sections += [_ENERGY, _LOOPS]
    if joints:
        sections.append(_MARGINS)
    return [*sections, _SAMPLES]


def _section_parts(recording: EvaluatedRecording, section: _Section) -> list[str]:
    parts = [f"<h2>{section.heading}</h2>", quiet(section.text)]
    if section.draw is efforts:
        if _has_errors(recording):
            parts.append(errors_table(recording))
        parts.append(f"<p>{accelerations_of(recording)}</p>")
    name = section.heading.split()[0].lower()
    parts.append(wide(svg_of(section.draw, recording, name)))
    return parts


def _has_errors(recording: EvaluatedRecording) -> bool:
    """Whether there are recorded efforts to compare with."""
    return bool(recording.errors.count.any())


def _subtitle(recording: EvaluatedRecording) -> str:
    """Robot, topic, time and number of the samples."""
    start = datetime.fromtimestamp(recording.start_ns * 1e-9, UTC)
    date = start.strftime("%d %B %Y, %H:%M:%S UTC")
    end = float(recording.time.max())
    first = recording.stamps.first
    span = f"{end:.1f} s from"
    if first:
        span = f"{first:.1f} s to {end:.1f} s of the bag, which begins on"
    text = f"{html.escape(recording.robot.name)}, {html.escape(recording.topic)}, {span} {date}"
    if recording.every > 1:
        text += f"; one sample in {recording.every} is shown, statistics are over all"
    return text


def accelerations_of(recording: EvaluatedRecording) -> str:
    """Text on the estimator of accelerations, and its lag."""
    late = f"{1e3 * recording.causal_lag:.1f} ms"
    if recording.is_causal and not recording.causal_lag:
        return (
            "Accelerations are from the node's Kalman filter, which has no lag, but makes those of"
            " fast motions too large. <code>--smooth spline</code>, when the recording is reported"
            " or processed, does not."
        )
    if recording.is_causal:
        return (
            f"Accelerations are from the node's causal filter, which gives them {late} late: smooth"
            " waves of recorded less computed are this lag rather than the model. <code>--smooth"
            " spline</code>, when the recording is reported or processed, removes it."
        )
    return (
        f"Accelerations are from {recording.smoother} through the samples before and after, which"
        f" has no lag; those of the node's causal filter (<code>--smooth causal</code>) are {late}"
        " late."
    )
