"""`python -m benchmarks [--quick] [--output FILE] [--sides NAME ...]`."""

from __future__ import annotations

import argparse
from pathlib import Path

from benchmarks import machine, run, table


def report(quick: bool = False, modules: tuple[str, ...] = run.MODULES) -> str:
    """The whole report as Markdown; `quick`: few short rounds, to see that it runs."""
    rounds, seconds = (3, 0.001) if quick else (9, 0.02)
    notes: list[str] = []
    robot = run.forging()
    sides = run.find_sides(robot, modules, notes.append)
    times = run.compare(robot, sides, rounds, seconds)
    one, two = run.threads(robot, rounds).values()
    lines = [
        *machine.description(),
        "",
        "The forging robot, all sides checked against each other first. CPU time, median of "
        f"{rounds} interleaved rounds; batches of {run.BATCH} states, per state.",
        "",
        *table.comparison(times),
        "",
        f"Batch on two threads: {one.median / two.median:.2f} times the states of one (time on the wall).",
        "",
        *(f"Import, load and first result, {name}: {wall:.2f} s ({cpu:.2f} s of CPU)" for name, (wall, cpu) in run.starts().items()),
        "",
        *table.scaling(run.scaling(run.STAGES[:2] if quick else run.STAGES, rounds)),
        "",
        *notes,
    ]
    return "\n".join(lines).rstrip() + "\n"


def main() -> None:
    """Measure, print, and write where asked."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="few short rounds: only to see that it runs")
    parser.add_argument("--output", type=Path, help="write the report (Markdown) to this file too")
    parser.add_argument("--sides", nargs="+", choices=run.MODULES, default=run.MODULES, help="which engines")
    arguments = parser.parse_args()
    text = report(arguments.quick, tuple(arguments.sides))
    print(text, end="")
    if arguments.output is not None:
        arguments.output.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
