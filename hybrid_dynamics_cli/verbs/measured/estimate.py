"""Joint states from readings of IMUs, inclinometers, stroke sensors and encoders."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click
import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.estimation import SensorError
from hybrid_dynamics_core.filtering import (
    SensorSet,
    StateTrack,
    estimate_states,
    observability,
    read_sensors,
)
from hybrid_dynamics_core.ground.file_kinds import classify_path
from hybrid_dynamics_core.ground.units import coordinate_unit

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
from ...output import show, table, written
from ...parameters import json_option, loaded
from ...writing import overwrite_option, place_for, read_by
from ..bag import missing

if TYPE_CHECKING:
    from hybrid_dynamics_ros.bags.analysis.sensor_table import SensorData

HELP: Final = """\
The joint states that the sensors of a machine show: all coordinates and rates at each stamp, with
their deviations.

DATA is a CSV file with the column time and columns of sensors, or a bag with sensor_msgs/Imu and
joint states. FILE is a YAML file with the sensors: kinds, places, noise, topics.

Columns are NAME.gyro.x, NAME.gyro.y and NAME.gyro.z [rad/s] and NAME.accelerometer.x, ... [m/s^2]
of an IMU, and NAME of an inclinometer, encoder or stroke sensor [rad, m]. An empty cell is no
reading. A header may name another unit, as `boom.gyro.x [deg/s]`.
"""
EPILOG: Final = """\b
Examples:
  hybrid-dynamics estimate run.csv --robot excavator --sensors imus.yaml
  hybrid-dynamics estimate run.csv --robot excavator --sensors imus.yaml \\
    -o states.csv --from 2 --to 30 --json

Ends with 2 where the sensors do not determine the state, or where one gives
what it cannot have measured, as degrees for radians, or g for m/s^2.
"""


@click.command(
    help=HELP, epilog=EPILOG, short_help="Joint states from IMUs, encoders and stroke sensors."
)
@click.argument("data", type=PATH)
@robot_option
@click.option(
    "--sensors", type=PATH, required=True, metavar="FILE", help="YAML file with the sensors."
)
@click.option("-o", "--output", metavar="OUT.csv", help="CSV file for the states.")
@overwrite_option
@topic_option
@span_options
@json_option
@click.pass_context
def command(
    context: click.Context,
    data: Path,
    robot: str,
    sensors: Path,
    output: str | None,
    overwrite: bool,
    topic: str | None,
    start: float,
    end: float,
    as_json: bool,
) -> None:
    """Estimate the states, and write them."""
    span = span_of(start, end)
    machine = loaded(robot)
    inputs = (data, sensors, *read_by(machine))
    place = None
    if output is not None:
        place = place_for(output, [".csv"], inputs, overwrite=overwrite)
    carried = read_sensors(sensors, machine)
    measured = _readings(data, carried, topic).within(*span)
    try:
        track = estimate_states(machine, carried.sensors, measured.readings, carried.motion)
    except SensorError as error:
        raise SensorError(f"{data}: {error}") from error
    if place is not None:
        write_states(place, machine, track)
    facts = facts_of(machine, carried, track)
    show({**facts, "output": place and str(place)}, as_json, text_of(machine, track, facts))
    if place is not None and not as_json:
        click.echo(written(place, f"{len(track.time)} states"))
    for note in track.notes:
        click.echo(f"{data}: {note}", err=True)
    if measured.unused:
        click.echo(f"{data}: not used: {', '.join(measured.unused)}", err=True)
    tell_losses(measured.losses)
    if measured.losses:
        context.exit(LOST)


def _readings(path: Path, carried: SensorSet, topic: str | None) -> SensorData:
    """Raw readings of a bag or file."""
    try:
        if classify_path(path).kind in BAGS:
            from hybrid_dynamics_ros.bags.analysis.sensor_bag import (  # noqa: PLC0415 - an extra
                read_sensor_bag,
            )

            return read_sensor_bag(path, carried.sensors, topic)
        from hybrid_dynamics_ros.bags.analysis.sensor_table import (  # noqa: PLC0415 - an extra
            read_sensor_table,
        )
    except ModuleNotFoundError as error:
        raise missing(error) from error
    no_topic(topic, path)
    return read_sensor_table(path, carried.sensors)


def write_states(path: Path, robot: Robot, track: StateTrack) -> None:
    """Write the states of a track as a CSV file."""
    heads = ["time", *robot.coordinates]
    heads += [f"{name}.velocity" for name in robot.coordinates]
    heads += [f"{name}.acceleration" for name in robot.active]
    heads += [f"{name}.deviation" for name in robot.active]
    state = track.state
    parts = [track.time[:, None], state.s, state.ds, track.ddu, track.deviations()]
    values = np.concatenate(parts, axis=1)
    np.savetxt(path, values, delimiter=",", header=",".join(heads), comments="", fmt="%.12g")


def facts_of(robot: Robot, carried: SensorSet, track: StateTrack) -> dict[str, Any]:
    """The result as plain data."""
    shown = observability(robot, carried.sensors, carried.motion, track.state.u[0])
    deviations = track.deviations()
    readings: dict[str, dict[str, int]] = {}
    for sensor in carried.sensors:
        name = sensor.name
        used = track.counts.used[name]
        readings[name] = {"used": used, "beyond_gate": track.counts.beyond_gate[name]}
    return {
        "span": [float(track.time[0]), float(track.time[-1])],
        "states": len(track.time),
        "deviation": dict(zip(robot.active, np.median(deviations, axis=0).tolist(), strict=True)),
        "only_in_motion": [name for name in shown.in_motion if name not in shown.at_rest],
        "bias": track.bias,
        "unchecked": list(track.unchecked),
        "readings": readings,
        "notes": list(track.notes),
    }


def text_of(robot: Robot, track: StateTrack, facts: dict[str, Any]) -> str:
    """The result as text."""
    begin, end = facts["span"]
    lines = [f"states     {facts['states']}, from {begin:g} to {end:g} s"]
    if facts["only_in_motion"]:
        lines.append(f"at rest, nothing determines {', '.join(facts['only_in_motion'])}")
    if facts["unchecked"]:
        names = ", ".join(facts["unchecked"])
        lines.append(f"no other sensor checks {names}: columns that are exchanged do not show")
    rows: list[list[object]] = []
    deviations = facts["deviation"].values()
    last = track.state.u[-1].tolist()
    for name, deviation, value in zip(robot.active, deviations, last, strict=True):
        unit = coordinate_unit(robot.joint_types[name])
        rows.append([name, value, deviation, unit])
    counts: list[list[object]] = []
    for name, count in facts["readings"].items():
        counts.append([name, count["used"], count["beyond_gate"]])
    joints = table(["joint", "at the end", "deviation", "unit"], rows)
    sensors = table(["sensor", "readings used", "beyond the gate"], counts)
    return "\n".join([*lines, "", joints, "", sensors])
