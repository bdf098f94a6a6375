"""Processing of recordings as the node does."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from itertools import chain
from pathlib import Path
from typing import Any, Final

import click

from hybrid_dynamics_ros.bags.errors import BagCallError
from hybrid_dynamics_ros.bags.job import CAUSAL, SMOOTHINGS, Job
from hybrid_dynamics_ros.bags.parallel import Result, WrongCall, run_jobs
from hybrid_dynamics_ros.bags.provenance import smoothing_of
from hybrid_dynamics_ros.bags.settings import read_settings
from hybrid_dynamics_ros.bags.storage.bag_reader import bags_of
from hybrid_dynamics_ros.bags.storage.bag_writer import THERE, require_new, require_replaceable

from ..exit_codes import DONE, FAILED, MISUSED, Misused
from ..output import show, written
from ..parameters import json_option, loaded
from .common import (
    LOST,
    MAX_LISTED,
    PATH,
    list_names,
    params_option,
    robot_option,
    tell_losses,
    topic_option,
)

HELP: Final = """Write a bag with every topic that the node would have published for IN.

With one bag, OUT is the new bag; with several, or a folder of bags, OUT is the folder for the
new ones, under the same names. Exits with 3 where something of a bag could not be read, and
with 1 where a bag failed.
"""
EPILOG: Final = """\b
Examples:
  hybrid-dynamics bag process recording results --robot forging_chu2020
  hybrid-dynamics bag process recording results --robot excavator \\
      --topic /joint_states --smooth spline --keep
  hybrid-dynamics bag process night_shift/ results/ --robot excavator --jobs 4
  hybrid-dynamics bag process a.mcap b.mcap results/ --robot excavator \\
      --scheduler tcp://10.0.0.1:8786
"""


@click.command(epilog=EPILOG, help=HELP, short_help="What the node would have published for a bag.")
@click.argument("bags", type=PATH, nargs=-1, required=True, metavar="IN...")
@click.argument("out", type=PATH)
@robot_option
@topic_option
@params_option
@click.option(
    "--smooth",
    type=click.Choice(SMOOTHINGS),
    default=CAUSAL,
    show_default=True,
    help="How rates are found; causal: as the node.",
)
@click.option(
    "--keep", is_flag=True, help="The topics of IN, recorded efforts too, go into the new bag."
)
@click.option("--overwrite", is_flag=True, help="Replace bags that are there already.")
@click.option(
    "--jobs",
    type=click.IntRange(1),
    default=1,
    show_default=True,
    help="Bags at a time, a process each.",
)
@click.option(
    "--scheduler", metavar="ADDRESS", help="Dask scheduler whose workers see the same files."
)
@json_option
def command(  # noqa: PLR0913, PLR0917 - an argument for each option
    bags: tuple[Path, ...],
    out: Path,
    robot: str,
    topic: str | None,
    params: Path | None,
    smooth: str,
    keep: bool,
    overwrite: bool,
    jobs: int,
    scheduler: str | None,
    as_json: bool,
) -> None:
    """Process the bags."""
    settings = read_settings(params)
    loaded(robot)
    sources = list(chain.from_iterable(bags_of(path) for path in bags))
    is_single = len(bags) == 1 and sources == [bags[0]]
    targets = _targets(sources, out, is_single=is_single)
    _require_place(bags, out, is_single=is_single, overwrite=overwrite)
    require_place = require_replaceable if overwrite else require_new
    work = []
    for source, target in zip(sources, targets, strict=True):
        require_place(target)
        work.append(Job(source, target, robot, topic, smooth, keep, settings))
    results = run_jobs(work, jobs, scheduler)
    pairs = list(zip(work, results, strict=True))
    if as_json:
        show({"bags": [_facts(job, result) for job, result in pairs]}, as_json, "")
    else:
        for job, result in pairs:
            _print_result(job, result)
    code = _exit_code(results)
    if code:
        sys.exit(code)


def _targets(sources: Sequence[Path], out: Path, *, is_single: bool) -> list[Path]:
    """Paths of the new bags. Raises Misused if two are the same."""
    if is_single:
        return [out]
    targets = [out / source.stem for source in sources]
    if len(set(targets)) < len(targets):
        raise Misused("two bags have the same name; process them into different folders")
    return targets


def _exit_code(results: Sequence[Result]) -> int:
    """The exit code of the command."""
    if all(isinstance(result, WrongCall) for result in results):
        return MISUSED
    code = DONE
    for result in results:
        if isinstance(result, str):
            return FAILED
        if result.losses:
            code = LOST
    return code


def _require_place(bags: Sequence[Path], out: Path, *, is_single: bool, overwrite: bool) -> None:
    """Refuse an existing bag as OUT, in case OUT was forgotten. Raises BagCallError."""
    if not _is_bag(out) or (is_single and overwrite):
        return
    if is_single and smoothing_of(out) is not None:
        raise BagCallError(
            f"{out}: holds the results of an earlier `bag process`; give --overwrite to replace"
            " them, or name a new folder"
        )
    sources = list_names([str(bag) for bag in bags])
    understood = f"read as IN: {sources}, as OUT: {out}; is OUT missing?"
    what = THERE
    if not is_single:
        what = "is a bag, and expected is a folder for the new bags"
    raise BagCallError(f"{out}: {what} ({understood})")


def _is_bag(path: Path) -> bool:
    """Whether a path is the folder of one bag."""
    if not path.is_dir() or not any(path.iterdir()):
        return False
    try:
        return bags_of(path) == [path]
    except BagCallError:
        return False


def _facts(job: Job, result: Result) -> dict[str, Any]:
    """The result of a job as plain data, for JSON."""
    facts: dict[str, Any] = {"source": str(job.source), "target": str(job.target), "failed": None}
    if isinstance(result, str):
        facts["failed"] = result
        return facts
    return {
        **facts,
        "summary": result.summary,
        "samples": result.samples,
        "duration": result.duration,
        "seconds": result.shares,
        "rejections": result.rejections,
        "losses": result.losses,
        "strays": result.outliers,
    }


def pace(duration: float, spent: float) -> str:
    """The computing time as text, and as a multiple of real time for samples of at least 1 s.

    Args:
        duration: duration of the samples [s].
        spent: computing time [s].
    """
    if duration < 1.0 or spent <= 0.0:  # the start-up takes as long
        return f"{spent:.1f} s"
    ratio = duration / spent
    times = f"{ratio:.0f}" if ratio >= 10.0 else f"{ratio:.2g}"
    return f"{spent:.1f} s, {times} times real time"


def _print_result(job: Job, result: Result) -> None:
    """Print the result of a job."""
    if isinstance(result, str):
        reason = result.removeprefix(f"{job.source}: ")  # most errors begin with the source
        click.echo(f"{job.source}: failed: {reason}", err=True)
        return
    took = pace(result.duration, sum(result.shares.values()))
    click.echo(written(job.target, f"from {job.source}: {result.summary}; {took}"))
    for code, text in result.rejections.items():
        click.echo(f"  rejected, {code}: {text}")
    for text in result.outliers[:MAX_LISTED]:
        click.echo(f"  without accelerations, {text}")
    if len(result.outliers) > MAX_LISTED:
        click.echo(f"  and {len(result.outliers) - MAX_LISTED} more like this")
    tell_losses(result.losses)
