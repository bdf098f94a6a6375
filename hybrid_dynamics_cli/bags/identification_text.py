"""The result of identification from a recording, as text and tables."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from hybrid_dynamics_core.dynamics.parameters import parameter_unit
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.ground.units import coordinate_unit, effort_unit
from hybrid_dynamics_core.ground.wording import counted, singular_or_plural
from hybrid_dynamics_ros.bags.analysis.identification_result import (
    ExcludedSample,
    IdentificationResult,
)

from ..output import GAP, line_width, number, table

MAX_EXCLUDED: Final = 8  # samples in a table
_DEVIATIONS: Final = (
    "Standard deviations: of the recorded efforts, and of what robot file and estimates leave of"
    " them unexplained."
)
_EFFORT_HEAD: Final = (
    "held-out efforts",
    "unit",
    "recorded",
    "left by file",
    "left by estimate",
    "explained",
)
_BASE_HEAD: Final = ("estimate", "+- 95 %", "physical", "robot file", "unit")
_HALF_DIGITS: Final = 3  # significant digits of half an interval
_ROOMY: Final = 40  # least room for terms beside the numbers [characters]
_EXCLUDED_HEAD: Final[tuple[str, ...]] = ("left out", "joint", "off in", "by", "stamp")

Numbers = Mapping[str, tuple[float, ...]]  # by name: the values of a row of a table


def report_lines(
    result: IdentificationResult,
    base: Numbers,
    efforts: Numbers,
    types: Mapping[str, str],
    *,
    everything: bool,
) -> list[str]:
    """The verdict, followed by its evidence.

    Args:
        result: result of the identification.
        base: by base parameter: estimate, confidence interval, physical value, value in the file.
        efforts: by active joint: deviations of held-out efforts, and their explained share.
        types: types of all joints.
        everything: whether to list the parameters that are not determined too, with all terms.
    """
    lines = [*_verdict(result, len(base)), "", *_wrap(_DEVIATIONS), _efforts(efforts, types)]
    lines += _excluded(result.excluded, types, everything=everything)
    determined = result.determined
    others = [name for name in base if name not in determined]
    if determined:
        lines += ["", _base_table("determined", determined, base, types, everything=everything)]
    if everything and others:
        lines += ["", _base_table("not determined", others, base, types, everything=True)]
    return lines


def unmeasured_lines(active: Sequence[str], measured: Sequence[str]) -> list[str]:
    """A note on active joints without recorded efforts, if any."""
    others = [name for name in active if name not in measured]
    if not others:
        return []
    return _wrap(
        f"No efforts of {', '.join(others)} are recorded. What follows rests on those of"
        f" {', '.join(measured)}."
    )


def pressure_lines(source: str) -> list[str]:
    """A note on recorded efforts from pressures, if any."""
    return _wrap(f"Recorded efforts of {source}.") if source else []


def _verdict(result: IdentificationResult, count: int) -> list[str]:
    """A summary of the base parameters that are determined, and of those that are not."""
    sentences: list[str] = []
    if result.worse_than_file:
        sentences.append(_worse_than_file(result))
    else:
        sentences += _determined(result, count)
    sentences.append(_on_held_out(result))
    sentences.append(
        f"{counted(result.training_count, 'sample')} to learn from, {result.test_count} held out; "
        f"condition {result.identification.condition:.3g}."
    )
    if result.excluded:
        excluded = counted(len(result.excluded), "sample")
        sentences.append(f"{excluded} left out: {_why_excluded(result.excluded)}.")
    others = count - len(result.determined)
    if others:
        number_of_them = singular_or_plural(others, "one", f"{others}")
        are = singular_or_plural(others, "is", "are")
        sentences.append(f"The {number_of_them} not determined {are} listed with --all.")
    lines: list[str] = []
    for sentence in sentences:
        lines += _wrap(sentence)
    return lines


def _wrap(sentence: str) -> list[str]:
    """A sentence, wrapped into lines."""
    return textwrap.wrap(sentence, line_width())


def _on_held_out(result: IdentificationResult) -> str:
    """A sentence on the errors of the estimates on the held-out part."""
    with np.errstate(all="ignore"):
        least = np.nanmin([*result.explained, np.inf])
        share = np.floor(1e4 * least) / 100.0  # rounded down
    return (
        f"In the part held out the estimates explain at least {share:.2f} % of the variance of each"
        f" effort. What they leave unexplained is {_percent_range(result.residual_ratio)} of what"
        " the robot file leaves: below 100 % they are better."
    )


def _percent_range(ratio: Array) -> str:
    """A range in percent, as `12 to 34 %`."""
    low = f"{100.0 * float(ratio.min()):.4g}"
    high = f"{100.0 * float(ratio.max()):.4g}"
    return f"{low} %" if low == high else f"{low} to {high} %"


def _determined(result: IdentificationResult, count: int) -> list[str]:
    """The number of base parameters that are determined, and the reason why others are not."""
    determined = len(result.determined)
    are = singular_or_plural(determined, "is", "are")
    parameters = counted(count, "base parameter")
    share = f"{determined} of {parameters} {are} determined"
    sentences = [f"{share}: not 0, at 95 % for all of them together."]
    if result.unphysical:
        sentences.append(_unphysical(len(result.unphysical)))
    nonzero, undetermined = len(result.nonzero_in_file), len(result.undetermined)
    if 2 * undetermined > nonzero:
        sentences.append(_excites_too_little(undetermined, nonzero))
    elif undetermined:
        are = singular_or_plural(undetermined, "is", "are")
        sentences.append(
            f"Of the {nonzero} that are not 0 in the robot file, {undetermined} {are} not"
            " determined."
        )
    return sentences


def _unphysical(count: int) -> str:
    """The reason why estimates with narrow intervals do not count as determined."""
    them = singular_or_plural(count, "it", "them")
    return (
        f"{count} more would be, but no bodies with positive masses can have {them}: where the"
        " motion shows little, errors of stamps and accelerations look like parameters. The values"
        " in the column 'physical' are ones that bodies can have."
    )


def _excites_too_little(undetermined: int, nonzero: int) -> str:
    """The advice if most intervals include zero."""
    are = singular_or_plural(nonzero, "is", "are")
    signs = singular_or_plural(undetermined, "sign of 1 is", f"signs of {undetermined} are")
    return (
        f"The motion excites too little for the noise: of {counted(nonzero, 'base parameter')} that"
        f" {are} not 0 in the robot file the {signs} not known. Record a motion that moves every"
        " joint, faster and farther, or for longer."
    )


def _worse_than_file(result: IdentificationResult) -> str:
    """The sentence for estimates that are worse than the values of the file."""
    ratio = dict(zip(result.joints, result.residual_ratio, strict=True))
    worst = max(result.worse_than_file, key=ratio.__getitem__)
    return (
        "The estimates are worse than the robot file: of efforts that they have not seen they"
        f" leave up to {number(ratio[worst])} times what the file leaves ({worst}). None of them is"
        " determined; their intervals hold for a model that does not fit this recording. Look at"
        " the efforts in `bag report`, cut off with --from and --to what the model does not hold"
        " for (contact, a payload, a drive that is off), or ask for --friction."
    )


def _why_excluded(samples: Sequence[ExcludedSample]) -> str:
    """The number of excluded samples of each kind."""
    outliers = sum(sample.what != "effort" for sample in samples)
    efforts = len(samples) - outliers
    parts = []
    if outliers:
        parts.append(f"{outliers} off the motion around them")
    if efforts:
        parts.append(f"{efforts} with efforts that noise does not explain")
    return ", ".join(parts)


def _efforts(efforts: Numbers, types: Mapping[str, str]) -> str:
    """The table of the held-out efforts."""
    rows = [[name, effort_unit(types[name]), *numbers] for name, numbers in efforts.items()]
    return table(_EFFORT_HEAD, rows)


def _excluded(
    samples: Sequence[ExcludedSample], types: Mapping[str, str], *, everything: bool
) -> list[str]:
    """The table of the excluded samples: the first ones, or all."""
    if not samples:
        return []
    rows = [_excluded_row(sample, types) for sample in samples]
    head = _EXCLUDED_HEAD
    if not any(row[-1] for row in rows):
        head = head[:-1]
        rows = [row[:-1] for row in rows]
    if everything or len(rows) <= MAX_EXCLUDED:
        return ["", table(head, rows)]
    unlisted = f"... and {len(rows) - MAX_EXCLUDED} more, listed with --all"
    return ["", table(head, rows[:MAX_EXCLUDED]), unlisted]


def _excluded_row(sample: ExcludedSample, types: Mapping[str, str]) -> list[str]:
    """A row: time, joint, wrong quantity, deviation (`-70 N`) and delay (`41 ms late`)."""
    joint_type = types[sample.joint]
    units = {
        "effort": effort_unit(joint_type),
        "velocity": coordinate_unit(joint_type, "/s"),
        "position": coordinate_unit(joint_type),
    }
    off = f"{number(sample.off)} {units[sample.what]}"
    stamp = ""
    if math.isfinite(sample.late):
        word = "late" if sample.late > 0.0 else "early"
        stamp = f"{1e3 * abs(sample.late):.3g} ms {word}"
    return [f"{sample.time:.3f} s", sample.joint, sample.what, off, stamp]


def _base_table(
    title: str, names: Sequence[str], base: Numbers, types: Mapping[str, str], *, everything: bool
) -> str:
    """A table of base parameters: terms and numbers, on two lines if necessary.

    Terms are wrapped with `everything`, otherwise cut.
    """
    rows = [_base_row(name, base[name], types) for name in names]
    head, rule, *numbers = table(_BASE_HEAD, rows).splitlines()
    room = line_width() - GAP - max(map(len, [head, *numbers]))
    longest = room if room >= _ROOMY else line_width()
    texts = [_term_lines(name, longest, everything=everything) for name in names]
    width = max(len(title), min(room, max(len(lines[-1]) for lines in texts)))
    gap = " " * GAP
    result = [f"{title:<{width}}{gap}{head}", f"{'-' * width}{gap}{rule}"]
    for lines, row in zip(texts, numbers, strict=True):
        *above, last = lines if len(lines[-1]) <= width else [*lines, ""]
        result += [*above, f"{last:<{width}}{gap}{row}"]
    return "\n".join(result)


def _base_row(name: str, values: Sequence[float], types: Mapping[str, str]) -> list[object]:
    """Estimate, half of its interval, physical value and value in the file, and their unit."""
    estimate, low, high, physical, file = values
    half = float(f"{0.5 * (high - low):.{_HALF_DIGITS}g}")
    return [estimate, half, physical, file, parameter_unit(_terms_of(name)[0], types)]


def _terms_of(name: str) -> list[str]:
    """The signed terms of a base parameter."""
    return re.split(r" (?=[+-] )", name)


def _term_lines(name: str, longest: int, *, everything: bool) -> list[str]:
    """The terms of a base parameter: all of them in lines, or those that fit on one line."""
    if everything:
        return _wrapped_terms(name, longest)
    terms = _terms_of(name)
    count = len(terms)
    while count > 1 and len(_cut(terms, count)) > longest:
        count -= 1
    return [_cut(terms, count)]


def _cut(terms: Sequence[str], count: int) -> str:
    """The first terms, and the number of the others."""
    text = " ".join(terms[:count])
    if count < len(terms):
        text += f" ... ({len(terms) - count} more)"
    return text


def _wrapped_terms(name: str, longest: int) -> list[str]:
    """All terms, wrapped into lines."""
    first, *others = _terms_of(name)
    lines = [first]
    for term in others:
        if len(lines[-1]) + 1 + len(term) <= longest:
            lines[-1] += f" {term}"
        else:
            lines.append(f"  {term}")
    return lines
