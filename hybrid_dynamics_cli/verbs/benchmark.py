"""Comparison of computing times with the other installed engines."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import click

from ..output import show, written
from ..parameters import json_option
from ..writing import output_option, overwrite_option, place_for

EPILOG = """\b
Examples:
  hybrid-dynamics benchmark --quick
  hybrid-dynamics benchmark --output this_machine.md
  hybrid-dynamics benchmark --json
"""


@click.command(epilog=EPILOG, short_help="Time this library beside every other engine.")
@click.option("--quick", is_flag=True, help="Few short rounds: to see that it runs.")
@output_option(help="Write the report (Markdown) to this file too.")
@overwrite_option
@json_option
def command(quick: bool, output: str | None, overwrite: bool, as_json: bool) -> None:
    """Time this library and every other engine that is installed, on the forging robot."""
    place = None
    if output is not None:
        place = place_for(output, (".md",), (), overwrite=overwrite)
    duration = "a few minutes"
    if quick:
        duration = "a minute"
    click.echo(f"This takes {duration}.", err=True)
    report = _report_module().measured(quick)
    show(report.data, as_json, report.text)
    if place is not None:
        place.write_text(report.text, encoding="utf-8")
        click.echo(written(place, "the report"), err=True)


def _report_module() -> Any:
    """The module `report` of the benchmarks, installed or in the repository of this package."""
    for package in ("hybrid_dynamics_benchmarks", "benchmarks"):
        try:
            return import_module(f"{package}.report")
        except ModuleNotFoundError as error:
            if (error.name or "").partition(".")[0] != package:
                raise
    raise click.ClickException("the benchmarks are not installed")
