"""The node's pipeline on recordings."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from hybrid_dynamics_ros.bags.errors import BagCallError
from hybrid_dynamics_ros.bags.parallel import WrongCall, run_jobs
from hybrid_dynamics_ros.bags.process import SMOOTHINGS, Job, Outcome
from hybrid_dynamics_ros.bags.settings import read_settings
from hybrid_dynamics_ros.bags.storage.bag_reader import bags_of
from hybrid_dynamics_ros.bags.storage.bag_writer import THERE, require_new, require_replaceable

from ..exit_codes import FAILED, MISUSED, Misused
from ..output import show, written
from ..parameters import json_option, loaded
from .common import (
    FEW,
    LOST,
    PATH,
    first_few,
    params_option,
    robot_option,
    tell_losses,
    topic_option,
)

EPILOG = """\b
Examples:
  hybrid-dynamics bag process recording results --robot forging_chu2020
  hybrid-dynamics bag process recording results --robot excavator \\
      --topic /joint_states --smooth spline --keep
  hybrid-dynamics bag process night_shift/ results/ --robot excavator --jobs 4
  hybrid-dynamics bag process a.mcap b.mcap results/ --robot excavator \\
      --scheduler tcp://10.0.0.1:8786
"""


@click.command(epilog=EPILOG, short_help="What the node would have published for a bag.")
@click.argument("bags", type=PATH, nargs=-1, required=True, metavar="IN...")
@click.argument("out", type=PATH)
@robot_option
@topic_option
@params_option
@click.option(
    "--smooth",
    type=click.Choice(SMOOTHINGS),
    default="causal",
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
    """Write a bag with every topic that the node would have published for IN.

    With one bag, OUT is the new bag; with several, or a folder of bags, OUT is the folder for the
    new ones, under the same names. Exits with 3 where something of a bag could not be read, and
    with 1 where a bag failed.
    """
    settings = read_settings(params)
    loaded(robot)
    found = [bag for given in bags for bag in bags_of(given)]
    single = len(bags) == 1 and found == [bags[0]]
    targets = [out] if single else [out / bag.stem for bag in found]
    if len(set(targets)) < len(targets):
        raise Misused("two bags have the same name; process them into different folders")
    _require_free(bags, out, targets, single=single, overwrite=overwrite)
    work = [
        Job(bag, to, robot, topic, smooth, keep, settings)
        for bag, to in zip(found, targets, strict=True)
    ]
    results = run_jobs(work, jobs, scheduler)
    if as_json:
        told = [_facts(job, result) for job, result in zip(work, results, strict=True)]
        show({"bags": told}, as_json, "")
    else:
        for job, result in zip(work, results, strict=True):
            _tell(job, result)
    if any(not isinstance(result, Outcome) for result in results):
        sys.exit(MISUSED if all(isinstance(result, WrongCall) for result in results) else FAILED)
    if any(isinstance(result, Outcome) and result.losses for result in results):
        sys.exit(LOST)


def _require_free(
    bags: Sequence[Path], out: Path, targets: Sequence[Path], *, single: bool, overwrite: bool
) -> None:
    """Refuse to write over what is there, before anything is done."""
    if (
        out.is_dir()
        and any(out.iterdir())
        and _bags_in(out) == [out]
        and not (single and overwrite)
    ):
        understood = (
            f"read as IN: {first_few([str(bag) for bag in bags])}, as OUT: {out}; is OUT missing?"
        )
        what = THERE if single else "is a bag, and expected is a folder for the new bags"
        raise BagCallError(f"{out}: {what} ({understood})")
    for target in targets:
        (require_replaceable if overwrite else require_new)(target)


def _bags_in(path: Path) -> list[Path]:
    """The bags that a path means, none where there are none."""
    try:
        return bags_of(path)
    except BagCallError:
        return []


def _facts(job: Job, result: Outcome | str) -> dict[str, Any]:
    told: dict[str, Any] = {"source": str(job.source), "target": str(job.target), "failed": None}
    if isinstance(result, str):
        return {**told, "failed": result}
    more = {"summary": result.summary, "samples": result.samples, "duration": result.duration}
    return {
        **told,
        **more,
        "seconds": result.shares,
        "rejections": result.rejections,
        "losses": result.losses,
        "strays": result.outliers,
    }


def pace(duration: float, spent: float) -> str:
    """How long it took [s], and beside a second of samples or more, how that compares with them [s]."""
    if duration < 1.0 or spent <= 0.0:  # the start alone would tell
        return f"{spent:.1f} s"
    faster = duration / spent
    return (
        f"{spent:.1f} s, {f'{faster:.0f}' if faster >= 10.0 else f'{faster:.2g}'} times real time"
    )


def _tell(job: Job, result: Outcome | str) -> None:
    if isinstance(result, str):
        told = result.removeprefix(
            f"{job.source}: "
        )  # most errors begin with the file that they are about
        click.echo(f"{job.source}: failed: {told}", err=True)
        return
    spent = sum(result.shares.values())
    click.echo(
        written(job.target, f"from {job.source}: {result.summary}; {pace(result.duration, spent)}")
    )
    for code, text in result.rejections.items():
        click.echo(f"  rejected, {code}: {text}")
    for text in result.outliers[:FEW]:
        click.echo(f"  without accelerations, {text}")
    if len(result.outliers) > FEW:
        click.echo(f"  and {len(result.outliers) - FEW} more like this")
    tell_losses(result.losses)
