"""Tables out of bags."""

from __future__ import annotations

from pathlib import Path

import click

from hybrid_dynamics_ros.offline.export import FORMATS, export

from .common import LOST, PATH, tell_losses


@click.command(epilog="Example: hybrid-dynamics bag export results tables --format parquet")
@click.argument("bag", type=PATH)
@click.argument("out", type=PATH)
@click.option("--format", "kind", type=click.Choice(FORMATS), default="csv", help="Of the files; csv unless given.")
@click.option("--topic", "topics", multiple=True, metavar="T", help="Only this topic; may be given several times.")
@click.pass_context
def command(context: click.Context, bag: Path, out: Path, kind: str, topics: tuple[str, ...]) -> None:
    """Write the topics of BAG as tables into the folder OUT: a file a topic, a row a message, a column a number."""
    counts, losses = export(bag, out, kind, topics)
    for name, count in counts.items():
        click.echo(f"{name}: {count} rows")
    tell_losses(losses)
    if losses:
        context.exit(LOST)
