"""Designs a second of processor time: `python -m benchmarks.sweeps [NUMBER]`."""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

from hybrid_dynamics_core.sweeps import Study, grid, sweep, sweep_into

NUMBER = 1000  # of values of each parameter
STUDIES = {
    "forging_chu2020": ({"L2": (0.6, 0.9), "L3": (0.7, 0.9)}, "effort.q12", "coordinate.q2"),
    "excavator": ({"boom": (5.6, 5.8), "stick": (2.8, 3.0)}, "effort.slew", "coordinate.slew"),
    "delta": (
        {
            "modules.delta.parameters.arm": (0.28, 0.32),
            "modules.delta.parameters.rod": (0.75, 0.85),
        },
        "effort.theta_A",
        "coordinate.theta_A",
    ),
}


def study(robot: str, count: int) -> Study:
    """A grid over two lengths; four quantities of each design at the reference."""
    bounds, *names = STUDIES[robot]
    ranges = {name: (low, high, count) for name, (low, high) in bounds.items()}
    return Study(robot, grid(ranges), ["position.z", "singularity", *names])


def seconds(work: Callable[[], Any]) -> float:
    """Processor time of some work [s]."""
    before = time.process_time()
    work()
    return time.process_time() - before


def rates(robot: str, count: int) -> dict[str, float]:
    """Designs a second in memory, into CSV and into Parquet."""
    sweep(study(robot, 2))  # compiles
    total = count * count
    result = {"in memory": total / seconds(lambda: sweep(study(robot, count)))}
    for name in ("csv", "parquet"):
        with tempfile.TemporaryDirectory() as folder:

            def written(folder: str = folder, name: str = name) -> None:
                sweep_into(study(robot, count), folder, file_format=name)

            result[name] = total / seconds(written)
    return result


def main() -> None:
    """Print the rates of all robots."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else NUMBER
    print(f"| robot, {count * count} designs | in memory | CSV | Parquet |")
    print("|---|---|---|---|")
    for robot in STUDIES:
        cells = [f"{rate:,.0f}" for rate in rates(robot, count).values()]
        print(f"| `{robot}` | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
