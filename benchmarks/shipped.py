"""Inverse dynamics of every shipped robot: alone, along a motion, and in a batch.

python -m benchmarks.shipped [robot ...]     (in the root of the repository)

alone     one compiled call, without a history
warm      one compiled call that starts from the call before, `start=`
path      rows of a motion in one call, `start=`, per row
batch     rows near the reference in one call, per row
friendly  robot.inverse_dynamics(robot.close(u, du), ddu)
near      robot.close(u, du, near=state)
Times are CPU time, medians of interleaved rounds.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.closure import motion
from benchmarks.measure import measure
from benchmarks.table import time_text
from hybrid_dynamics_core import Robot, load, shipped_robots

ROWS = 2000
COLUMNS = ("alone", "warm", "path", "batch", "friendly", "near")


def times(robot: Robot) -> list[float]:
    """Seconds a state, by column."""
    u = motion(robot)
    here = u[len(u) // 3]
    du, ddu = np.full_like(here, 0.1), np.full_like(here, 0.2)
    slow = np.repeat(u, ROWS // len(u), axis=0)
    call = robot.kernels.inverse_dynamics
    state = robot.close(here, du)
    start = robot.kernels.start(state)

    def along() -> Any:
        return call(slow, du, ddu, start=robot.kernels.start())

    calls: dict[str, tuple[Callable[..., Any], tuple[Any, ...]]] = {
        "alone": (call, (here, du, ddu)),
        "warm": (lambda: call(here, du, ddu, start=start), ()),
        "path": (along, ()),
        "batch": (call, (slow, du, ddu)),
        "friendly": (lambda: robot.inverse_dynamics(robot.close(here, du), ddu), ()),
        "near": (lambda: robot.close(here, du, near=state), ()),
    }
    medians = {name: timing.median for name, timing in measure(calls).items()}
    for name in ("path", "batch"):
        medians[name] /= len(slow)
    return [medians[name] for name in COLUMNS]


def main() -> None:
    """The table."""
    heads = " | ".join(COLUMNS)
    sys.stdout.write(f"| robot | {heads} |\n|---|{'---:|' * len(COLUMNS)}\n")
    for name in sys.argv[1:] or shipped_robots():
        row = " | ".join(map(time_text, times(load(name))))
        sys.stdout.write(f"| {name} | {row} |\n")


if __name__ == "__main__":
    main()
