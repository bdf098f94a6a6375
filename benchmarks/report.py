"""The whole report as Markdown."""

from __future__ import annotations

from dataclasses import dataclass

from . import agree, goals, machine, run, table
from .cores import two_cores


@dataclass(frozen=True)
class Report:
    """The whole report as Markdown, and its shortest form."""

    text: str
    short: list[str]


def report(quick: bool = False, modules: tuple[str, ...] = run.MODULES) -> str:
    """The whole report as Markdown; `quick`: few short rounds, to see that it runs."""
    return measured(quick, modules).text


def measured(quick: bool = False, modules: tuple[str, ...] = run.MODULES) -> Report:
    """Measure, and tell."""
    rounds, seconds = (3, 0.001) if quick else (9, 0.02)
    notes: list[str] = []
    robot = run.forging()
    sides = run.find_sides(robot, modules, notes.append)
    size = 2 * agree.MANY if quick else run.BATCH
    times = run.compare(robot, sides, rounds, seconds, size)
    cores = two_cores(robot, 3 * rounds, size if quick else 10 * size)
    lines = [
        *machine.description(),
        "",
        f"The forging robot: CPU time, median of {rounds} interleaved rounds; of batches of {size}, per state.",
        "",
        *table.comparison(times),
        "",
        *goals.table(times),
        "",
        *cores.table(),
        "",
        *(
            f"Import, load and first result, {name}: {wall:.2f} s ({cpu:.2f} s of CPU)"
            for name, (wall, cpu) in run.starts().items()
        ),
        "",
        *table.scaling(run.scaling(run.STAGES[:2] if quick else run.STAGES, rounds)),
        "",
        *notes,
    ]
    return Report("\n".join(lines).rstrip() + "\n", table.short(times))
