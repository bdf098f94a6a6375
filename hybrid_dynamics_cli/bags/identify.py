"""Parameters from recorded efforts."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click
import numpy as np

from hybrid_dynamics_core.dynamics.parameters import Parameters, parameter_unit
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.ground.units import coordinate_unit, effort_unit
from hybrid_dynamics_core.ground.wording import counted, singular_or_plural
from hybrid_dynamics_core.identification import TooLittleShownError
from hybrid_dynamics_ros.bags.analysis.collect import Track, collect
from hybrid_dynamics_ros.bags.analysis.identify import (
    Found,
    LeftOut,
    asked_parameters,
    identify_track,
)
from hybrid_dynamics_ros.bags.process import SMOOTHINGS
from hybrid_dynamics_ros.bags.settings import read_settings

from ..output import WIDTH, number, show, table, written
from ..parameters import json_option
from ..writing import output_option, overwrite_option, place_for
from .common import (
    LOST,
    PATH,
    known_robot_option,
    params_option,
    span_of,
    span_options,
    tell_losses,
    topic_option,
)

LISTED = 8  # samples that were left out
ROOM = (
    WIDTH - 12 - 2
)  # for the terms of a base parameter, where they stand beside the estimate alone
Numbers = Mapping[str, tuple[float, ...]]  # a row of a table by name
COLUMNS = ("estimate", "low", "high", "physical", "file")
DEVIATIONS = (
    "Standard deviations: of the recorded efforts, and of what robot file and estimates leave of"
    " them unexplained."
)
HELD = ("recorded", "left_by_file", "left_by_estimate", "explained")
EPILOG = """\b
Examples:
  hybrid-dynamics bag identify recording --robot excavator
  hybrid-dynamics bag identify recording --robot excavator \\
      --friction boom_cylinder,stick_cylinder --hold-out 0.3 --json
  hybrid-dynamics bag identify recording --robot excavator --from 0.5 --to 4.5
"""


@click.command(epilog=EPILOG, short_help="Parameters of the robot from recorded efforts.")
@click.argument("bag", type=PATH)
@known_robot_option
@topic_option
@params_option
@span_options
@click.option(
    "--smooth",
    type=click.Choice(SMOOTHINGS),
    default="spline",
    show_default=True,
    help="How accelerations are found.",
)
@click.option(
    "--friction",
    metavar="JOINTS",
    default="",
    help="Joints whose friction is asked for, or all.  [default: none]",
)
@click.option(
    "--links", metavar="LINKS", default="", help="Links whose inertia is asked for.  [default: all]"
)
@click.option(
    "--hold-out",
    type=click.FloatRange(0.05, 0.9),
    default=0.25,
    show_default=True,
    help="Share of the bag to test on.",
)
@click.option(
    "--samples",
    type=click.IntRange(100),
    default=5000,
    show_default=True,
    help="Most samples that are used.",
)
@output_option(help="Write the base parameters to this CSV file too.")
@overwrite_option
@click.option(
    "--all", "everything", is_flag=True, help="Tell what is not determined too, and all terms."
)
@json_option
@click.pass_context
def command(  # noqa: PLR0913, PLR0917 - an argument for each option
    context: click.Context,
    bag: Path,
    robot: str | None,
    topic: str | None,
    params: Path | None,
    start: float,
    end: float,
    smooth: str,
    friction: str,
    links: str,
    hold_out: float,
    samples: int,
    output: str | None,
    overwrite: bool,
    everything: bool,
    as_json: bool,
) -> None:
    """Base parameters and friction from the recorded efforts of BAG: what is determined, and how well.

    The last part of the bag is held out: what the estimates leave unexplained there is told beside
    what the robot file leaves; where that is more, nothing is offered as determined. Samples that
    do not fit the motion around them, or whose efforts noise does not explain, are left out and
    named. Exits with 3 where a part of BAG could not be read.
    """
    place = None if output is None else place_for(output, (".csv",), [bag], overwrite=overwrite)
    track = collect(
        bag, robot, topic, smooth, read_settings(params), samples, span=span_of(start, end)
    )
    asked = asked_parameters(
        track.robot, listed(links), track.robot.active if friction == "all" else listed(friction)
    )
    found = identified(track, asked, hold_out)
    base, efforts = base_of(found), efforts_of(found, track)
    lines = text(found, base, efforts, track.robot.joint_types, whole=everything)
    if place is not None:
        write_base(place, base)
        lines += ["", written(place, "the base parameters")]
    show(facts(found, base, efforts, track), as_json, "\n".join(lines))
    tell_losses(track.losses)
    if track.losses:
        context.exit(LOST)


def base_of(found: Found) -> Numbers:
    """By base parameter: estimate, interval, what bodies can have nearest to it, and what the robot file says."""
    others = zip(found.physical.tolist(), found.described.tolist(), strict=True)
    return {
        name: (*part, *other)
        for (name, part), other in zip(found.result.table().items(), others, strict=True)
    }


def efforts_of(found: Found, track: Track) -> Numbers:
    """By active joint: held-out efforts, and what is left of them by file and estimate."""
    columns = (found.spread, found.before, found.noise, found.explained)
    return {
        name: tuple(float(column[k]) for column in columns)
        for k, name in enumerate(track.robot.active)
    }


def facts(found: Found, base: Numbers, efforts: Numbers, track: Track) -> dict[str, Any]:
    """All that was found, for programs."""
    return {
        "worse_than_file": list(found.worse),
        "left_out": [asdict(entry) for entry in found.left_out],
        "determined": list(found.determined),
        "bodiless": list(found.bodiless),
        "unsettled": list(found.unsettled),
        "base": {name: dict(zip(COLUMNS, part, strict=True)) for name, part in base.items()},
        "parameters": dict(zip(found.result.parameters.names, found.result.values, strict=True)),
        "condition": found.result.condition,
        "losses": track.losses,
        "held_out": {
            name: dict(zip(HELD, numbers, strict=True)) for name, numbers in efforts.items()
        },
    }


def text(
    found: Found, base: Numbers, efforts: Numbers, types: Mapping[str, str], *, whole: bool
) -> list[str]:
    """The verdict first, then what it rests on; `types`: of all joints."""
    head = ["held-out efforts", "unit", "recorded", "left by file", "left by estimate", "explained"]
    rows = [[name, effort_unit(types[name]), *numbers] for name, numbers in efforts.items()]
    lines = [*verdict(found, base), "", *filled(DEVIATIONS), table(head, rows)]
    lines += left_out(found, types, whole=whole)
    others = [name for name in base if name not in found.determined]
    if found.determined:
        lines += estimates("determined", found.determined, base, types, whole=whole)
    if whole and others:
        lines += estimates("not determined", others, base, types, whole=True)
    return lines


def listed(text: str) -> tuple[str, ...]:
    """Names between commas."""
    return tuple(name.strip() for name in text.split(",") if name.strip())


def identified(track: Track, asked: Parameters, hold_out: float) -> Found:
    """What is found; where the motion shows too little for all that is asked, the options that ask for less."""
    try:
        return identify_track(track, asked, hold_out)
    except TooLittleShownError as error:
        least = asked.links[-1]
        raise click.ClickException(
            f"{error}: with --links, as --links {least}, inertias of these links alone are asked"
            " for, and those of the others are taken from the robot file"
        ) from error


def write_base(place: Path, base: Numbers) -> None:
    """All base parameters as CSV."""
    rows = (",".join([f'"{name}"', *map(repr, part)]) for name, part in base.items())
    place.write_text("\n".join([",".join(("name", *COLUMNS)), *rows]) + "\n", encoding="utf-8")


def verdict(found: Found, base: Numbers) -> list[str]:
    """What could be found, and what could not."""
    others = len(base) - len(found.determined)
    lines = [worse_than_file(found)] if found.worse else determined(found, len(base))
    with np.errstate(all="ignore"):
        share = (
            np.floor(1e4 * np.nanmin([*found.explained, np.inf])) / 100.0
        )  # never more than it is
    lines.append(
        f"In the part held out the estimates explain at least {share:.2f} % of the variance of each"
        f" effort. What they leave unexplained is {compared(ratios(found))} of what the robot file"
        " leaves: below 100 % they are better."
    )
    lines.append(
        f"{counted(found.trained, 'sample')} to learn from, {found.held} held out; "
        f"condition {found.result.condition:.3g}."
    )
    if found.left_out:
        lines.append(f"{counted(len(found.left_out), 'sample')} left out: {why_left_out(found)}.")
    if others:
        lines.append(
            f"The {singular_or_plural(others, 'one', f'{others}')} not determined {singular_or_plural(others, 'is', 'are')}"
            " listed with --all."
        )
    return [part for line in lines for part in filled(line)]


def filled(line: str) -> list[str]:
    """A sentence on as many lines as it takes."""
    return textwrap.wrap(line, WIDTH)


def compared(ratio: Array) -> str:
    """`12 to 34 %`."""
    low, high = (f"{100.0 * float(value):.4g}" for value in (ratio.min(), ratio.max()))
    return f"{low} %" if low == high else f"{low} to {high} %"


def ratios(found: Found) -> Array:
    """What the estimates leave of the held-out efforts in times of what the robot file leaves, (n,)."""
    return np.asarray(found.noise / np.maximum(found.before, 1e-300))


def determined(found: Found, count: int) -> list[str]:
    """How many are determined, and what the motion is to be blamed for."""
    known = len(found.determined)
    told = f"{known} of {counted(count, 'base parameter')} {singular_or_plural(known, 'is', 'are')} determined"
    lines = [f"{told}: not 0, at 95 % for all of them together."]
    if found.bodiless:
        lines.append(bodiless(len(found.bodiless)))
    if 2 * len(found.unsettled) > len(found.meant):
        lines.append(excites_too_little(len(found.unsettled), len(found.meant)))
    elif found.unsettled:
        lines.append(
            f"Of the {len(found.meant)} that are not 0 in the robot file, {len(found.unsettled)} "
            f"{singular_or_plural(len(found.unsettled), 'is', 'are')} not determined."
        )
    return lines


def bodiless(count: int) -> str:
    """Why estimates that are sure of themselves are not determined."""
    return (
        f"{count} more would be, but no bodies with positive masses can have"
        f" {singular_or_plural(count, 'it', 'them')}: where the motion shows little, errors of stamps and"
        " accelerations look like parameters. The values in the column 'physical' are ones that"
        " bodies can have."
    )


def worse_than_file(found: Found) -> str:
    """That the estimates are no good."""
    ratio = dict(zip(found.joints, ratios(found), strict=True))
    worst = max(found.worse, key=ratio.__getitem__)
    return (
        "The estimates are worse than the robot file: of efforts that they have not seen they"
        f" leave up to {number(ratio[worst])} times what the file leaves ({worst}). None of them is"
        " determined; their intervals hold for a model that does not fit this recording. Look at"
        " the efforts in `bag report`, cut off with --from and --to what the model does not hold"
        " for (contact, a payload, a drive that is off), or ask for --friction."
    )


def why_left_out(found: Found) -> str:
    """How many samples of which kind."""
    stray = sum(entry.what != "effort" for entry in found.left_out)
    told = [
        (stray, "off the motion around them"),
        (len(found.left_out) - stray, "with efforts that noise does not explain"),
    ]
    return ", ".join(f"{count} {what}" for count, what in told if count)


def left_out(found: Found, types: Mapping[str, str], *, whole: bool) -> list[str]:
    """A table of the samples that were left out: the first, or all."""
    if not found.left_out:
        return []
    rows = [
        [f"{e.time:.3f} s", e.joint, e.what, off_word(e, types), stamp_word(e.late)]
        for e in found.left_out
    ]
    head = ["left out", "joint", "off in", "by", "stamp"]
    if not any(row[-1] for row in rows):
        head, rows = head[:-1], [row[:-1] for row in rows]
    most = len(rows) if whole else LISTED
    more = [f"... and {len(rows) - most} more, listed with --all"] if len(rows) > most else []
    return ["", table(head, rows[:most]), *more]


def off_word(entry: LeftOut, types: Mapping[str, str]) -> str:
    """By how much a sample is off, `-70 N`."""
    joint = types[entry.joint]
    units = {
        "effort": effort_unit(joint),
        "velocity": coordinate_unit(joint, "/s"),
        "position": coordinate_unit(joint),
    }
    return f"{number(entry.off)} {units[entry.what]}"


def stamp_word(late: float) -> str:
    """`41 ms late`."""
    return (
        ""
        if not math.isfinite(late)
        else f"{1e3 * abs(late):.3g} ms {'late' if late > 0.0 else 'early'}"
    )


def estimates(
    head: str, names: Sequence[str], base: Numbers, types: Mapping[str, str], *, whole: bool
) -> list[str]:
    """A table of base parameters; their terms are wrapped where all are wanted, else cut."""
    rows: list[list[object]] = []
    for name in names:
        first, *more = wrapped(name) if whole else [shortened(name)]
        estimate, *others = base[name]
        rows.append([estimate, parameter_unit(terms_of(name)[0], types), *others, first])
        rows += [["", "", "", "", "", "", line] for line in more]
    return [
        "",
        table(
            [
                "estimate",
                "unit",
                "95 % from",
                "to",
                "physical",
                "robot file",
                f"base parameter, {head}",
            ],
            rows,
        ),
    ]


def terms_of(name: str) -> list[str]:
    """A combination's terms, each with its sign."""
    return re.split(r" (?=[+-] )", name)


def shortened(name: str) -> str:
    """As many terms as a line has room for, and how many more there are."""
    terms = terms_of(name)
    for count in range(len(terms), 1, -1):
        left = len(terms) - count
        text = " ".join(terms[:count]) + (f" ... ({left} more)" if left else "")
        if len(text) <= ROOM:
            return text
    return terms[0] if len(terms) == 1 else f"{terms[0]} ... ({len(terms) - 1} more)"


def wrapped(name: str) -> list[str]:
    """All terms, on as many lines as it takes."""
    lines: list[str] = []
    for term in terms_of(name):
        if lines and len(lines[-1]) + 1 + len(term) <= ROOM:
            lines[-1] += f" {term}"
        else:
            lines.append(f"  {term}" if lines else term)
    return lines


def excites_too_little(unsettled: int, meant: int) -> str:
    """What to do where most intervals do not even tell the sign."""
    are, signs = (
        singular_or_plural(meant, "is", "are"),
        singular_or_plural(unsettled, "sign of 1 is", f"signs of {unsettled} are"),
    )
    return (
        f"The motion excites too little for the noise: of {counted(meant, 'base parameter')} that"
        f" {are} not 0 in the robot file the {signs} not known. Record a motion that moves every"
        " joint, faster and farther, or for longer."
    )
