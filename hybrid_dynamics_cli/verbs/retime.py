"""The fastest motion along a path."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import numpy as np

from hybrid_dynamics_core import ClosedState, InputError, Loads, Robot
from hybrid_dynamics_core.formats.tables import table_of
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.ground.units import coordinate_unit
from hybrid_dynamics_core.retiming import JerkLimitedMotion, MotionPoint, TimedMotion

from ..load_options import load_options, loads_of
from ..output import by_name, number, show, show_written, table
from ..parameters import closed, json_option, loaded, robot_argument, vector_option
from ..quantities import QuantityRange
from ..writing import output_option, overwrite_option, place_for, read_by

Motion = TimedMotion | JerkLimitedMotion
FREQUENCY = QuantityRange("1/s", above=True)
EPILOG = """\b
Examples:
  hybrid-dynamics retime excavator --to boom_cylinder=0.5
  hybrid-dynamics retime excavator --to slew=1,boom_cylinder=0.5 --jerk 5
  hybrid-dynamics retime excavator --payload 900 --share 0.9 \\
      --to boom_cylinder=0.5,stick_cylinder=0.9 --json
"""


@click.command(epilog=EPILOG, short_help="The fastest motion along a path within all limits.")
@robot_argument
@vector_option("--from", "start", help="First point [rad or m]; the reference where left out.")
@vector_option("--to", "end", help="Last point [rad or m]; the reference where left out.")
@click.option(
    "--path",
    "points",
    type=click.Path(exists=True, dir_okay=False),
    help="Points in a CSV file, a column for each active coordinate; in place of --from and --to.",
)
@click.option("--jerk", type=float, help="Largest jerk on a straight way [rad/s^3 or m/s^3].")
@click.option("--share", type=float, default=1.0, show_default=True, help="Used share of limits.")
@click.option("--rate", type=FREQUENCY, default=100.0, show_default=True, help="Samples a second.")
@load_options
@output_option("--save", "save", help="Write the motion to a .csv file.")
@overwrite_option
@json_option
def command(
    robot: str,
    start: str | None,
    end: str | None,
    points: str | None,
    jerk: float | None,
    share: float,
    rate: float,
    payload: float | None,
    com: str | None,
    wrench: str | None,
    frame: str | None,
    save: str | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """The fastest motion along a path, from rest to rest.

    Efforts, rates and accelerations, pressures and flows of cylinders, flows and powers of pumps
    stay within their limits at every instant.
    """
    machine = loaded(robot)
    if save:
        place_for(save, (".csv",), read_by(machine), overwrite=overwrite)
    path = _path(machine, start, end, points)
    loads = loads_of(machine, payload, com, wrench, frame)
    motion = _motion(machine, path, jerk, loads, share)
    show(facts(machine, motion), as_json, text(machine, motion))
    if save:
        times, point = sampled(motion, rate)
        state = machine.close(point.u, point.du)
        efforts = machine.inverse_dynamics(state, point.ddu, loads)
        _write(save, machine, times, state, [point.ddu, efforts])
        show_written(save, "the motion", as_json)


def _motion(machine: Robot, path: Array, jerk: float | None, loads: Loads, share: float) -> Motion:
    """The fastest motion along a path, or with limited jerk between two points."""
    if jerk is None:
        return machine.retime(path, loads, share=share)
    if len(path) != 2:
        raise click.UsageError("--jerk takes two points; the path has more")
    return machine.point_to_point(path[0], path[1], jerk, loads, share=share)


def _path(machine: Robot, start: str | None, end: str | None, points: str | None) -> Array:
    """Points (N, n) of the path [rad or m]."""
    if points is not None:
        if start or end:
            raise click.UsageError("give either --path, or --from and --to")
        return read_points(machine, Path(points))
    if end is None:
        raise click.UsageError("give --to, the last point, or --path, a file of points")
    return np.array([closed(machine, text, None).u for text in (start, end)])


def read_points(machine: Robot, file: Path) -> Array:
    """Points (N, n) of a CSV file with a header, whose names may have units [rad, m].

    Raises:
        InputError: a column is missing or unknown, or a cell is empty or no number.
    """
    units = {"time": ["s"]}
    for name in machine.active:
        units[name] = [coordinate_unit(machine.joint_types[name])]
    points = table_of(file, lambda name: units.get(name, []))
    names = [name for name in points.columns if name != "time"]
    if sorted(names) != sorted(machine.active):
        listed = ", ".join(points.columns)
        expected = ", ".join(machine.active)
        raise InputError(f"{file}: the columns are {listed}; expected {expected}")
    return points.rows(machine.active)


def facts(machine: Robot, motion: Motion) -> dict[str, Any]:
    """The motion as plain data."""
    nearest = motion.margins.nearest
    fastest = largest_rates(motion)
    return {
        "duration": motion.duration,
        "limited_by": [{"name": name, "kind": kind} for name, kind in motion.limited_by],
        "nearest": None if nearest is None else nearest.text,
        "largest_rates": by_name(machine.active, fastest),
    }


def text(machine: Robot, motion: Motion) -> str:
    """The duration, what limits it, and the largest rates."""
    fastest = largest_rates(motion)
    ends = motion(np.array([0.0, motion.duration])).u
    rows: list[list[object]] = []
    for k, name in enumerate(machine.active):
        kind = machine.joint_types[name]
        values = [float(ends[0, k]), float(ends[1, k])]
        units = [coordinate_unit(kind), coordinate_unit(kind, "/s")]
        rows.append([name, *values, units[0], float(fastest[k]), units[1]])
    limits = [f"{kind.replace('_', ' ')} of {name}" for name, kind in motion.limited_by]
    head = ["active joint", "start", "end", "unit", "largest rate", "unit"]
    lines = [table(head, rows), f"{number(motion.duration)} s"]
    lines.append(f"limited by: {', '.join(limits) or 'the jerk'}")
    return "\n".join(lines)


def sampled(motion: Motion, rate: float) -> tuple[Array, MotionPoint]:
    """Times (N,) at `rate` samples a second, the end included, and the motion there."""
    count = max(int(np.ceil(motion.duration * rate)), 1) + 1
    times = np.linspace(0.0, motion.duration, count)
    return times, motion(times)


def largest_rates(motion: Motion) -> Array:
    """Largest rates (n,) of the active joints [rad/s or m/s]."""
    _, point = sampled(motion, 400.0 / motion.duration)
    return np.asarray(np.abs(point.du).max(axis=0))


def _write(
    path: str, machine: Robot, times: Array, state: ClosedState, others: list[Array]
) -> None:
    """Write a motion as CSV: columns as those of `simulate --save`."""
    columns = ["time", *machine.coordinates]
    columns += [f"{name}.velocity" for name in machine.coordinates]
    for what in ("acceleration", "effort"):
        columns += [f"{name}.{what}" for name in machine.active]
    rows = np.column_stack([times, state.s, state.ds, *others])
    header = ",".join(columns)
    np.savetxt(path, rows, fmt="%.17g", delimiter=",", header=header, comments="")
