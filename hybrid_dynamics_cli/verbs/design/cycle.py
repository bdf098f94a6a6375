"""What verbs that read a duty cycle say about its file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import click

if TYPE_CHECKING:
    from pathlib import Path

    from hybrid_dynamics_core.sizing import DutyCycle

_COLUMNS: Final = "coordinates, time, weight, payload, force.x, moment.x, ..."


def tell_unused(path: Path, duty: DutyCycle) -> None:
    """Print the columns of a duty cycle that are not used, if any, to stderr."""
    if duty.unused:
        names = ", ".join(duty.unused)
        click.echo(f"{path}: columns that are not used: {names}; known: {_COLUMNS}", err=True)
