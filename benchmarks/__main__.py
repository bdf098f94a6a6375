"""`python -m benchmarks [--quick] [--output FILE] [--publish] [--sides NAME ...]`."""

from __future__ import annotations

import argparse
from pathlib import Path

from . import publish
from .report import measured
from .run import MODULES

ROOT = Path(__file__).resolve().parent.parent


def main() -> None:
    """Measure, print, and write where asked."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument(
        "--quick", action="store_true", help="few short rounds: only to see that it runs"
    )
    parser.add_argument("--output", type=Path, help="write the report (Markdown) to this file too")
    parser.add_argument(
        "--sides", nargs="+", choices=MODULES, default=MODULES, help="which engines"
    )
    parser.add_argument(
        "--publish",
        action="store_true",
        help="put the tables into README.md and docs/performance.md",
    )
    arguments = parser.parse_args()
    report = measured(arguments.quick, tuple(arguments.sides))
    print(report.text, end="")
    if arguments.publish:
        publish.put(ROOT / "docs" / "performance.md", "report", report.text.splitlines())
        publish.put(ROOT / "README.md", "short", report.short)
    if arguments.output is not None:
        arguments.output.write_text(report.text, encoding="utf-8")


if __name__ == "__main__":
    main()
