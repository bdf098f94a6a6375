"""The field's benchmark problems: accuracy, energy and time.

python -m benchmarks.problems [--problems NAME ...] [--publish] [--mujoco]
"""

from __future__ import annotations

import argparse
import importlib
from pathlib import Path

from benchmarks import publish
from benchmarks.machine import description

from .catalogue import PROBLEMS
from .plot import save
from .solve import Solver
from .table import Row, lines

ROOT = Path(__file__).resolve().parents[2]
PICTURE = ROOT / "docs" / "images" / "known_problems.svg"


def main() -> None:
    """Solve the problems, print the table, and put it into the docs if asked."""
    names = [problem.name for problem in PROBLEMS]
    parser = argparse.ArgumentParser(prog="python -m benchmarks.problems", description=__doc__)
    parser.add_argument("--problems", nargs="+", choices=names, default=names)
    parser.add_argument("--publish", action="store_true", help="put table and plot into the docs")
    parser.add_argument("--mujoco", action="store_true", help="MuJoCo in place of this library")
    arguments = parser.parse_args()
    if arguments.mujoco:
        _with_mujoco(is_published=arguments.publish)
        return
    rows = []
    for problem in PROBLEMS:
        if problem.name in arguments.problems:
            solver = Solver(problem)
            rows.append(Row(problem, solver.all_answers()))
    table = [*lines(rows), "", *description()]
    print("\n".join(table))
    if arguments.publish:
        publish.put(ROOT / "docs" / "known_problems.md", "problems", table)
        save(rows, PICTURE)


def _with_mujoco(*, is_published: bool) -> None:
    """Print what MuJoCo reaches, and put it into the docs if asked."""
    side = importlib.import_module("benchmarks.problems.mujoco_side")
    table = side.lines(PROBLEMS)
    print("\n".join(table))
    if is_published:
        publish.put(ROOT / "docs" / "known_problems.md", "mujoco", table)


if __name__ == "__main__":
    main()
