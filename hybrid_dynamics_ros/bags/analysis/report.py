"""A recording on one page: HTML that needs nothing else."""

from __future__ import annotations

import html
from collections import Counter
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

import numpy as np

from hybrid_dynamics_core.ground.units import coordinate_unit, effort_unit
from hybrid_dynamics_core.ground.wording import singular_or_plural

from .collect import Track
from .effort_error import effort_errors
from .figures import Draw, closure, efforts, energy, margins, sampling, svg, trajectories

_STYLE: Final = """
body { font: 15px/1.5 system-ui, sans-serif; color: #222; max-width: 1080px; margin: 2em auto; padding: 0 1em; }
h1 { font-size: 1.6em; margin-bottom: 0; } h2 { font-size: 1.15em; margin-top: 2.2em; border-bottom: 1px solid #ddd; }
p.quiet { color: #666; margin-top: .2em; } div.wide { overflow-x: auto; }
svg { width: 100%; min-width: 640px; height: auto; }
table { border-collapse: collapse; margin: .6em 0; } th { text-align: left; font-weight: 600; }
td, th { padding: .15em 1.2em .15em 0; border-bottom: 1px solid #eee; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; }
.warn { background: #fff4e5; border-left: 4px solid #e08a00; padding: .5em 1em; }
"""
_COMPUTED_ONLY: Final = (
    "What the model says the actuators gave. No efforts were recorded, or <code>bag process</code>"
    " was called without <code>--keep</code>, which takes them over: there is nothing to compare"
    " with."
)
_DIGITS: Final = tuple("-0123456789")
_LISTED: Final = 20  # samples in a table
_FIGURES: Final[tuple[tuple[str, str, Draw], ...]] = (
    (
        "Trajectories",
        "The active joints, as measured or as estimated from positions.",
        trajectories,
    ),
    ("Efforts", "What the model says the actuators gave, beside what was recorded.", efforts),
    ("Energy and power", "Of the whole robot; power of the actuators, positive into it.", energy),
    (
        "Loops",
        "How well they are closed, and how far from a singularity: 0 singular, 1 best.",
        closure,
    ),
    (
        "Joints and strokes",
        "What is left to the nearer end of each range; below the orange line at 0 it is beyond.",
        margins,
    ),
    (
        "Samples",
        (
            "How regular the stamps are, where samples are missing, do not fit the motion around"
            " them, or were refused."
        ),
        sampling,
    ),
)


def report(track: Track, title: str) -> str:
    """The page."""
    parts = [f"<h1>{html.escape(title)}</h1>", _head(track), _warnings(track), _facts(track)]
    for heading, text, draw in _FIGURES:
        if draw is margins and not track.margins[0]:
            continue
        text = _COMPUTED_ONLY if draw is efforts and not track.errors.count.any() else text  # noqa: PLW2901
        parts += [f"<h2>{heading}</h2>", f'<p class="quiet">{text}</p>']
        if draw is efforts and track.errors.count.any():
            parts.append(_errors(track))
        if draw is efforts:
            parts.append(f"<p>{accelerations_of(track)}</p>")
        parts.append(_wide(svg(draw, track, heading.split()[0].lower())))
    if track.outliers:
        parts.append(_strays(track))
    if track.bad:
        parts.append(_bad(track))
    body = "\n".join(parts)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="generator" content="hybrid_dynamics">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{html.escape(title)}</title>\n"
        f"<style>{_STYLE}</style>\n</head>\n<body>\n{body}\n</body>\n</html>\n"
    )


def write_report(track: Track, title: str, path: Path) -> None:
    """Write the page; it appears when it is whole."""
    aside = path.with_name(f".{path.name}.part")
    aside.write_text(report(track, title), encoding="utf-8")
    aside.replace(path)


def _head(track: Track) -> str:
    begin = datetime.fromtimestamp(track.start_ns * 1e-9, UTC).strftime("%d %B %Y, %H:%M:%S UTC")
    shown = (
        ""
        if track.every == 1
        else f"; one sample in {track.every} is shown, statistics are over all"
    )
    end = float(track.time.max())
    span = (
        f"{end:.1f} s from"
        if not track.first
        else f"{track.first:.1f} s to {end:.1f} s of the bag, which begins on"
    )
    told = f"{html.escape(track.robot.name)}, {html.escape(track.topic)}, {span} {begin}{shown}"
    return f'<p class="quiet">{told}</p>'


def _warnings(track: Track) -> str:
    if not track.losses:
        return ""
    entries = "".join(f"<li>{html.escape(loss)}</li>" for loss in track.losses)
    return f'<div class="warn">Not all of the bag could be read:<ul>{entries}</ul></div>'


def _facts(track: Track) -> str:
    state = track.state
    nearest = int(np.argmin(np.asarray(state.singularity)))
    loops = state.singular_loop
    rows = [["samples", track.counts.summary()]]
    rows += [["stamps", _stamps(track)], ["missing samples", _missing(track)]]
    if track.smooth != "causal":
        told = "".join(
            f"{'; ' if k else ', at '}{s.at(track.start_ns):.3f} s"
            for k, s in enumerate(track.outliers[:3])
        )
        rows.append(
            [
                "samples off the motion",
                f"{len(track.outliers)}{told}{' ...' if len(track.outliers) > 3 else ''}",
            ]
        )
    meaning = (
        f"stamps that go back, or are more than {track.max_gap:g} s apart: estimates start anew"
        " there"
    )
    rows.append(["gaps", f"{len(track.gaps)} ({meaning})"])
    if track.robot.loops:
        distance = float(np.asarray(state.singularity)[nearest])
        where = f"{distance:.3g} of loop {loops[nearest]} at {track.time[nearest]:.2f} s"
        rows += [
            ["largest residual", f"{float(np.max(state.residual)):.2g}"],
            ["nearest singularity", where],
        ]
    joints, left = track.margins
    if joints:
        row, column = np.unravel_index(int(np.argmin(left)), left.shape)
        unit = coordinate_unit(track.robot.joint_types[joints[column]])
        rows.append(
            [
                "least range left",
                f"{left[row, column]:.4g} {unit} of {joints[column]} at {track.time[row]:.2f} s",
            ]
        )
    power = track.power[np.isfinite(track.power)]
    if len(power):
        rows.append(["largest power", f"{_digits(float(np.abs(power).max()))} W"])
    return _table([], rows)


def _stamps(track: Track) -> str:
    longest, at = track.stamps.longest
    nominal = track.stamps.nominal
    return (
        f"{1e3 * nominal:.4g} ms apart (median); the longest interval is {1e3 * longest:.4g} ms at"
        f" {at:.3f} s"
    )


def _missing(track: Track) -> str:
    missing = track.stamps.missing
    if not missing:
        return "0 (no interval is longer than 1.5 times the median)"
    count = sum(entry[2] for entry in missing)
    first = ", ".join(f"{at:.3f} s" for at, _, _ in missing[:4])
    more = f" and {len(missing) - 4} more" if len(missing) > 4 else ""
    return f"{count}, in intervals of more than 1.5 times the median, at {first}{more}"


def _strays(track: Track) -> str:
    rows = []
    for outlier in track.outliers[:_LISTED]:
        name = track.measured[outlier.joint]
        kind = track.robot.joint_types[name]
        unit = coordinate_unit(kind, "/s" if outlier.rate else "")
        late = "" if np.isnan(outlier.late) else f"{1e3 * abs(outlier.late):.1f} ms {outlier.word}"
        rows.append(
            [f"{outlier.at(track.start_ns):.3f} s", name, f"{outlier.off:.3g} {unit}", late]
        )
    more = len(track.outliers) - len(rows)
    unlisted = f" {more} more {singular_or_plural(more, 'is', 'are')} not listed." if more else ""
    told = (
        "These samples do not fit the motion around them: accelerations are not made of them, nor"
        f" efforts computed at their stamps.{unlisted}"
    )
    return f"<p>{told}</p>" + _table(["off the motion", "joint", "off by", "stamp is"], rows)


def _errors(track: Track) -> str:
    errors = track.errors
    rows, active = [], track.robot.active
    for error in effort_errors(track):
        k, name = active.index(error.joint), error.joint
        sizes = [_digits(value) for value in (error.median, error.near)]
        sizes.append(f"{error.far} of {error.count}, beyond {_digits(error.limit)}")
        sizes += [_digits(value) for value in (errors.rms[k], errors.mean[k])]
        sizes.append(
            f"{_digits(errors.largest[k])} at"
            f" {(errors.largest_ns[k] - track.start_ns) * 1e-9:.3f} s"
        )
        share = f"{100.0 * errors.explained[k]:.2f} %" if np.isfinite(errors.explained[k]) else "-"
        unit = effort_unit(track.robot.joint_types[name])
        rows.append([name, unit, *sizes, share, str(errors.count[k])])
    return (
        _table(
            [
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
            ],
            rows,
        )
        + '<p class="quiet">Far off: beyond what noise of this median stays within. A few such'
        " samples make most of the RMS, and hardly move what 50 % and 95 % are within.</p>"
    )


def accelerations_of(track: Track) -> str:
    """Which estimate of the accelerations the computed efforts are from, and how late it is."""
    late = f"{1e3 * track.causal_lag:.1f} ms"
    if track.smooth == "causal":
        return (
            f"Accelerations are from the node's causal filter, which tells them {late} late: smooth"
            " waves of recorded less computed are this lag rather than the model. <code>--smooth"
            " spline</code>, when the recording is reported or processed, removes it."
        )
    return (
        f"Accelerations are from {track.smoother} through the samples before and after, which has"
        f" no lag; those of the node's causal filter (<code>--smooth causal</code>) are {late}"
        " late."
    )


def _bad(track: Track) -> str:
    kinds = Counter(why for _, why in track.bad)
    rows = []
    for kind, count in kinds.items():
        times = [at for at, why in track.bad if why == kind]
        rows.append([kind, str(count), f"{times[0]:.3f} s", f"{times[-1]:.3f} s"])
    return _table(["refused", "samples", "first", "last"], rows)


def _digits(value: float) -> str:
    """A number with four digits that count, and no power of ten where it is large."""
    return f"{value:.4g}" if abs(value) < 1e4 else f"{float(f'{value:.4g}'):,.0f}"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Rows, under a head where there is one: then columns of numbers stand to the right."""
    right = [bool(head) and all(row[k][:1] in _DIGITS for row in rows) for k in range(len(rows[0]))]

    def line(cells: Sequence[str], tag: str) -> str:
        parts = zip(cells, right, strict=True)
        return "".join(f"<{tag}{' class=n' * n}>{html.escape(cell)}</{tag}>" for cell, n in parts)

    lines = ([line(head, "th")] if head else []) + [line(row, "td") for row in rows]
    return _wide(f"<table>{''.join(f'<tr>{text}</tr>' for text in lines)}</table>")


def _wide(part: str) -> str:
    """What a narrow screen scrolls sideways by itself, so that the page does not."""
    return f'<div class="wide">{part}</div>'
