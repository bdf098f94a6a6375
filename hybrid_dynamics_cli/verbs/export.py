"""Export of robots to other formats."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.export import (
    to_c,
    to_fmu,
    to_gepetto,
    to_mjcf,
    to_ros2_control,
    to_sdf,
    to_urdf,
    to_urdf_plus,
    to_yaml,
)
from hybrid_dynamics_core.formats.c.real import REALS
from hybrid_dynamics_core.formats.c.writer import LOADS
from hybrid_dynamics_core.formats.fmu.description import FMI3, VERSIONS
from hybrid_dynamics_core.formats.fmu.variables import FORWARD_DYNAMICS, PROGRAMS
from hybrid_dynamics_core.formats.output_files import write_files, write_folder

from ..output import written
from ..parameters import loaded, robot_argument
from ..writing import output_option, output_path

PAIR = "robot.yaml"
C, FMU, ROS2_CONTROL = "c", "fmu", "ros2_control"
OPTIONS = {  # by name: formats that it belongs to
    "programs": (C, FMU, ROS2_CONTROL),
    "real": (C,),
    "loads": (C, FMU),
    "fmi": (FMU,),
    "joints": (ROS2_CONTROL,),
}
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
  hybrid-dynamics export excavator --format fmu -o excavator.fmu
  hybrid-dynamics export excavator --format fmu -o units --fmi 2.0
  hybrid-dynamics export excavator --format ros2_control -o control
  hybrid-dynamics export my_robot.yaml | check_urdf /dev/stdin
"""


@click.command(epilog=EPILOG)
@robot_argument
@click.option(
    "--format",
    "form",
    type=click.Choice([*FORMS, PAIR, C, FMU, ROS2_CONTROL]),
    default="urdf",
    show_default=True,
    help="Format of the file.",
)
@output_option(
    help="Write to this file; c, units and packages to this folder; else to the terminal."
)
@click.option(
    "--overwrite",
    is_flag=True,
    help="Replace files that are there, but none that ROBOT is read from.",
)
@click.option(
    "--programs",
    metavar="NAMES",
    help="Of c: functions, such as close,reactions; else closure, kinematics and dynamics. Of fmu:"
    " forward_dynamics (efforts in, motion out), inverse_dynamics, or both. Of ros2_control: the"
    " plugins transmission, feed_forward, or both.",
)
@click.option("--real", type=click.Choice(REALS), help="Of c: type of the numbers; double.")
@click.option(
    "--loads",
    type=click.Choice(LOADS),
    help="Of c and fmu: loads compiled in, or payload and friction as arguments.",
)
@click.option(
    "--joints",
    metavar="NAMES",
    help="Of ros2_control: the joint side, such as boom,stick; else joints up to the end effector.",
)
@click.option("--fmi", type=click.Choice(VERSIONS), help=f"Of fmu: version of FMI; {FMI3}.")
def command(
    robot: str,
    form: str,
    output: str | None,
    overwrite: bool,
    **choices: str | None,
) -> None:
    """Write the robot for other tools.

    urdf: its tree, loops cut. urdf+: URDF with <loop> elements. robot.yaml: pairs of frames that
    close the loops, for Pinocchio as Gepetto has them, with the URDF written beside. mjcf: for
    MuJoCo. sdf: SDFormat, for Gazebo. yaml: a description file, as `import` writes it. All these
    can be read back; from urdf comes the tree, with every joint driven. c: closure, kinematics and
    dynamics in C99, a folder with build files. fmu: units for Simulink and other simulators, with
    sources, and a binary if there is a C compiler; a FILE.fmu, or a folder of them. ros2_control: a
    package with a transmission between drives and joints, and a feed-forward controller.
    """
    _check_options(form, choices)
    if form == C:
        _write_c(robot, output, overwrite, choices)
        return
    if form == FMU:
        _write_fmu(robot, output, overwrite, choices)
        return
    if form == ROS2_CONTROL:
        _write_package(robot, output, overwrite, choices)
        return
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


def _check_options(form: str, choices: Mapping[str, str | None]) -> None:
    """Refuse options of other formats.

    Raises:
        click.UsageError: an option is given to a format that has none such.
    """
    for name, value in choices.items():
        forms = OPTIONS[name]
        if value is not None and form not in forms:
            listed = " and ".join(forms)
            raise click.UsageError(f"--{name} belongs to --format {listed}; {form} has none")


def _given(choices: Mapping[str, str | None]) -> dict[str, Any]:
    """Options that are given; programs and joints as lists of names."""
    options: dict[str, Any] = {}
    for name, value in choices.items():
        if value is None:
            continue
        options[name] = value
        if name in ("programs", "joints"):
            names = [part.strip() for part in value.split(",")]
            options[name] = [part for part in names if part]
    return options


def _write_fmu(
    robot: str, output: str | None, overwrite: bool, choices: Mapping[str, str | None]
) -> None:
    """Write one unit to a file, or several to a folder.

    Raises:
        click.UsageError: the file or folder is not named, or several units would be one file.
    """
    if output is None:
        raise click.UsageError(
            "fmu is a file; say where with --output FILE.fmu, or --output FOLDER"
        )
    options = _given(choices)
    version = options.get("fmi", FMI3)
    is_file = Path(output).suffix == ".fmu"
    default = (FORWARD_DYNAMICS,) if is_file else PROGRAMS
    programs: Sequence[str] = options.get("programs", default)
    programs = list(dict.fromkeys(programs))
    if not programs or (is_file and len(programs) > 1):
        raise click.UsageError(
            f"--programs: expected one of {', '.join(PROGRAMS)}, or both and --output FOLDER"
        )
    place = output_path(output) if is_file else Path(output)
    machine = loaded(robot)
    loads = options.get("loads", LOADS[0])
    units = [to_fmu(machine, name, version=version, loads=loads) for name in programs]
    if is_file:
        paths = [place]
        write_files({place: units[0].content}, machine.description, overwrite)
    else:
        contents = {f"{unit.identifier}.fmu": unit.content for unit in units}
        paths = [place / name for name in contents]
        write_folder(contents, place, overwrite)
    for path, unit in zip(paths, units, strict=True):
        click.echo(written(path, f"FMI {version}, co-simulation and model exchange"))
        if unit.without_binary:
            click.echo(f"{path}: sources only, without a binary: {unit.without_binary}", err=True)


def _write_package(
    robot: str, output: str | None, overwrite: bool, choices: Mapping[str, str | None]
) -> None:
    """Write a package of ros2_control.

    Raises:
        click.UsageError: the folder is not named.
    """
    if output is None:
        raise click.UsageError("ros2_control is a package; say where with --output FOLDER")
    options = _given(choices)
    texts = to_ros2_control(loaded(robot), options.get("programs"), joints=options.get("joints"))
    write_folder(texts, Path(output), overwrite)
    for name in texts:
        click.echo(written(Path(output) / name))


def _write_c(
    robot: str, output: str | None, overwrite: bool, choices: Mapping[str, str | None]
) -> None:
    """Write the folder of C code.

    Raises:
        click.UsageError: the folder is not named.
    """
    if output is None:
        raise click.UsageError("c is a folder of files; say where with --output FOLDER")
    options = _given(choices)
    programs = options.pop("programs", None)
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
