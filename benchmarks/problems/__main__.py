"""The field's benchmark problems: accuracy, energy and time, beside other engines.

python -m benchmarks.problems [--problems NAME ...] [--sides SIDE ...] [--rounds N] [--keep FILE]
    [--publish]

Engines that are not installed are left out of the tables.
"""

from __future__ import annotations

import argparse
import importlib.util
from pathlib import Path

from benchmarks import publish
from benchmarks.machine import description

from . import platforms
from .catalogue import PROBLEMS
from .kept import keep, kept
from .plot import save
from .sides import OURS, PEERS, SIDES, SIMULATE
from .table import accuracies, times
from .turns import ROUNDS, results

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "known_problems.md"
PICTURE = ROOT / "docs" / "images" / "known_problems.svg"
MODULES = {"exudyn": "exudyn", "mujoco": "mujoco", "pinocchio": "pinocchio", "drake": "pydrake"}


def main() -> None:
    """Solve the problems, print the tables, and put them into the docs if asked."""
    names = [problem.name for problem in PROBLEMS]
    parser = argparse.ArgumentParser(prog="python -m benchmarks.problems", description=__doc__)
    parser.add_argument("--problems", nargs="+", choices=names, default=names)
    parser.add_argument("--sides", nargs="+", choices=PEERS, default=PEERS, help="other engines")
    parser.add_argument("--rounds", type=int, default=ROUNDS, help="of which the median is told")
    parser.add_argument("--publish", action="store_true", help="put tables and plot into the docs")
    parser.add_argument("--keep", type=Path, help="JSON file of results; those in it are not rerun")
    arguments = parser.parse_args()
    asked = {OURS, SIMULATE, *arguments.sides}
    sides = [side for side in SIDES if side in asked and _is_installed(side)]
    problems = [problem for problem in PROBLEMS if problem.name in arguments.problems]
    rows = kept(arguments.keep)
    for problem in problems:
        if problem.name not in rows:
            rows[problem.name] = results(problem, sides, arguments.rounds)
            keep(arguments.keep, rows)
        print(times([problem], rows, sides)[-1], flush=True)
    machine = ["", *description()]
    compared = [*times(problems, rows, sides), *machine]
    reached = accuracies(problems, rows)
    poses = platforms.lines()
    print("\n".join([*compared, "", *reached, "", *poses]))
    if arguments.publish:
        publish.put(PAGE, "times", compared)
        publish.put(PAGE, "problems", reached)
        publish.put(PAGE, "platforms", poses)
        save(problems, rows, sides, PICTURE)


def _is_installed(side: str) -> bool:
    """Whether an engine can be imported; this library always can."""
    module = MODULES.get(side)
    return module is None or importlib.util.find_spec(module) is not None


if __name__ == "__main__":
    main()
