"""The mass of a load from measured pressures or efforts."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click
import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.dynamics.pressure_check import excess
from hybrid_dynamics_core.estimation import (
    MeasuredRun,
    PayloadEstimate,
    SensorError,
    estimate_payload,
)
from hybrid_dynamics_core.ground.file_kinds import classify_path
from hybrid_dynamics_core.ground.units import effort_unit

from ...bags.common import (
    BAGS,
    LOST,
    PATH,
    no_topic,
    robot_option,
    span_of,
    span_options,
    tell_losses,
    topic_option,
)
from ...output import number, show, table
from ...parameters import frame_option, json_option, loaded
from ..bag import missing

if TYPE_CHECKING:
    from hybrid_dynamics_ros.bags.measured_file import Measurements

SPACE_AXES: Final = "xyz"
HELP: Final = """\
The mass of the load that DATA shows, with the interval that holds it with 95 % confidence.

DATA is a bag, or a CSV file with the columns time, coordinates as boom_cylinder or boom_pitch, and
NAME.cap_pressure and NAME.rod_pressure of cylinders or NAME.effort of other drives. Values are in
SI units, unless the header names another: `boom_cylinder.cap_pressure [bar]`.

Of a whole cycle, the part with the greatest load that stays the same is weighed. What the model
does not know exactly, masses of links and friction, is estimated together with the load; with a run
of the empty tool it cancels.
"""
EPILOG: Final = """\b
Examples:
  hybrid-dynamics weigh lift.csv --robot excavator
  hybrid-dynamics weigh lift.csv --robot excavator --empty empty.csv --json
  hybrid-dynamics weigh recording --robot my_robot.yaml --from 12 --to 20

Ends with 2 where a sensor gives what it cannot have measured, as pressures in
another unit, exchanged chambers, a stuck sensor or a clock that jumps.
"""


@click.command(
    help=HELP, epilog=EPILOG, short_help="The mass of a load, from pressures or efforts."
)
@click.argument("data", type=PATH)
@robot_option
@click.option("--empty", type=PATH, metavar="EMPTY", help="Run of the empty tool, as DATA.")
@frame_option("Frame or link that carries the load, in place of the end effector.")
@topic_option
@span_options
@json_option
@click.pass_context
def command(
    context: click.Context,
    data: Path,
    robot: str,
    empty: Path | None,
    frame: str | None,
    topic: str | None,
    start: float,
    end: float,
    as_json: bool,
) -> None:
    """Weigh, and print the result."""
    span = span_of(start, end)
    machine = loaded(robot)
    measured, losses = _measurements(data, machine, robot, topic)
    run = _run(data, measured.within(*span), machine)
    empty_run = None
    if empty is not None:
        zero, more = _measurements(empty, machine, robot, topic)
        empty_run = _run(empty, zero, machine)
        losses += more
    estimate = estimate_payload(run, empty_run, frame)
    notes = _pressure_notes(measured.within(*span), machine)
    show(
        facts(estimate, run) | {"notes": notes},
        as_json,
        text_of(estimate, run, has_empty=empty is not None),
    )
    for note in notes:
        click.echo(f"{data}: note: {note}", err=True)
    if measured.unused:
        names = ", ".join(measured.unused)
        click.echo(f"{data}: columns that are not used: {names}", err=True)
    tell_losses(losses)
    if losses:
        context.exit(LOST)


def _measurements(
    path: Path, machine: Robot, robot: str, topic: str | None
) -> tuple[Measurements, list[str]]:
    """Raw columns of a bag or file, and parts that could not be read."""
    try:
        if classify_path(path).kind in BAGS:
            from hybrid_dynamics_ros.bags.analysis.weighing import (  # noqa: PLC0415 - an extra
                measurements_of_bag,
            )

            return measurements_of_bag(path, machine, robot, topic)
        from hybrid_dynamics_ros.bags.measured_file import read_measurements  # noqa: PLC0415

        no_topic(topic, path)
        return read_measurements(path, machine), []
    except ModuleNotFoundError as error:
        raise missing(error) from error


def _run(path: Path, measured: Measurements, machine: Robot) -> MeasuredRun:
    """The run of a file; an error of a sensor names the file."""
    try:
        return measured.run(machine)
    except SensorError as error:
        raise SensorError(f"{path}: {error}") from error


def _pressure_notes(measured: Measurements, machine: Robot) -> list[str]:
    """A line on each cylinder with pressures that stay above its supply or relief pressure."""
    notes: list[str] = []
    for name, sides in measured.pressures.items():
        text = excess(machine.cylinders[name], np.maximum(*sides))
        if text:
            notes.append(text)
    return notes


def facts(estimate: PayloadEstimate, run: MeasuredRun) -> dict[str, Any]:
    """The estimate as plain data."""
    return {
        "mass": estimate.mass,
        "interval": list(estimate.interval),
        "quality": estimate.quality,
        "deviation": estimate.deviation,
        "frame": estimate.frame,
        "com": estimate.com,
        "com_deviation": estimate.com_deviation,
        "used": estimate.used,
        "span": list(_since_start(estimate, run)),
        "drives": list(run.drives),
        "friction": estimate.friction,
        "noise": estimate.noise,
    }


def text_of(estimate: PayloadEstimate, run: MeasuredRun, *, has_empty: bool) -> str:
    """The estimate as text."""
    low, high = estimate.interval
    zero = "with the empty run" if has_empty else "without an empty run"
    lines = [
        f"mass     {number(estimate.mass)} kg, {number(low)} to {number(high)} kg with 95 %",
        f"quality  {estimate.quality} ({zero})",
    ]
    shown = []
    for axis, place, deviation in zip(
        SPACE_AXES, estimate.com.tolist(), estimate.com_deviation.tolist(), strict=True
    ):
        if math.isfinite(place):
            shown.append(f"{axis} = {place:.3f} +- {2.0 * deviation:.3f} m")
    if shown:
        lines.append(f"centre   {', '.join(shown)} in {estimate.frame}")
    begin, end = _since_start(estimate, run)
    lines.append(f"used     {100.0 * estimate.used:.0f} % of the samples, {begin:g} to {end:g} s")
    rows: list[list[object]] = []
    for name in run.drives:
        unit = effort_unit(run.robot.joint_types.get(name, "prismatic"))
        rows.append([name, estimate.friction[name], estimate.noise[name], unit])
    return "\n".join([*lines, "", table(["drive", "friction", "unexplained", "unit"], rows)])


def _since_start(estimate: PayloadEstimate, run: MeasuredRun) -> tuple[float, float]:
    """First and last time of the load, since the first sample [s]."""
    start = 0.0 if run.time is None else float(run.time[0])
    return estimate.span[0] - start, estimate.span[1] - start
