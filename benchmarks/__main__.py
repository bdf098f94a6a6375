"""`python -m benchmarks [--quick] [--output FILE] [--sides NAME ...]`."""

from __future__ import annotations

import argparse
from pathlib import Path

from .report import report
from .run import MODULES


def main() -> None:
    """Measure, print, and write where asked."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="few short rounds: only to see that it runs")
    parser.add_argument("--output", type=Path, help="write the report (Markdown) to this file too")
    parser.add_argument("--sides", nargs="+", choices=MODULES, default=MODULES, help="which engines")
    arguments = parser.parse_args()
    text = report(arguments.quick, tuple(arguments.sides))
    print(text, end="")
    if arguments.output is not None:
        arguments.output.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
