"""Quantities of many designs of a robot."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import click
import numpy as np

from hybrid_dynamics_core import InputError, Robot
from hybrid_dynamics_core.description.parameters.paths import path_of, units_of
from hybrid_dynamics_core.description.parameters.written import written_of
from hybrid_dynamics_core.formats.tables import table_of
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.ground.suggestions import no_such_name
from hybrid_dynamics_core.sweeps import (
    EachRobot,
    Study,
    grid,
    listed,
    random,
    read_results,
    sweep_into,
)
from hybrid_dynamics_core.sweeps.folder import FORMATS
from hybrid_dynamics_core.sweeps.spaces import Space
from hybrid_dynamics_core.sweeps.study import CHUNK

from ...bags.common import PATH
from ...output import number, show, table, written
from ...parameters import (
    frame_option,
    json_option,
    loaded,
    options,
    robot_argument,
    u_option,
    vector,
)
from ...quantities import coordinate_units, value_of

FORM: Final = "expected PARAMETER=LOW:HIGH:COUNT, or PARAMETER=LOW:HIGH with --random N"
HELP: Final = """\
Quantities of many designs of ROBOT: a grid of its parameters, random values, or rows of a table.

Parameters are names of `parameters:`, or paths such as loops.lift.pin.rod[0]. OUT is a folder with
the results. A call that was stopped goes on where it was. A design whose loops do not close is a
row with its status, and without numbers.

Quantities: position.x, coordinate.NAME, effort.NAME (at rest), pin.LOOP (size of the force),
singularity, singularity.LOOP; of several poses with .min, .max, .mean or .range.
"""
EPILOG: Final = """\b
Examples:
  hybrid-dynamics sweep forging_chu2020 --vary L2=0.6:0.9:31 \\
      --vary L3=0.7:0.9:21 --quantity position.z,effort.q12 -o grid
  hybrid-dynamics sweep excavator --vary boom=5.6:5.8 --random 1000 \\
      --quantity singularity --format csv -o random --threads 2 --json
"""


@click.command(help=HELP, epilog=EPILOG, short_help="Quantities of many designs.")
@robot_argument
@click.option(
    "--vary",
    "texts",
    multiple=True,
    metavar="NAME=LOW:HIGH:COUNT",
    help="A parameter and its range; repeatable. Without COUNT for --random.",
)
@click.option(
    "--random", "count", type=click.IntRange(1), metavar="N", help="So many random designs."
)
@click.option("--seed", type=click.IntRange(0), default=0, help="Seed of the random designs.")
@click.option(
    "--designs",
    type=PATH,
    metavar="FILE",
    help="Designs from a CSV file with a column for each parameter.",
)
@click.option(
    "--quantity", "quantities", multiple=True, metavar="NAMES", help="Quantities, with commas."
)
@click.option(
    "--function", metavar="MODULE:NAME", help="A function from Designs to arrays by name."
)
@click.option("--each", metavar="MODULE:NAME", help="A function from a Robot to numbers by name.")
@u_option
@click.option(
    "--poses",
    type=PATH,
    metavar="FILE",
    help="Poses of each design, in place of -u: a CSV file with the active coordinates.",
)
@frame_option("Frame or link of `position` in place of the end effector.")
@click.option("-o", "--output", "out", type=PATH, required=True, metavar="OUT", help="The folder.")
@click.option(
    "--format",
    "file_format",
    type=click.Choice(FORMATS),
    default=FORMATS[0],
    show_default=True,
    help="Of the results; parquet needs the extra of that name.",
)
@click.option(
    "--threads", type=click.IntRange(1), default=1, show_default=True, help="Threads here."
)
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler whose workers compute.")
@click.option(
    "--chunk",
    type=click.IntRange(1),
    default=CHUNK,
    show_default=True,
    help="Designs that are computed and written at once.",
)
@click.option("--overwrite", is_flag=True, help="Remove the results of another study.")
@json_option
def command(
    robot: str,
    texts: tuple[str, ...],
    count: int | None,
    seed: int,
    designs: Path | None,
    quantities: tuple[str, ...],
    function: str | None,
    each: str | None,
    u: str | None,
    poses: Path | None,
    frame: str | None,
    out: Path,
    file_format: str,
    threads: int,
    scheduler: str | None,
    chunk: int,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Run the study."""
    machine = loaded(robot)
    if u is not None and poses is not None:
        raise click.UsageError("-u and --poses both give poses; leave out one")
    if function is not None and each is not None:
        raise click.UsageError("--function and --each both give columns; leave out one")
    names = [name.strip() for text in quantities for name in text.split(",") if name.strip()]
    with options("vary", "quantity", "function", "frame"):
        study = Study(
            machine,
            _space(machine, texts, count, seed, designs),
            names,
            _poses(machine, u, poses),
            _function(function, each),
            frame=frame,
            chunk=chunk,
        )
        with _overwriting():
            done = sweep_into(
                study,
                out,
                threads=threads,
                scheduler=scheduler,
                file_format=file_format,
                overwrite=overwrite,
            )
    data = facts(read_results(out))
    data |= {"designs": done.designs, "computed": done.computed, "folder": str(out)}
    show(data, as_json, f"{text_of(data)}\n\n{written(out, 'the results')}")
    if not data["status"].get("closed"):
        sys.exit(1)


def _space(
    machine: Robot, texts: tuple[str, ...], count: int | None, seed: int, designs: Path | None
) -> Space:
    """The designs."""
    if designs is not None:
        if texts or count is not None:
            raise click.UsageError("--designs has all designs; leave out --vary and --random")
        return _rows(machine, designs)
    bounds: dict[str, tuple[float, ...]] = {}
    for text in texts:
        name, numbers = _bounds(machine, text)
        if name in bounds:
            raise click.BadParameter(f"'{name}' is given twice", param_hint="--vary")
        expected = 3 if count is None else 2
        if len(numbers) != expected:
            raise click.BadParameter(f"'{text}': {FORM}", param_hint="--vary")
        bounds[name] = numbers
    if not bounds:
        raise click.UsageError("give --vary NAME=LOW:HIGH:COUNT, or --designs FILE")
    if count is not None:
        return random(bounds, count, seed)
    return grid({name: (low, high, int(steps)) for name, (low, high, steps) in bounds.items()})


def _rows(machine: Robot, designs: Path) -> Space:
    """The designs of a file, with parameters of the robot as columns."""
    rows = listed(designs, lambda name: _units(machine, name, str(designs)))
    for name in rows.names:
        _units(machine, name, str(designs))
    return rows


def _bounds(machine: Robot, text: str) -> tuple[str, tuple[float, ...]]:
    """The name and the numbers of a --vary."""
    name, equals, values = text.partition("=")
    name = name.strip()
    low_and_high = values.split(":")
    if not equals or not name or len(low_and_high) not in (2, 3):
        raise click.BadParameter(f"'{text}': {FORM}", param_hint="--vary")
    units = _units(machine, name, "vary")
    numbers: list[float] = []
    for k, term in enumerate(low_and_high):
        try:
            numbers.append(float(int(term)) if k == 2 else value_of(term, units))
        except (ValueError, ArithmeticError) as error:
            problem = f"'{text}': {error}; {FORM}"
            raise click.BadParameter(problem, param_hint="--vary") from error
    return name, tuple(numbers)


def _units(machine: Robot, name: str, what: str) -> tuple[str, ...]:
    """The units that a parameter may have; raises InputError if it is not there."""
    given = written_of(machine.description)
    try:
        path = path_of(given, name)
    except InputError as error:
        raise InputError(f"{what}: {error}") from error
    return units_of(given, path)


def _poses(machine: Robot, u: str | None, poses: Path | None) -> Array:
    """The poses of each design (P, n)."""
    active = machine.active
    if poses is None:
        return vector("-u", u, active, machine.reference, coordinate_units(machine))[None]
    columns = table_of(poses).columns
    for name in columns:
        if name not in active:
            raise InputError(f"{poses}: {no_such_name('active joint', name, active)}")
    count = len(next(iter(columns.values())))
    rows = np.tile(machine.reference, (count, 1))
    for k, name in enumerate(active):
        rows[:, k] = columns.get(name, rows[:, k])
    return rows


def _function(function: str | None, each: str | None) -> Callable[..., Any] | None:
    """The function of the user."""
    if function is not None:
        return _named("--function", function)
    if each is not None:
        return EachRobot(_named("--each", each))
    return None


def _named(option: str, text: str) -> Callable[..., Any]:
    """A function by its module and name; modules of the current folder count."""
    module, _, name = text.partition(":")
    if not module or not name:
        raise click.BadParameter(f"'{text}': expected MODULE:NAME", param_hint=option)
    sys.path.insert(0, str(Path.cwd()))
    try:
        function: Callable[..., Any] = getattr(import_module(module), name)
    except (ImportError, AttributeError) as error:
        raise click.BadParameter(f"'{text}': {error}", param_hint=option) from error
    finally:
        sys.path.pop(0)
    if not callable(function):
        raise click.BadParameter(f"'{text}' is no function", param_hint=option)
    return function


@contextmanager
def _overwriting() -> Iterator[None]:
    """Name the option for an argument of the library."""
    try:
        yield
    except InputError as error:
        raise InputError(str(error).replace("give overwrite", "give --overwrite")) from error


def facts(results: Mapping[str, Any]) -> dict[str, Any]:
    """How many designs close, and the range of each quantity with the designs at its ends."""
    kinds, counts = np.unique(results["status"], return_counts=True)
    status = dict(zip(kinds.tolist(), counts.tolist(), strict=True))
    ranges: dict[str, Any] = {}
    names = list(results)
    varied = names[names.index("design") + 1 : names.index("status")]
    for name in names[names.index("status") + 1 :]:
        values = results[name]
        if np.isfinite(values).any():
            least, most = int(np.nanargmin(values)), int(np.nanargmax(values))
            ranges[name] = {
                "least": values[least],
                "least_at": least,
                "least_with": {one: results[one][least] for one in varied},
                "most": values[most],
                "most_at": most,
                "most_with": {one: results[one][most] for one in varied},
            }
    return {"status": status, "quantities": ranges}


def text_of(data: Mapping[str, Any]) -> str:
    """The facts as text."""
    counts = ", ".join(f"{count} {kind}" for kind, count in data["status"].items())
    lines = [f"{data['designs']} designs ({data['computed']} computed now): {counts}"]
    rows: list[list[object]] = []
    for name, ends in data["quantities"].items():
        for end, kind in (("least", "least"), ("most", "largest")):
            values = ", ".join(f"{one}={number(at)}" for one, at in ends[f"{end}_with"].items())
            rows.append([name, kind, number(ends[end]), ends[f"{end}_at"], values])
    if rows:
        lines += ["", table(["quantity", "", "value", "of design", "with"], rows)]
    return "\n".join(lines)
