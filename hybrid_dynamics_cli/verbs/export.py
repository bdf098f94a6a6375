"""Export of robots to other formats."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import click

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.export import (
    to_c,
    to_gepetto,
    to_mjcf,
    to_sdf,
    to_urdf,
    to_urdf_plus,
    to_yaml,
)
from hybrid_dynamics_core.formats.c.real import REALS
from hybrid_dynamics_core.formats.c.writer import LOADS
from hybrid_dynamics_core.formats.output_files import write_files, write_folder

from ..output import written
from ..parameters import loaded, robot_argument
from ..writing import output_option, output_path

PAIR = "robot.yaml"
C = "c"
FORMS: dict[str, Callable[[Robot, Path | None], str]] = {  # (robot, folder of the file) -> text
    "urdf": lambda robot, folder: to_urdf(robot.description, folder),
    "urdf+": lambda robot, folder: to_urdf_plus(robot.description, folder),
    "mjcf": to_mjcf,
    "sdf": to_sdf,
    "yaml": to_yaml,
}
TITLES = {
    "urdf": "URDF",
    "urdf+": "URDF+",
    "mjcf": "MJCF",
    "sdf": "SDFormat",
    "yaml": "description file",
    PAIR: "pairs of frames",
}

EPILOG = """\b
Examples:
  hybrid-dynamics export excavator --output excavator.urdf
  hybrid-dynamics export excavator --format mjcf --output excavator.xml
  hybrid-dynamics export excavator --format sdf -o excavator.sdf
  hybrid-dynamics export excavator --format robot.yaml -o excavator_pairs.yaml
  hybrid-dynamics export excavator --format c -o excavator_c
  hybrid-dynamics export ankle --format c -o ankle_f --real float
  hybrid-dynamics export my_robot.yaml | check_urdf /dev/stdin
"""


@click.command(epilog=EPILOG)
@robot_argument
@click.option(
    "--format",
    "form",
    type=click.Choice([*FORMS, PAIR, C]),
    default="urdf",
    show_default=True,
    help="Format of the file.",
)
@output_option(help="Write to this file, c to this folder; else to the terminal.")
@click.option(
    "--overwrite",
    is_flag=True,
    help="Replace files that are there, but none that ROBOT is read from.",
)
@click.option(
    "--programs",
    metavar="NAMES",
    help="Of c: functions, such as close,reactions; else closure, kinematics and dynamics.",
)
@click.option("--real", type=click.Choice(REALS), help="Of c: type of the numbers; double.")
@click.option(
    "--loads",
    type=click.Choice(LOADS),
    help="Of c: loads compiled in, or payload and friction as arguments.",
)
def command(
    robot: str,
    form: str,
    output: str | None,
    overwrite: bool,
    **of_c: str | None,
) -> None:
    """Write the robot for other tools.

    urdf: its tree, loops cut. urdf+: URDF with <loop> elements. robot.yaml: pairs of frames that
    close the loops, for Pinocchio as Gepetto has them, with the URDF written beside. mjcf: for
    MuJoCo. sdf: SDFormat, for Gazebo. yaml: a description file, as `import` writes it. All these
    can be read back; from urdf comes the tree, with every joint driven. c: closure, kinematics and
    dynamics in C99, a folder with build files.
    """
    if form == C:
        _write_c(robot, output, overwrite, of_c)
        return
    for name, value in of_c.items():
        if value is not None:
            raise click.UsageError(f"--{name} belongs to --format c; {form} has none")
    machine = loaded(robot)
    if form == PAIR:
        texts = _pair(machine, output)
        titles = [TITLES[PAIR], TITLES["urdf"]]
    elif output is None:
        click.echo(FORMS[form](machine, None), nl=False)
        return
    else:
        place = output_path(output)
        texts = {place: FORMS[form](machine, place.parent)}
        titles = [TITLES[form]]
    write_files(texts, machine.description, overwrite)
    for path, title in zip(texts, titles, strict=True):
        click.echo(written(path, title))


def _write_c(
    robot: str, output: str | None, overwrite: bool, of_c: Mapping[str, str | None]
) -> None:
    """Write the folder of C code.

    Raises:
        click.UsageError: the folder is not named.
    """
    if output is None:
        raise click.UsageError("c is a folder of files; say where with --output FOLDER")
    options: dict[str, Any] = {name: value for name, value in of_c.items() if value is not None}
    programs = options.pop("programs", None)
    if programs is not None:
        programs = [name.strip() for name in programs.split(",") if name.strip()]
    texts = to_c(loaded(robot), programs, **options)
    write_folder(texts, Path(output), overwrite)
    for name in texts:
        click.echo(written(Path(output) / name, "C99"))


def _pair(robot: Robot, output: str | None) -> dict[Path, str]:
    """The texts of a robot.yaml and of its URDF.

    Raises:
        click.UsageError: the name of the file is missing or has another suffix.
    """
    if output is None:
        raise click.UsageError(
            "robot.yaml comes with a URDF beside it; say where with --output FILE.yaml"
        )
    file = output_path(output)
    if file.suffix not in (".yaml", ".yml"):
        raise click.UsageError(
            f"--output {output}: expected a name that ends in .yaml; the URDF is written beside it"
        )
    pair = to_gepetto(robot.description, file.parent)
    return {file: pair.yaml, file.with_suffix(".urdf"): pair.urdf}
