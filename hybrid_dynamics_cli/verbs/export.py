"""Robots for other tools."""

from __future__ import annotations

from collections.abc import Callable

import click

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.export.mjcf import to_mjcf
from hybrid_dynamics_core.export.urdf import to_urdf

from ..parameters import loaded, output_path, robot_argument

FORMS: dict[str, Callable[[Robot], str]] = {"urdf": lambda robot: to_urdf(robot.description), "mjcf": to_mjcf}

EPILOG = """\b
Examples:
  hybrid-dynamics export excavator --output excavator.urdf
  hybrid-dynamics export excavator --format mjcf --output excavator.xml
  hybrid-dynamics export my_robot.yaml | check_urdf /dev/stdin
"""


@click.command(epilog=EPILOG)
@robot_argument
@click.option("--format", "form", type=click.Choice(list(FORMS)), default="urdf", show_default=True)
@click.option("--output", metavar="FILE", help="Write to this file; else to the terminal.")
def command(robot: str, form: str, output: str | None) -> None:
    """Write the robot for other tools: URDF of its tree, loops cut; MJCF with its loops, for MuJoCo."""
    text = FORMS[form](loaded(robot))
    if output is None:
        click.echo(text, nl=False)
    else:
        output_path(output).write_text(text, encoding="utf-8")
