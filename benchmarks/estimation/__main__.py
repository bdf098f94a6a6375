"""`python -m benchmarks.estimation [--lifts N] [--seed S] [--publish]`: accuracy of weighing."""

from __future__ import annotations

import argparse
from pathlib import Path

from benchmarks import publish

from .weighing import weighed, weighing_table

ROOT = Path(__file__).resolve().parents[2]


def main() -> None:
    """Simulate lifts, weigh them, print the table, and put it into the docs if asked."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.estimation", description=__doc__)
    parser.add_argument("--lifts", type=int, default=200, help="number of simulated machines")
    parser.add_argument("--seed", type=int, default=0, help="seed of the first one")
    parser.add_argument(
        "--publish", action="store_true", help="put the table into docs/weighing.md"
    )
    arguments = parser.parse_args()
    lines = weighing_table(weighed(arguments.lifts, arguments.seed))
    print("\n".join(lines))
    if arguments.publish:
        publish.put(ROOT / "docs" / "weighing.md", "weighing", lines)


if __name__ == "__main__":
    main()
