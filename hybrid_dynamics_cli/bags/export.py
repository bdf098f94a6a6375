"""Tables out of bags."""

from __future__ import annotations

from pathlib import Path

import click

from hybrid_dynamics_core.ground.wording import counted
from hybrid_dynamics_ros.bags.analysis.tables import FORMATS, export, table_file

from ..output import show, written
from ..parameters import json_option
from .common import LOST, PATH, first_few, tell_losses

EPILOG = """\b
Examples:
  hybrid-dynamics bag export results tables
  hybrid-dynamics bag export results tables --format npz \\
      --topic /hybrid_dynamics/required_efforts
"""


@click.command(epilog=EPILOG, short_help="Tables out of a bag: CSV, Parquet or .npz.")
@click.argument("bag", type=PATH)
@click.argument("out", type=PATH)
@click.option(
    "--format",
    "kind",
    type=click.Choice(FORMATS),
    default="csv",
    show_default=True,
    help="Format of the files.",
)
@click.option(
    "--topic",
    "topics",
    multiple=True,
    metavar="T",
    help="Only this topic; repeatable.  [default: all]",
)
@click.option(
    "--overwrite",
    is_flag=True,
    help="Into a folder with something in it: replace files of the same names.",
)
@json_option
@click.pass_context
def command(  # noqa: PLR0913, PLR0917 - an argument for each option
    context: click.Context,
    bag: Path,
    out: Path,
    kind: str,
    topics: tuple[str, ...],
    overwrite: bool,
    as_json: bool,
) -> None:
    """Write the topics of BAG as tables into the folder OUT: a file a topic, a row a message, a column a number."""
    counts, losses = export(bag, out, kind, topics, overwrite=overwrite)
    tables = {name: table_file(out, name, kind) for name in counts}
    others = sorted(file.name for file in out.iterdir() if file not in tables.values())
    lines = [
        written(tables[name], f"{counted(count, 'row')} of {name}")
        for name, count in counts.items()
    ]
    told = {"folder": str(out), "rows": dict(counts), "losses": losses, "others": others}
    show(told, as_json, "\n".join(lines))
    if others:
        click.echo(f"note: {out} holds what was there before too: {first_few(others)}", err=True)
    tell_losses(losses)
    if losses:
        context.exit(LOST)
