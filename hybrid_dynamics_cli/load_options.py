"""Options for loads at a frame: a payload, and a force with a moment."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import click

from hybrid_dynamics_core import Loads, Payload, Robot, cylinder_force
from hybrid_dynamics_core.description.actuators import HydraulicCylinder
from hybrid_dynamics_core.dynamics.pressure_check import excess, is_faint, pressure_problem
from hybrid_dynamics_core.errors import InputError
from hybrid_dynamics_core.ground.suggestions import no_such_name

from .parameters import frame_option
from .quantities import QuantityRange, value_of

Command = TypeVar("Command", bound=Callable[..., Any])
COMPONENTS = ("N", "N", "N", "N m", "N m", "N m")
_OPTIONS = (
    click.option(
        "--payload", type=QuantityRange("kg"), metavar="MASS", help="Body at the frame [kg]."
    ),
    click.option(
        "--com", metavar="X,Y,Z", help="Its centre of mass in the frame [m].  [default: 0,0,0]"
    ),
    click.option(
        "--wrench",
        metavar="FX,FY,FZ[,MX,MY,MZ]",
        help="Force and moment on the frame, base axes [N, N m].",
    ),
    frame_option("Frame or link of --payload and --wrench, in place of the end effector."),
)
pressures_option = click.option(
    "--pressures",
    multiple=True,
    metavar="NAME=CAP:ROD",
    help="Measured pressures of a cylinder [Pa], as 120*bar:5*bar; repeatable.",
)


def load_options(command: Command) -> Command:
    """The options --payload, --com, --wrench and --frame."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def loads_of(
    machine: Robot, payload: float | None, com: str | None, wrench: str | None, frame: str | None
) -> Loads:
    """The loads of the robot, with those of the options.

    Raises:
        click.UsageError: --com or --frame is given without a load.
        InputError: there is no such frame.
    """
    loads = machine.loads
    place = machine.end_effector if frame is None else frame
    if place not in machine.frames:
        raise InputError(f"--frame: {no_such_name('frame', place, machine.frames)}")
    if payload is None and com is not None:
        raise click.UsageError("--com is of the payload: give --payload MASS too")
    if payload is None and wrench is None and frame is not None:
        raise click.UsageError("--frame is of a load: give --payload or --wrench too")
    if payload is not None:
        centre = numbers("--com", com or "0,0,0", ("m",) * 3, (3,))
        loads = loads.with_payload(Payload(payload, centre), place)
    if wrench is not None:
        values = numbers("--wrench", wrench, COMPONENTS, (3, 6))
        loads = loads.with_wrench([*values, *[0.0] * (6 - len(values))], place)
    return loads


def numbers(option: str, text: str, units: tuple[str, ...], counts: tuple[int, ...]) -> list[float]:
    """Numbers parted by commas. Raises click.BadParameter."""
    terms = text.split(",")
    expected = " or ".join(str(count) for count in counts)
    if len(terms) not in counts:
        raise click.BadParameter(
            f"'{text}': expected {expected} numbers, parted by commas", param_hint=option
        )
    values: list[float] = []
    for term, unit in zip(terms, units, strict=False):
        try:
            values.append(value_of(term, [unit]))
        except (ValueError, ArithmeticError) as error:
            raise click.BadParameter(f"'{term}': {error}", param_hint=option) from error
    return values


def massless_notes(machine: Robot) -> list[str]:
    """A line where no link has a mass: zeros are no answer then."""
    if any(link.mass for link in machine.description.links.values()):
        return []
    return ["note: no link has a mass; efforts and forces are those of given loads alone"]


def idle_cylinder_notes(
    machine: Robot, forces: Mapping[str, float], efforts: Mapping[str, float] | None = None
) -> list[str]:
    """A line on the cylinders without a force, where others have one from --pressures.

    Args:
        machine: the robot.
        forces: forces of cylinders from pressures [N].
        efforts: efforts that were given besides, by joint [N].
    """
    pushing = {name for name, effort in (efforts or {}).items() if effort}
    without = [name for name in machine.cylinders if name not in {*forces, *pushing}]
    if not forces or not without:
        return []
    return [f"note: no pressures of {', '.join(without)}, so no force either"]


def pressure_forces(machine: Robot, texts: tuple[str, ...]) -> dict[str, float]:
    """Forces of cylinders [N] from --pressures NAME=CAP:ROD."""
    forces: dict[str, float] = {}
    for name, sides in pressures_of(machine, texts).items():
        forces[name] = float(cylinder_force(machine.cylinders[name], *sides))
    return forces


def excess_notes(machine: Robot, texts: tuple[str, ...]) -> list[str]:
    """A line on each cylinder of --pressures that has more than its supply or relief pressure."""
    notes: list[str] = []
    for name, sides in pressures_of(machine, texts).items():
        text = excess(machine.cylinders[name], max(sides))
        if text:
            notes.append(f"note: {text}")
    return notes


def pressures_of(machine: Robot, texts: tuple[str, ...]) -> dict[str, list[float]]:
    """Pressures of cap and rod side [Pa] by cylinder from --pressures NAME=CAP:ROD."""
    pressures: dict[str, list[float]] = {}
    for text in texts:
        name, _, pair = text.partition("=")
        name = name.strip()
        if name not in machine.cylinders:
            raise InputError(f"--pressures: {no_such_name('cylinder', name, machine.cylinders)}")
        sides = numbers("--pressures", pair.replace(":", ","), ("Pa", "Pa"), (2,))
        if name in pressures:
            raise InputError(f"--pressures: {name} is given twice")
        _require_pascals(machine.cylinders[name], sides)
        pressures[name] = sides
    return pressures


def _require_pascals(cylinder: HydraulicCylinder, sides: list[float]) -> None:
    """Raise InputError for gauge pressures that a cylinder cannot have, as numbers in bar."""
    most = max(sides)
    problem = pressure_problem(cylinder, min(sides), most)
    if not problem and is_faint(*sides):
        problem = f"{most:g} Pa at most; if that is in bar, write {most:g}*bar"
    if problem:
        raise InputError(f"--pressures: {cylinder.joint} has {problem}")
