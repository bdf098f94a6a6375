"""`python -m benchmarks.design [--points N]`: CPU time of a design with ten variables.

Ten numbers of the two cylinders of the forging robot are chosen so that the largest force along its
path is least: both coordinates of four pins, and two barrels, within strokes and away from singular
places. The time is that of the process, from the robot's file on, imports left out.
"""

from __future__ import annotations

import argparse
import runpy
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]


def main() -> None:
    """Solve by each method that is there, and print CPU times."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.design", description=__doc__)
    parser.add_argument("--points", type=int, default=20, help="points of duty")
    arguments = parser.parse_args()
    example: dict[str, Any] = runpy.run_path(str(ROOT / "examples" / "forging_redesign.py"))
    methods = ["SLSQP"]
    if find_spec("casadi"):
        methods.append("ipopt")
    for method in methods:
        start = time.process_time()
        design = example["problem"](arguments.points)
        result = example["solve"](design, method=method)
        spent = time.process_time() - start
        counts = f"{len(design.names)} variables, {arguments.points} points of duty"
        print(f"{method}: {counts}: {spent:.1f} s of CPU, objective {result.objective:.6f}")


if __name__ == "__main__":
    main()
