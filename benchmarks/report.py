"""The whole report as Markdown."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from hybrid_dynamics_core.ground.progress import Progress

from . import agree, goals, machine, run, table
from .cores import two_cores
from .measure import Timing
from .side import WORKS


@dataclass(frozen=True)
class _Extent:
    """How much is measured.

    Attributes:
        rounds: of every call.
        seconds: of a round.
        batch: states.
        two_cores_batch: states, for the comparison of one thread with two.
        chains: how many of run.STAGES.
    """

    rounds: int
    seconds: float
    batch: int
    two_cores_batch: int
    chains: int


QUICK = _Extent(3, 0.001, 2 * agree.BATCH, 2 * agree.BATCH, 2)
FULL = _Extent(9, 0.02, run.BATCH, 10 * run.BATCH, len(run.STAGES))


@dataclass(frozen=True)
class Report:
    """What was measured.

    Attributes:
        text: all of it as Markdown.
        short: lines of its shortest table.
        data: seconds by work and engine, and the remaining numbers, as plain data.
    """

    text: str
    short: list[str]
    data: dict[str, Any]


def measured(quick: bool = False, modules: tuple[str, ...] = run.MODULES) -> Report:
    """Measure, and report.

    Args:
        quick: few short rounds, to see that it runs.
        modules: of `benchmarks.sides`.
    """
    extent = FULL
    if quick:
        extent = QUICK
    notes: list[str] = []
    robot = run.forging()
    sides = run.find_sides(robot, modules, notes.append)
    rounds = extent.rounds
    size = extent.batch
    with Progress("benchmark", len(WORKS) + 3) as progress:
        times = run.compare(robot, sides, rounds, extent.seconds, size, progress.update)
        cores = two_cores(robot, 3 * rounds, extent.two_cores_batch)
        progress.update(len(WORKS) + 1)
        starts = run.starts()
        progress.update(len(WORKS) + 2)
        chains = run.scaling(run.STAGES[: extent.chains], rounds)
    title = f"The forging robot: CPU time, median of {rounds} interleaved rounds"
    lines = [
        *machine.description(),
        "",
        f"{title}; of batches of {size}, per state.",
        "",
        *table.comparison(times),
        "",
        *goals.table(times),
        "",
        *cores.table(),
        "",
        *_start_lines(starts),
        "",
        *table.scaling(chains),
        "",
        *notes,
    ]
    data = {
        "machine": machine.description(),
        "seconds": {work: _medians(rows) for work, rows in times.items()},
        "two_cores": {"batch": cores.batch, "apart": cores.apart},
        "start": {name: {"wall": wall, "cpu": cpu} for name, (wall, cpu) in starts.items()},
        "notes": notes,
    }
    return Report("\n".join(lines).rstrip() + "\n", table.short(times), data)


def _medians(timings: Mapping[str, Timing]) -> dict[str, float]:
    return {name: timing.median for name, timing in timings.items()}


def _start_lines(starts: Mapping[str, tuple[float, float]]) -> list[str]:
    lines = []
    for name, (wall, cpu) in starts.items():
        seconds = f"{wall:.2f} s ({cpu:.2f} s of CPU)"
        lines.append(f"Import, load and first result, {name}: {seconds}")
    return lines
