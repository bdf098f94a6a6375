"""Tables out of bags."""

from __future__ import annotations

from pathlib import Path

import click

from hybrid_dynamics_cli.output import show
from hybrid_dynamics_cli.parameters import json_option
from hybrid_dynamics_ros.offline.export import FORMATS, export

from .common import LOST, PATH, tell_losses

EPILOG = """\b
Examples:
  hybrid-dynamics bag export results tables
  hybrid-dynamics bag export results tables --format npz --topic /hybrid_dynamics/required_efforts
"""


@click.command(epilog=EPILOG)
@click.argument("bag", type=PATH)
@click.argument("out", type=PATH)
@click.option("--format", "kind", type=click.Choice(FORMATS), default="csv", help="Of the files; csv unless given.")
@click.option("--topic", "topics", multiple=True, metavar="T", help="Only this topic; may be given several times.")
@json_option
@click.pass_context
def command(context: click.Context, bag: Path, out: Path, kind: str, topics: tuple[str, ...], as_json: bool) -> None:
    """Write the topics of BAG as tables into the folder OUT: a file a topic, a row a message, a column a number."""
    counts, losses = export(bag, out, kind, topics)
    told = {"folder": str(out), "rows": dict(counts), "losses": losses}
    show(told, as_json, "\n".join(f"{name}: {count} rows" for name, count in counts.items()))
    tell_losses(losses)
    if losses:
        context.exit(LOST)
