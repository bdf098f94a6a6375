"""Conversion of any robot file to a description file."""

from __future__ import annotations

import click

from hybrid_dynamics_core.export import to_yaml
from hybrid_dynamics_core.formats.output_files import write_files

from ..output import show, written
from ..parameters import json_option, loaded_undecided, robot_argument
from ..writing import output_option, output_path

EPILOG = """\b
Examples:
  hybrid-dynamics import excavator
  hybrid-dynamics import my_robot.yaml --output written_out.yaml
"""


@click.command("import", epilog=EPILOG)
@robot_argument
@output_option(help="Write to this file; else to the terminal.")
@click.option(
    "--overwrite",
    is_flag=True,
    help="Replace a file that is there, but none that ROBOT is read from.",
)
@json_option
def command(robot: str, output: str | None, overwrite: bool, as_json: bool) -> None:
    """Write the robot of any file as a description file, to read and to edit.

    Modules, legs, rows, parameters and xacro macros are written out as links, joints and loops.
    Comments at the top say what was left out, and which names were changed. The new file is the
    same robot; where the old one leaves assembly modes open, so does the new one.
    """
    machine, undecided = loaded_undecided(robot)
    description = machine.description
    place = None if output is None else output_path(output)
    text = to_yaml(description, None if place is None else place.parent)
    notes = [*description.notes, *undecided]
    if place is None:
        show({"yaml": text, "notes": notes}, as_json, text.rstrip("\n"))
        return
    write_files({place: text}, description, overwrite)
    lines = [f"note: {note}" for note in notes]
    lines.append(written(place, f"{description.name} as a description file"))
    show({"written": str(place), "notes": notes}, as_json, "\n".join(lines))
