"""How fast this machine is, beside every other engine that is installed."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module

import click

from ..parameters import output_path


@click.command(epilog="Example: hybrid-dynamics benchmark --quick")
@click.option("--quick", is_flag=True, help="Few short rounds: to see that it runs.")
@click.option("--output", metavar="FILE", help="Write the report (Markdown) to this file too.")
def command(quick: bool, output: str | None) -> None:
    """Time this library and every other engine that is installed, on the forging robot."""
    place = None if output is None else output_path(output)
    click.echo("This takes a few minutes." if not quick else "This takes a minute.", err=True)
    text = _report()(quick)
    click.echo(text, nl=False)
    if place is not None:
        place.write_text(text, encoding="utf-8")


def _report() -> Callable[[bool], str]:
    """From the installed package, or from the repository around it."""
    for package in ("hybrid_dynamics_benchmarks", "benchmarks"):
        try:
            report: Callable[[bool], str] = import_module(f"{package}.report").report
        except ModuleNotFoundError as error:
            if (error.name or "").partition(".")[0] != package:
                raise
        else:
            return report
    raise click.ClickException("the benchmarks are not installed")
