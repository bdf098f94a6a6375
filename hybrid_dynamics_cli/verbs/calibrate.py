"""Geometric parameters of a robot from measurements."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import click

from hybrid_dynamics_core.calibration import (
    Calibration,
    PoseChoice,
    calibrate,
    choose_poses,
    new_text,
    validate,
)
from hybrid_dynamics_core.calibration.outlying import LOSSES, Loss
from hybrid_dynamics_core.description.expressions import evaluate
from hybrid_dynamics_core.formats.output_files import write_files

from ..bags.common import PATH, robot_option
from ..output import number, show, table, written
from ..parameters import json_option
from ..writing import output_option, output_path, overwrite_option, require_unread

MAX_LISTED: Final = 10
CHOSEN: Final = 10
MOST_EXCLUDED: Final = 0.25  # of the rows
LARGEST_CHI2: Final = 25.0  # residuals five times as large as the given noise
UNITS: Final = ("m", "rad")
HELP: Final = """\
Geometric parameters of ROBOT from measured rows, each with a 95 % interval.

DATA is a CSV file with a header. Each row has the active coordinates by name, and what was measured
there: tool.x, tool.y, tool.z and tool.qx to tool.qw of the end effector in base axes, the same of
any frame by its name, distance.A.B, inclination.FRAME.x, and further coordinates with encoders of
their own. Values are in m and rad, unless the header names another unit: `tool.x [mm]`.

Parameters are named by their path in the file. A bare name is one of `parameters:`. Offsets of
joints and origins that the file leaves out have paths too; `joints.NAME.gain` is the gain of an
encoder, `base.xyz` and `base.rpy` the pose of the base in the measuring frame.
"""
EPILOG: Final = """\b
Examples:
  hybrid-dynamics calibrate points.csv --robot my_robot.yaml \\
      --free 'L2, joints.q2.origin.xyz[0], joints.q1.offset' \\
      --sigma 0.05*mm -o calibrated.yaml
  hybrid-dynamics calibrate poses.csv --robot delta --json \\
      --free 'modules.delta.parameters.arm, joints.theta_A.offset' \\
      --sigma 0.05*mm --sigma 0.01*deg
"""


@click.command(help=HELP, epilog=EPILOG, short_help="Lengths, pins and offsets from measurements.")
@click.argument("data", type=PATH)
@robot_option
@click.option(
    "--free",
    required=True,
    metavar="PATHS",
    multiple=True,
    help="Paths of the parameters to estimate, with commas.",
)
@click.option(
    "--sigma",
    metavar="VALUE",
    multiple=True,
    help=(
        "Standard deviation of the measurements, as 0.05*mm or 0.01*deg, or of one as"
        " tool=0.05*mm; any number of times. Left out, it is estimated."
    ),
)
@click.option(
    "--loss",
    type=click.Choice(LOSSES),
    default="reject",
    show_default=True,
    help="Leave outliers out, give them less weight, or trust all.",
)
@click.option(
    "--hold-out",
    type=PATH,
    metavar="FILE",
    help="Measurements on which the estimates are checked, as DATA.",
)
@click.option(
    "--candidates",
    type=PATH,
    metavar="FILE",
    help="Poses that could be measured next: a CSV file with the active coordinates.",
)
@click.option(
    "--choose",
    type=click.IntRange(min=1),
    metavar="N",
    help="Number of candidates to choose.  [default: 10]",
)
@output_option(help="Write the robot with the estimates to this file.")
@overwrite_option
@json_option
def command(
    data: Path,
    robot: str,
    free: tuple[str, ...],
    sigma: tuple[str, ...],
    loss: Loss,
    hold_out: Path | None,
    candidates: Path | None,
    choose: int | None,
    output: str | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Estimate, print the result, and write the new file."""
    if choose is not None and candidates is None:
        raise click.BadParameter("chooses from --candidates FILE", param_hint="--choose")
    place = None if output is None else output_path(output)
    if place is not None:
        inputs = [file for file in (data, hold_out, candidates) if file is not None]
        require_unread(place, inputs)
    result = calibrate(robot, data, ",".join(free), sigma_of(sigma), loss)
    report = facts(result)
    text = text_of(result)
    if hold_out is not None:
        checks = validate(result, hold_out)
        report["hold_out"] = {name: asdict(one) for name, one in checks.items()}
        for name, one in checks.items():
            sizes = f"{one.before:.3g} before, {one.after:.3g} after"
            text += f"\n{hold_out}: residuals of {name}, rms [{one.unit}]: {sizes}"
    if candidates is not None:
        choice = further(result, robot, candidates, choose or CHOSEN)
        report["further"] = {"lines": list(choice.lines), "deviations": choice.deviations}
        text += f"\n\n{text_of_choice(choice, candidates)}"
    if place is not None:
        text += f"\n\n{written(place, 'the robot with the estimates')}"
        report["written"] = str(place)
        new_file = {place: new_text(result, place.parent)}
        write_files(new_file, result.robot.robot.description, overwrite)
    show(report, as_json, text)
    print_misfit(result, data)
    if result.unused:
        names = ", ".join(result.unused)
        click.echo(f"{data}: columns that are not used: {names}", err=True)


def print_misfit(result: Calibration, data: Path) -> None:
    """Print on stderr that the parameters do not explain the measurements."""
    rows = len(result.residuals)
    excluded = len({outlier.line for outlier in result.outliers})
    if excluded > MOST_EXCLUDED * rows or result.chi2 > LARGEST_CHI2:
        click.echo(
            f"{data}: these parameters do not explain the measurements: {excluded} of {rows} rows"
            f" are outliers, reduced chi-squared {number(result.chi2)}. Is a sensor stuck, are"
            " columns exchanged or in another unit, or is a parameter missing in --free?",
            err=True,
        )


def sigma_of(texts: tuple[str, ...]) -> dict[str, float | str] | None:
    """Deviations from the texts of --sigma; a number without a unit is of everything.

    That of a quantity stays a text, since its unit is known with the measurements.

    Raises:
        click.BadParameter: a text has no value, or is neither a length nor an angle.
    """
    if not texts:
        return None
    deviations: dict[str, float | str] = {}
    for text in texts:
        name, equals, term = text.rpartition("=")
        try:
            value = evaluate(term, {}, names_are="", units=UNITS)
        except (ValueError, ArithmeticError) as error:
            raise click.BadParameter(f"'{text}': {error}", param_hint="--sigma") from error
        given: dict[str, float | str] = dict.fromkeys(units_of(term), value)
        if equals:
            given = {name.strip(): term.strip()}
        for one, deviation in given.items():
            if one in deviations:
                raise click.BadParameter(f"'{text}': is given twice", param_hint="--sigma")
            deviations[one] = deviation
    return deviations


def units_of(term: str) -> list[str]:
    """The units, of lengths and angles, in which a term may be; both without a unit."""
    fitting: list[str] = []
    for unit in UNITS:
        try:
            evaluate(term, {}, names_are="", units=(unit,))
        except ValueError:
            continue
        fitting.append(unit)
    return fitting


def further(result: Calibration, robot: str, candidates: Path, count: int) -> PoseChoice:
    """The candidates that add most to a calibration, measured in the same way."""
    sigma = {name: misfit.sigma for name, misfit in result.misfits.items()}
    free = list(result.parameters)
    return choose_poses(robot, candidates, free, count, sigma, result)


def text_of_choice(choice: PoseChoice, candidates: Path) -> str:
    """The chosen poses as text."""
    lines = ", ".join(str(line) for line in choice.lines)
    rows: list[list[object]] = []
    for name, deviation in choice.deviations.items():
        rows.append([name, f"{choice.before[name]:.2g}", f"{deviation:.2g}"])
    head = ["deviation of", "now", "with these poses"]
    return f"measure next, most useful first: lines {lines} of {candidates}\n{table(head, rows)}"


def facts(result: Calibration) -> dict[str, Any]:
    """The result as plain data."""
    parameters: dict[str, Any] = {}
    for name, one in result.parameters.items():
        parameters[name] = {
            "value": one.value,
            "interval": list(one.interval),
            "from": one.start,
            "change": one.change,
            "deviation": one.deviation,
            "unit": one.unit,
        }
    residuals: dict[str, Any] = {}
    for name, misfit in result.misfits.items():
        residuals[name] = {
            "before": misfit.before,
            "after": misfit.after,
            "held_out": misfit.held_out,
            "sigma": misfit.sigma,
            "unit": misfit.unit,
        }
    outliers = [asdict(outlier) for outlier in result.outliers]
    unseen = [dict(combination.pairs) for combination in result.unseen]
    return {
        "parameters": parameters,
        "identifiable": dict(result.identifiable),
        "chi2": result.chi2,
        "freedom": result.freedom,
        "unseen": unseen,
        "fixed": dict(result.fixed),
        "outliers": outliers,
        "residuals": residuals,
    }


def text_of(result: Calibration) -> str:
    """The result as text."""
    rows: list[list[object]] = []
    for name, one in result.parameters.items():
        half = "not shown"
        if one.identifiable:
            half = f"+- {one.half:.2g}"
        change = f"{one.change:+.3g}"
        rows.append([name, one.start, f"{one.value:.9g}", change, half, one.unit])
    heads = ["parameter", "file", "estimate", "change", "with 95 %", "unit"]
    lines = [table(heads, rows), ""]
    lines += [f"{name} cannot change: {problem}" for name, problem in result.fixed.items()]
    lines += [f"not shown by the measurements: {one}" for one in result.unseen]
    lines.append(f"reduced chi-squared {result.chi2:.3f}, {result.freedom:.1f} degrees of freedom")
    for name, misfit in result.misfits.items():
        text = f"{misfit.before:.3g} before, {misfit.after:.3g} after"
        text += f", {misfit.held_out:.3g} held out"
        lines.append(f"residuals of {name}, rms [{misfit.unit}]: {text}")
    for outlier in result.outliers[:MAX_LISTED]:
        size = number(outlier.deviations)
        lines.append(f"outlier: {outlier.place}: {outlier.quantity}, {size} deviations off")
    more = len(result.outliers) - MAX_LISTED
    if more > 0:
        lines.append(f"and {more} more outliers")
    return "\n".join(lines)
