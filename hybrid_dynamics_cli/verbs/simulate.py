"""Simulation of a motion."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import click
import numpy as np

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.ground.suggestions import suggestion
from hybrid_dynamics_core.ground.units import coordinate_unit
from hybrid_dynamics_core.limits import LimitMargins
from hybrid_dynamics_core.simulation import Event, Settings, Simulation, simulate

from ..limits import margin_facts, margins_at
from ..output import by_name, number, show, show_written, table
from ..parameters import (
    EFFORTS,
    closed,
    json_option,
    loaded,
    robot_argument,
    vector,
    vector_option,
)
from ..quantities import QuantityRange, effort_units
from ..writing import (
    MOTIONS,
    PICTURES,
    draw_option,
    output_option,
    overwrite_option,
    place_for,
    read_by,
)

WEIGHT = "weight"
SECONDS = QuantityRange("s", above=True)
FREQUENCY = QuantityRange("1/s", above=True)

EPILOG = """\b
Examples:
  hybrid-dynamics simulate excavator --seconds 0.5 --draw fall.png
  hybrid-dynamics simulate forging_chu2020 --tau weight --du q1=0.5 \\
      --save swing.csv
"""


@click.command(epilog=EPILOG)
@robot_argument
@click.option("--seconds", type=SECONDS, default=2.0, show_default=True, help="How long [s].")
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
@click.option("--rate", type=FREQUENCY, default=100.0, show_default=True, help="Samples a second.")
@click.option(
    "--saturate", is_flag=True, help="Drives give no more than their limits, pressures and flows."
)
@click.option(
    "--through-change-points",
    is_flag=True,
    help="Pass change points and dead centres as the mechanism does, not end there.",
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
    saturate: bool,
    through_change_points: bool,
    save: str | None,
    plot: str | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """The motion from a start under constant efforts, or none.

    Ends early at a stroke end, or at a singular place that it may not pass.
    """
    machine = loaded(robot)
    inputs = read_by(machine)
    if save:
        place_for(save, MOTIONS, inputs, overwrite=overwrite)
    if plot:
        place_for(plot, PICTURES, inputs, overwrite=overwrite)
    result = simulate(
        machine,
        closed(machine, u, du),
        tau=_efforts(machine, tau),
        t_span=(0.0, seconds),
        settings=_settings(rate, saturate, through_change_points),
    )
    margins = margins_at(machine, result.state, result.ddu, result.tau)
    data = facts(result) | {"limits": margin_facts(margins)}
    lines = [text(machine, result), *_margin_lines(result, margins)]
    show(data, as_json, "\n".join(lines))
    if save:
        result.save(save)
        show_written(save, "the motion", as_json)
    if plot:
        _draw(machine, result, plot)
        show_written(plot, "its picture", as_json)


def _settings(rate: float, saturate: bool, through_change_points: bool) -> Settings:
    """Settings of the simulation; near limits of flow the motion is stiff."""
    settings = Settings(rate=rate, through_change_points=through_change_points)
    if not saturate:
        return settings
    return replace(settings, saturate=True, method="LSODA", rtol=1e-6, atol=1e-8)


def _margin_lines(result: Simulation, margins: LimitMargins | None) -> list[str]:
    """What was beyond its limit, where it was furthest."""
    if margins is None:
        return []
    times = {one.text: number(float(result.t[one.index])) for one in margins.beyond}
    return [f"beyond at {time} s: {text}" for text, time in times.items()]


def _draw(machine: Robot, result: Simulation, path: str) -> None:
    # Matplotlib is an extra.
    from hybrid_dynamics_core.drawing import draw_simulation  # noqa: PLC0415

    draw_simulation(machine, result, path)


def _efforts(machine: Robot, text: str | None) -> Any:
    """Efforts for `simulate`: constant values (n,) [N or N m], or the gravity compensation."""
    zero = np.zeros(len(machine.active))
    if text is None:
        return zero
    word = text.strip()
    if word == WEIGHT:
        driven = np.array([name not in machine.idle for name in machine.active], dtype=float)
        return lambda _time, state: driven * machine.minimal_form(state)[2]
    hint = suggestion(word, [WEIGHT])
    if hint:
        problem = f"'{text}'{hint}; expected efforts, or `{WEIGHT}`"
        raise click.BadParameter(problem, param_hint="--tau")
    return vector("--tau", text, machine.active, zero, effort_units(machine))


def facts(result: Simulation) -> dict[str, Any]:
    """The end of the motion as plain data."""
    return {
        "completed": result.completed,
        "message": result.message,
        "seconds": float(result.t[-1]),
        "u": by_name(result.names, result.u[-1]),
        "du": by_name(result.names, result.du[-1]),
        "events": [_event_facts(result, event) for event in result.events],
        "relative_energy_error": result.relative_energy_error,
        "residual": result.residual,
        "samples": len(result.t),
        "steps": result.steps,
    }


def _event_facts(result: Simulation, event: Event) -> dict[str, Any]:
    """An event as plain data; of a passage with both motions that meet there."""
    data: dict[str, Any] = {"time": event.time, "kind": event.kind, "message": event.message}
    passage = event.passage
    if passage is None:
        return data
    names = result.coordinates
    others = [by_name(names, np.array(rates)) for rates in passage.other_rates]
    data["passage"] = {
        "kind": passage.kind,
        "loops": list(passage.loops),
        "place": by_name(names, np.array(passage.s)),
        "rates": by_name(names, np.array(passage.rates)),
        "other_rates": others,
        "before": dict(passage.before),
        "after": dict(passage.after),
    }
    return data


def text(machine: Robot, result: Simulation) -> str:
    """The last state of the motion, and its events."""
    rows: list[list[object]] = []
    for k, name in enumerate(result.names):
        kind = machine.joint_types[name]
        start = float(result.u[0, k])
        end = float(result.u[-1, k])
        rate = float(result.du[-1, k])
        rows.append([name, start, end, coordinate_unit(kind), rate, coordinate_unit(kind, "/s")])
    energy_error = f"energy error {number(result.relative_energy_error)} of the energy that moves"
    lines = [table(["active joint", "start", "end", "unit", "rate at the end", "unit"], rows)]
    lines += _event_lines(result)
    lines.append(f"{energy_error}, loop error {number(result.residual)}")
    return "\n".join(lines)


def _event_lines(result: Simulation) -> list[str]:
    """The events, and the reason for the end of the motion."""
    events = list(result.events)
    end = f"{number(float(result.t[-1]))} s: {result.message}"
    if not result.completed:
        end = result.message
        if events and end.endswith(events[-1].message):
            events.pop()
    return [*(f"at {number(event.time)} s: {event.message}" for event in events), end]
