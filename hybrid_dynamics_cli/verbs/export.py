"""Robots for other tools."""

from __future__ import annotations

import click

from hybrid_dynamics_core.export.urdf import to_urdf

from ..parameters import loaded, output_path, robot_argument

EPILOG = """\b
Examples:
  hybrid-dynamics export excavator --output excavator.urdf
  hybrid-dynamics export my_robot.yaml | check_urdf /dev/stdin
"""


@click.command(epilog=EPILOG)
@robot_argument
@click.option("--format", "form", type=click.Choice(["urdf"]), default="urdf", show_default=True)
@click.option("--output", metavar="FILE", help="Write to this file; else to the terminal.")
def command(robot: str, form: str, output: str | None) -> None:  # noqa: ARG001  one form so far
    """Write the robot for other tools: a URDF of its tree of links, loops cut."""
    text = to_urdf(loaded(robot).description)
    if output is None:
        click.echo(text, nl=False)
    else:
        output_path(output).write_text(text, encoding="utf-8")
