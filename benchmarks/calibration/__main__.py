"""`python -m benchmarks.calibration [--machines N] [--seed S]`: accuracy of calibration."""

from __future__ import annotations

import argparse
from pathlib import Path

from benchmarks import publish

from .accuracy import accuracy, accuracy_table
from .simulated import FREE

ROOT = Path(__file__).resolve().parents[2]


def main() -> None:
    """Simulate machines, calibrate them, print the table, and put it into the docs if asked."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.calibration", description=__doc__)
    parser.add_argument("--machines", type=int, default=20, help="simulated machines a robot")
    parser.add_argument("--seed", type=int, default=0, help="seed of the first one")
    parser.add_argument("--robots", nargs="*", default=list(FREE), help="names of shipped robots")
    parser.add_argument(
        "--publish", action="store_true", help="put the table into docs/calibration.md"
    )
    arguments = parser.parse_args()
    results = [accuracy(name, arguments.machines, arguments.seed) for name in arguments.robots]
    lines = accuracy_table(results)
    print("\n".join(lines))
    if arguments.publish:
        publish.put(ROOT / "docs" / "calibration.md", "calibration", lines)


if __name__ == "__main__":
    main()
