"""Export of tables from bags."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import click

from hybrid_dynamics_core.ground.wording import counted
from hybrid_dynamics_ros.bags.analysis.tables import FORMATS, export, table_file

from ..output import show, written
from ..parameters import json_option
from .common import LOST, PATH, list_names, tell_losses

HELP: Final = """Write the topics of BAG as tables into the folder OUT: a file a topic, a row a
message, a column a number."""
EPILOG: Final = """\b
Examples:
  hybrid-dynamics bag export results tables
  hybrid-dynamics bag export results tables --format npz \\
      --topic /hybrid_dynamics/required_efforts
"""


@click.command(epilog=EPILOG, help=HELP, short_help="Tables out of a bag: CSV, Parquet or .npz.")
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
    """Write the tables."""
    counts, losses = export(bag, out, kind, topics, overwrite=overwrite)
    tables = {name: table_file(out, name, kind) for name in counts}
    others = sorted(file.name for file in out.iterdir() if file not in tables.values())
    lines = []
    for name, count in counts.items():
        lines.append(written(tables[name], f"{counted(count, 'row')} of {name}"))
    facts = {"folder": str(out), "rows": counts, "losses": losses, "others": others}
    show(facts, as_json, "\n".join(lines))
    if others:
        click.echo(f"note: {out} holds what was there before too: {list_names(others)}", err=True)
    tell_losses(losses)
    if losses:
        context.exit(LOST)
