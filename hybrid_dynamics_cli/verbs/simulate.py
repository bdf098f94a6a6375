"""Simulation of a motion."""

from __future__ import annotations

from typing import Any

import click
import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.ground.suggestions import suggestion
from hybrid_dynamics_core.ground.units import coordinate_unit
from hybrid_dynamics_core.simulation import Settings, Simulation, simulate

from ..output import number, show, table, written
from ..parameters import EFFORTS, json_option, loaded, robot_argument, vector, vector_option
from ..writing import (
    MOTIONS,
    PICTURES,
    draw_option,
    output_option,
    overwrite_option,
    place_for,
    read_by,
)

OF_WHAT = "of the energy exchanged"
WEIGHT = "weight"
POSITIVE = click.FloatRange(min=0.0, min_open=True)

EPILOG = """\b
Examples:
  hybrid-dynamics simulate excavator --seconds 0.5 --draw fall.png
  hybrid-dynamics simulate forging_chu2020 --tau weight --du q1=0.5 \\
      --save swing.csv
"""


@click.command(epilog=EPILOG)
@robot_argument
@click.option("--seconds", type=POSITIVE, default=2.0, show_default=True, help="How long [s].")
@vector_option(
    "-u",
    "--u",
    help="Active coordinates at the start [rad or m]; the robot's reference where left out.",
)
@vector_option("--du", help="Their rates at the start [per second]; zero where left out.")
@vector_option(
    "--tau",
    form=EFFORTS,
    help=(
        "Constant efforts [N m or N], or `weight`: those that hold the weight at every moment; none"
        " where left out."
    ),
)
@click.option(
    "--rate",
    type=click.FloatRange(min=0.0, min_open=True),
    default=100.0,
    show_default=True,
    help="Samples a second.",
)
@output_option("--save", "save", help="Write the motion to a .csv or .npz file.")
@draw_option("plot", help="Draw it")
@overwrite_option
@json_option
def command(
    robot: str,
    seconds: float,
    u: str | None,
    du: str | None,
    tau: str | None,
    rate: float,
    save: str | None,
    plot: str | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """The motion from a start under constant efforts, or none.

    Ends early at a stroke end or a singular place.
    """
    machine = loaded(robot)
    places = [
        place_for(path, endings, read_by(machine), overwrite=overwrite) if path else None
        for path, endings in ((save, MOTIONS), (plot, PICTURES))
    ]
    zero = np.zeros(len(machine.active))
    start = machine.close(
        vector("-u", u, machine.active, machine.reference), vector("--du", du, machine.active, zero)
    )
    result = simulate(
        machine,
        start,
        tau=efforts(machine, tau),
        t_span=(0.0, seconds),
        settings=Settings(rate=rate),
    )
    if places[0] is not None:
        result.save(places[0])
    if places[1] is not None:
        from hybrid_dynamics_core.drawing import (  # noqa: PLC0415  Matplotlib is an extra
            draw_simulation,
        )

        draw_simulation(machine, result, places[1])
    files = [
        written(path, what) for path, what in ((save, "the motion"), (plot, "its picture")) if path
    ]
    show(facts(result), as_json, "\n".join([text(machine, result), *files]))


def efforts(machine: Robot, told: str | None) -> Any:
    """What `simulate` takes: constant efforts, or those that hold the weight."""
    if told is not None and told.strip() == WEIGHT:
        return lambda _time, state: machine.minimal_form(state)[2]
    hint = suggestion(told.strip(), [WEIGHT]) if told is not None else ""
    if hint:
        raise click.BadParameter(
            f"'{told}'{hint}; expected efforts, or `{WEIGHT}`", param_hint="--tau"
        )
    return vector("--tau", told, machine.active, np.zeros(len(machine.active)))


def facts(result: Simulation) -> dict[str, Any]:
    """What came out, as plain data."""
    return {
        "completed": result.completed,
        "message": result.message,
        "seconds": float(result.t[-1]),
        "u": dict(zip(result.names, result.u[-1], strict=True)),
        "du": dict(zip(result.names, result.du[-1], strict=True)),
        "events": [{"time": event.time, "message": event.message} for event in result.events],
        "relative_energy_error": result.relative_energy_error,
        "residual": result.residual,
        "samples": len(result.t),
        "steps": result.steps,
    }


def text(machine: Robot, result: Simulation) -> str:
    """The end of the motion, and what was met."""
    rows = [
        [
            name,
            *values,
            coordinate_unit(machine.joint_types[name]),
            rate,
            coordinate_unit(machine.joint_types[name], "/s"),
        ]
        for name, *values, rate in zip(
            result.names,
            result.u[0].tolist(),
            result.u[-1].tolist(),
            result.du[-1].tolist(),
            strict=True,
        )
    ]
    return "\n".join(
        [
            table(["active joint", "start", "end", "unit", "rate at the end", "unit"], rows),
            *met(result),
            (
                f"energy error {number(result.relative_energy_error)} {OF_WHAT}, loop error"
                f" {number(result.residual)}"
            ),
        ]
    )


def met(result: Simulation) -> list[str]:
    """What was met, and how it ended; an event that ended it is told once."""
    events = list(result.events)
    if events and not result.completed and result.message.endswith(events[-1].message):
        events.pop()
    end = (
        result.message
        if not result.completed
        else f"{number(float(result.t[-1]))} s: {result.message}"
    )
    return [*(f"at {number(event.time)} s: {event.message}" for event in events), end]
