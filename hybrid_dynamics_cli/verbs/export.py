"""Robots for other tools."""

from __future__ import annotations

from collections.abc import Callable

import click

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.export import to_gepetto, to_mjcf, to_sdf, to_urdf, to_urdf_plus

from ..parameters import loaded, output_path, robot_argument

PAIR = "robot.yaml"
FORMS: dict[str, Callable[[Robot], str]] = {
    "urdf": lambda robot: to_urdf(robot.description),
    "urdf+": lambda robot: to_urdf_plus(robot.description),
    "mjcf": to_mjcf,
    "sdf": to_sdf,
}

EPILOG = """\b
Examples:
  hybrid-dynamics export excavator --output excavator.urdf
  hybrid-dynamics export excavator --format mjcf --output excavator.xml
  hybrid-dynamics export excavator --format sdf -o excavator.sdf
  hybrid-dynamics export excavator --format robot.yaml -o excavator.yaml
  hybrid-dynamics export my_robot.yaml | check_urdf /dev/stdin
"""


@click.command(epilog=EPILOG)
@robot_argument
@click.option("--format", "form", type=click.Choice([*FORMS, PAIR]), default="urdf", show_default=True)
@click.option("-o", "--output", metavar="FILE", help="Write to this file; else to the terminal.")
def command(robot: str, form: str, output: str | None) -> None:
    """Write the robot for other tools.

    urdf: its tree, loops cut. urdf+: URDF with <loop> elements. robot.yaml: pairs of frames that close the loops, for
    Pinocchio as Gepetto has them, with the URDF written beside. mjcf: for MuJoCo. sdf: SDFormat, for Gazebo. All but
    the first can be read back.
    """
    if form == PAIR:
        _write_pair(loaded(robot), output)
        return
    text = FORMS[form](loaded(robot))
    if output is None:
        click.echo(text, nl=False)
    else:
        output_path(output).write_text(text, encoding="utf-8")


def _write_pair(robot: Robot, output: str | None) -> None:
    if output is None:
        raise click.UsageError("robot.yaml comes with a URDF beside it; say where with --output FILE.yaml")
    file = output_path(output)
    if file.suffix not in (".yaml", ".yml"):
        raise click.UsageError(f"--output {output}: expected a name that ends in .yaml; the URDF is written beside it")
    pair = to_gepetto(robot.description)
    file.write_text(pair.yaml, encoding="utf-8")
    file.with_suffix(".urdf").write_text(pair.urdf, encoding="utf-8")
