"""Where the end effector can be."""

from __future__ import annotations

from textwrap import wrap
from typing import Any, get_args

import click
import numpy as np

from hybrid_dynamics_core import InputError, Margins, Robot, SampleStatus, Workspace
from hybrid_dynamics_core.drawing.options import Colour
from hybrid_dynamics_core.ground.suggestions import suggestion
from hybrid_dynamics_core.ground.units import coordinate_unit
from hybrid_dynamics_core.ground.wording import counted

from ..limits import beyond, narrowed
from ..output import constant_axes, number, show, table, written
from ..parameters import (
    frame_option,
    json_option,
    loaded,
    options,
    pair,
    robot_argument,
    vector,
    vector_option,
)
from ..writing import draw_option, overwrite_option, picture_for

NEAR = 0.1  # distance to a singularity below which a sample is told as near one
FATES = {
    SampleStatus.OK: "reachable",
    SampleStatus.OPEN: "loops do not close",
    SampleStatus.SINGULAR: "singular",
    SampleStatus.BEYOND: "beyond a limit or stroke",
}

EPILOG = """\b
Examples:
  hybrid-dynamics workspace forging_chu2020 --draw workspace.svg
  hybrid-dynamics workspace excavator --range q1=-pi/2:pi/2 \\
      --frame bucket --json
  hybrid-dynamics workspace forging_chu2020 --over q12,q22 --draw margins.png

Ends with 1 where no sample is reachable.
"""


@click.command(epilog=EPILOG, short_help="Where the end effector can be, singular places.")
@robot_argument
@click.option(
    "--samples",
    type=click.IntRange(1),
    default=100_000,
    show_default=True,
    help="How many samples are taken.",
)
@click.option(
    "--range",
    "ranges",
    multiple=True,
    metavar="NAME=LOW:HIGH",
    help="Narrower range of an active joint; repeatable.",
)
@frame_option("A frame or link in place of the end effector.")
@draw_option("picture", help="Draw a map")
@overwrite_option
@click.option(
    "--over", metavar="A,B", help="Draw over these two active joints, not over the plane."
)
@vector_option(
    "-u",
    "--u",
    help="With --over: where the other active joints stay; the reference where left out.",
)
@click.option(
    "--colour",
    type=click.Choice(get_args(Colour)),
    default="singularity",
    show_default=True,
    help="What the map is coloured by.",
)
@json_option
def command(
    robot: str,
    samples: int,
    ranges: tuple[str, ...],
    frame: str | None,
    picture: str | None,
    overwrite: bool,
    over: str | None,
    u: str | None,
    colour: Colour,
    as_json: bool,
) -> None:
    """Where the end effector can be, and how near to singular places and limits the robot is there.

    The active joints are sampled within their limits; samples whose loops do not close are counted,
    not refused.
    """
    machine = loaded(robot)
    if picture is None and (over is not None or u is not None):
        raise click.UsageError("--over and -u are of the map: give --draw FILE too")
    if u is not None and over is None:
        raise click.UsageError("-u is where a map over two joints is taken: give --over A,B too")
    place = None if picture is None else picture_for(machine, picture, overwrite=overwrite)
    pair_over = None if over is None else _two(over, machine)
    base = vector("-u", u, machine.active, machine.reference)
    held = {
        n: v
        for n, v in zip(machine.active, base.tolist(), strict=True)
        if pair_over and n not in pair_over
    }
    with options("range"):
        found = machine.workspace(samples, frame, dict(pair(text) for text in ranges), held)
    told = facts(machine, found)
    lines = [text_of(machine, found, told)]
    if pair_over is not None:
        told |= {
            "over": list(pair_over),
            "held": held,
            "beyond_limits": beyond(machine, list(held), np.array([*held.values()])),
        }
        lines.insert(
            0, f"Of the map over {' and '.join(pair_over)}; all other active joints are held.\n"
        )
    if place is not None:
        from hybrid_dynamics_core.drawing import (  # noqa: PLC0415  Matplotlib is an extra
            draw_margins,
            draw_workspace,
        )

        if pair_over is None:
            draw_workspace(machine, found, place, colour=colour)
        else:
            draw_margins(machine, pair_over, base, place, colour=colour)
        told["picture"] = str(place)
        lines.append(written(place, "map"))
    show(told, as_json, "\n".join(lines))
    if not found.samples.reachable.any():
        raise SystemExit(1)


def facts(machine: Robot, found: Workspace) -> dict[str, Any]:
    """What was found, as plain data."""
    told: dict[str, Any] = {
        "frame": found.frame,
        "samples": found.count,
        "ranges": dict(zip(machine.active, found.ranges, strict=True)),
        "assumed_ranges": list(found.assumed),
        "shares": {status.name: found.share(status) for status in FATES},
        "extents": dict(zip("xyz", found.extents, strict=True)),
        "extremes": {
            axis: [_sample(machine, found.samples, int(k)) for k in pair]
            for axis, pair in zip(
                "xyz", () if found.extremes is None else found.extremes, strict=False
            )
        },
        "near_singularity": {"below": NEAR, "share": found.share_below(NEAR)},
        "smallest_singularity": None,
    }
    if found.nearest is not None and machine.loops:
        told["smallest_singularity"] = _sample(machine, found.samples, found.nearest)
    return told


def _sample(machine: Robot, samples: Margins, k: int) -> dict[str, Any]:
    """What is known of one sample."""
    joint, loop = int(samples.joint[k]), int(samples.loop[k])
    return {
        "position": samples.position[k],
        "u": dict(zip(machine.active, samples.u[k], strict=True)),
        "distance": float(samples.singularity[k]),
        "loop": machine.loops[loop] if loop >= 0 else None,
        "limit": float(samples.limit[k]),
        "joint": machine.coordinates[joint] if joint >= 0 else None,
    }


def text_of(machine: Robot, found: Workspace, told: dict[str, Any]) -> str:
    """The facts as tables."""
    rows = [
        [
            name,
            float(low),
            float(high),
            coordinate_unit(machine.joint_types[name]),
            _remark(found, name, low == high),
        ]
        for name, (low, high) in zip(machine.active, found.ranges, strict=True)
    ]
    places = [one["position"] for ends in told["extremes"].values() for one in ends]
    flat = constant_axes(places)
    spans = [
        [
            f"{'largest' if k else 'smallest'} {axis}",
            float(one["position"]["xyz".index(axis)]),
            "m",
            *_margins(one),
        ]
        for axis, ends in told["extremes"].items()
        if axis not in flat
        for k, one in enumerate(ends)
    ]
    fates = [
        [words, f"{100.0 * told['shares'][status.name]:.1f} %"] for status, words in FATES.items()
    ]
    lines = [
        table(["active joint", "from", "to", "unit", ""], rows),
        *(f"note: {note}" for note in narrowed(machine)),
        "",
        table(
            [f"{found.frame} in {machine.base_frame}", "at", "unit", "singularity", "limit", "of"],
            spans,
        ),
        *(f"{axis} = {number(value)} m everywhere" for axis, value in flat.items()),
        "",
        table([f"of {counted(found.count, 'sample')}", "share"], fates),
    ]
    nearest = told["smallest_singularity"]
    if nearest is not None:
        at = ", ".join(
            f"{name} = {number(float(value))} {coordinate_unit(machine.joint_types[name])}"
            for name, value in nearest["u"].items()
        )
        share = 100.0 * told["near_singularity"]["share"]
        lines += [
            "",
            "singularity: of the nearest loop, 0 there, 1 best",
            "limit: of the nearest joint, 0 there, 1 mid-range",
            f"singularity below {NEAR} in {share:.1f} % of what is reachable",
            f"smallest {number(nearest['distance'])}, of {nearest['loop']}, at",
            *wrap(at, 78, initial_indent="  ", subsequent_indent="  "),
        ]
    return "\n".join(lines)


def _remark(found: Workspace, name: str, held: bool) -> str:
    return "held" if held else "chosen: no limits" if name in found.assumed else ""


def _margins(one: dict[str, Any]) -> list[object]:
    """Distances of a sample to a singularity and to a limit, and whose."""
    return [one["distance"], one["limit"], one["joint"] or ""]


def _two(text: str, machine: Robot) -> tuple[str, str]:
    names = [name.strip() for name in text.split(",")]
    if len(names) != 2:
        raise click.BadParameter(
            f"'{text}': expected two active joints, as q12,q22", param_hint="--over"
        )
    for name in names:
        if name not in machine.active:
            hint = suggestion(name, machine.active)
            problem = f"'{name}' is not an active joint{hint}; they are {', '.join(machine.active)}"
            raise InputError(f"--over: {problem}")
    if names[0] == names[1]:
        raise InputError(f"--over: expected two different active joints, got {names[0]} twice")
    return names[0], names[1]
