"""Reachable positions of the end effector."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from textwrap import wrap
from typing import Any, get_args

import click
import numpy as np

from hybrid_dynamics_core import InputError, Margins, Robot, SampleStatus, Workspace
from hybrid_dynamics_core.drawing.options import Colour
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.ground.suggestions import suggestion
from hybrid_dynamics_core.ground.units import coordinate_unit
from hybrid_dynamics_core.ground.wording import counted

from ..limits import beyond, narrowed
from ..output import by_name, constant_axes, number, show, show_written, table
from ..parameters import (
    frame_option,
    json_option,
    loaded,
    named_value,
    once_each,
    options,
    pair,
    robot_argument,
    vector,
    vector_option,
)
from ..quantities import coordinate_units
from ..writing import draw_option, overwrite_option, picture_for

NEAR = 0.1  # distance to a singularity below which a sample counts as near to it
FATES = {
    SampleStatus.OK: "reachable",
    SampleStatus.OPEN: "loops do not close",
    SampleStatus.SINGULAR: "singular",
    SampleStatus.BEYOND: "beyond a limit or stroke",
}

EPILOG = """\b
Examples:
  hybrid-dynamics workspace forging_chu2020 --draw workspace.svg
  hybrid-dynamics workspace excavator --range slew=-pi/2:pi/2 \\
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
@click.option(
    "--hold",
    "holds",
    multiple=True,
    metavar="NAME=VALUE",
    help="An active joint that stays where it is told; repeatable.",
)
@frame_option("A frame or link in place of the end effector.")
@draw_option("picture", help="Draw a map")
@overwrite_option
@click.option(
    "--over",
    "axes",
    metavar="A,B",
    help="Draw over these two active joints, not over the plane.",
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
    holds: tuple[str, ...],
    frame: str | None,
    picture: str | None,
    overwrite: bool,
    axes: str | None,
    u: str | None,
    colour: Colour,
    as_json: bool,
) -> None:
    """Where the end effector can be, and how near to singular places and limits the robot is there.

    The active joints are sampled within their limits; samples whose loops do not close are counted,
    not refused.
    """
    machine = loaded(robot)
    _check_of_map(picture, axes, u)
    place = None
    if picture is not None:
        place = picture_for(machine, picture, overwrite=overwrite)
    joints = None
    if axes is not None:
        joints = _two_joints(axes, machine)
    given = once_each("--hold", (named_value(text, "--hold", machine) for text in holds))
    base = _base(machine, u, given)
    held = _held(machine, base, joints, given)
    with options("range", **({"held": "hold"} if given else {})):
        narrower = once_each("--range", (pair(text, machine) for text in ranges))
        workspace = machine.workspace(samples, frame, narrower, held)
    data = facts(machine, workspace)
    lines = []
    if joints is not None:
        data["over"] = list(joints)
        data["held"] = held
        data["beyond_limits"] = beyond(machine, list(held), np.array(list(held.values())))
        names = " and ".join(joints)
        lines.append(f"Of the map over {names}; all other active joints are held.\n")
    lines.append(text_of(machine, workspace, data))
    if place is not None:
        data["picture"] = str(place)
    show(data, as_json, "\n".join(lines))
    if place is not None:
        _draw(machine, workspace, joints, base, place, colour)
        show_written(place, "map", as_json)
    if not workspace.samples.reachable.any():
        raise SystemExit(1)


def _check_of_map(picture: str | None, axes: str | None, u: str | None) -> None:
    """Refuse options of a map if none is drawn."""
    if picture is None and (axes is not None or u is not None):
        raise click.UsageError("--over and -u are of the map: give --draw FILE too")
    if u is not None and axes is None:
        raise click.UsageError("-u is where a map over two joints is taken: give --over A,B too")


def _base(machine: Robot, u: str | None, given: Mapping[str, float]) -> Array:
    """Active coordinates (n,) of a map [rad or m], from -u and --hold."""
    units = coordinate_units(machine)
    base = vector("-u", u, machine.active, machine.reference, units).copy()
    for k, name in enumerate(machine.active):
        base[k] = given.get(name, base[k])
    return base


def _held(
    machine: Robot,
    base: Array,
    joints: tuple[str, str] | None,
    given: Mapping[str, float],
) -> dict[str, float]:
    """Values [rad or m] of the fixed active joints: those of --hold, and in a map all but its two.

    Raises:
        InputError: --hold names a joint of the map.
    """
    if joints is None:
        return dict(given)
    for name in joints:
        if name in given:
            raise InputError(f"--hold: {name} is one of the two joints of --over; leave one out")
    places: dict[str, float] = by_name(machine.active, base.tolist())
    for name in joints:
        del places[name]
    return {**places, **given}


def _draw(
    machine: Robot,
    workspace: Workspace,
    joints: tuple[str, str] | None,
    base: Array,
    place: Path,
    colour: Colour,
) -> None:
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing import draw_margins, draw_workspace  # noqa: PLC0415

    if joints is None:
        draw_workspace(machine, workspace, place, colour=colour)
    else:
        draw_margins(machine, joints, base, place, colour=colour)


def facts(machine: Robot, workspace: Workspace) -> dict[str, Any]:
    """A workspace as plain data."""
    extremes = {}
    if workspace.extremes is not None:
        for axis, indices in zip("xyz", workspace.extremes.tolist(), strict=True):
            extremes[axis] = [_sample(machine, workspace.samples, k) for k in indices]
    smallest = None
    if workspace.nearest is not None and machine.loops:
        smallest = _sample(machine, workspace.samples, workspace.nearest)
    return {
        "frame": workspace.frame,
        "samples": workspace.count,
        "ranges": by_name(machine.active, workspace.ranges),
        "assumed_ranges": list(workspace.assumed),
        "shares": {status.name: workspace.share(status) for status in FATES},
        "extents": by_name("xyz", workspace.extents),
        "extremes": extremes,
        "near_singularity": {"below": NEAR, "share": workspace.share_below(NEAR)},
        "smallest_singularity": smallest,
    }


def _sample(machine: Robot, samples: Margins, k: int) -> dict[str, Any]:
    """One sample as plain data, with its loop and joint nearest to singularity and limit."""
    loop = None
    if samples.loop[k] >= 0:
        loop = machine.loops[int(samples.loop[k])]
    joint = None
    if samples.joint[k] >= 0:
        joint = machine.coordinates[int(samples.joint[k])]
    return {
        "position": samples.position[k],
        "u": by_name(machine.active, samples.u[k]),
        "distance": float(samples.singularity[k]),
        "loop": loop,
        "limit": float(samples.limit[k]),
        "joint": joint,
    }


def text_of(machine: Robot, workspace: Workspace, data: Mapping[str, Any]) -> str:
    """The workspace as tables."""
    shares = []
    for status, words in FATES.items():
        share = 100.0 * data["shares"][status.name]
        shares.append([words, f"{share:.1f} %"])
    lines = [
        _range_table(machine, workspace),
        *(f"note: {note}" for note in narrowed(machine)),
        "",
        *_extremes_lines(machine, workspace, data["extremes"]),
        "",
        table([f"of {counted(workspace.count, 'sample')}", "share"], shares),
    ]
    if data["smallest_singularity"] is not None:
        near_share = data["near_singularity"]["share"]
        lines += _singularity_lines(machine, data["smallest_singularity"], near_share)
    return "\n".join(lines)


def _range_table(machine: Robot, workspace: Workspace) -> str:
    rows: list[list[object]] = []
    for name, (low, high) in zip(machine.active, workspace.ranges.tolist(), strict=True):
        remark = ""
        if low == high:
            remark = "held"
        elif name in workspace.assumed:
            remark = "chosen: no limits"
        rows.append([name, low, high, coordinate_unit(machine.joint_types[name]), remark])
    return table(["active joint", "from", "to", "unit", ""], rows)


def _extremes_lines(machine: Robot, workspace: Workspace, extremes: Mapping[str, Any]) -> list[str]:
    """A table of smallest and largest coordinates, followed by the constant ones."""
    positions = [sample["position"] for samples in extremes.values() for sample in samples]
    constant = constant_axes(positions)
    rows: list[list[object]] = []
    for k, axis in enumerate("xyz"):
        if axis in constant or axis not in extremes:
            continue
        for end, sample in zip(("smallest", "largest"), extremes[axis], strict=True):
            coordinate = float(sample["position"][k])
            margins = [sample["distance"], sample["limit"], sample["joint"] or ""]
            rows.append([f"{end} {axis}", coordinate, "m", *margins])
    place = f"{workspace.frame} in {machine.base_frame}"
    lines = [table([place, "at", "unit", "singularity", "limit", "of"], rows)]
    lines += [f"{axis} = {number(value)} m everywhere" for axis, value in constant.items()]
    return lines


def _singularity_lines(machine: Robot, sample: Mapping[str, Any], near_share: float) -> list[str]:
    """An explanation of the tables, and the sample nearest to a singularity."""
    places = []
    for name, value in sample["u"].items():
        unit = coordinate_unit(machine.joint_types[name])
        places.append(f"{name} = {number(float(value))} {unit}")
    share = 100.0 * near_share
    return [
        "",
        "singularity: of the nearest loop, 0 there, 1 best",
        "limit: of the nearest joint, 0 there, 1 mid-range",
        f"singularity below {NEAR} in {share:.1f} % of what is reachable",
        f"smallest {number(sample['distance'])}, of {sample['loop']}, at",
        *wrap(", ".join(places), 78, initial_indent="  ", subsequent_indent="  "),
    ]


def _two_joints(text: str, machine: Robot) -> tuple[str, str]:
    """The two active joints of a map, from a text `A,B`.

    Raises:
        click.BadParameter: the text does not have two names.
        InputError: a name is not that of an active joint, or both names are the same.
    """
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
