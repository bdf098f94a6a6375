"""The whole report as Markdown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from hybrid_dynamics_core.ground.progress import Progress

from . import agree, goals, machine, run, table
from .cores import two_cores
from .side import WORKS


@dataclass(frozen=True)
class Report:
    """The whole report as Markdown, its shortest form, and as plain data: seconds, by work and engine."""

    text: str
    short: list[str]
    data: dict[str, Any]


def measured(quick: bool = False, modules: tuple[str, ...] = run.MODULES) -> Report:
    """Measure, and tell; `quick`: few short rounds, to see that it runs."""
    rounds, seconds = (3, 0.001) if quick else (9, 0.02)
    notes: list[str] = []
    robot = run.forging()
    sides = run.find_sides(robot, modules, notes.append)
    size = 2 * agree.MANY if quick else run.BATCH
    stages = run.STAGES[:2] if quick else run.STAGES
    with Progress("benchmark", len(WORKS) + 3) as progress:
        times = run.compare(robot, sides, rounds, seconds, size, progress.update)
        cores = two_cores(robot, 3 * rounds, size if quick else 10 * size)
        progress.update(len(WORKS) + 1)
        starts = run.starts()
        progress.update(len(WORKS) + 2)
        chains = run.scaling(stages, rounds)
    lines = [
        *machine.description(),
        "",
        (
            f"The forging robot: CPU time, median of {rounds} interleaved rounds; of batches of"
            f" {size}, per state."
        ),
        "",
        *table.comparison(times),
        "",
        *goals.table(times),
        "",
        *cores.table(),
        "",
        *(
            f"Import, load and first result, {name}: {wall:.2f} s ({cpu:.2f} s of CPU)"
            for name, (wall, cpu) in starts.items()
        ),
        "",
        *table.scaling(chains),
        "",
        *notes,
    ]
    data = {
        "machine": machine.description(),
        "seconds": {
            work: {name: timing.median for name, timing in rows.items()}
            for work, rows in times.items()
        },
        "two_cores": {"batch": cores.batch, "apart": cores.apart},
        "start": {name: {"wall": wall, "cpu": cpu} for name, (wall, cpu) in starts.items()},
        "notes": notes,
    }
    return Report("\n".join(lines).rstrip() + "\n", table.short(times), data)
