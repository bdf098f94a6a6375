"""All sides, timed side by side: the tables."""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_core.kernels.cache import VARIABLE

from . import agree
from .chain import chain
from .measure import Timing, measure
from .side import WORKS, Side

MODULES = ("ours", "c_extension", "pinocchio", "mujoco", "drake", "casadi", "jax", "plain_numpy")
BATCH = 100_000
STAGES = (1, 2, 4, 8, 16)

START = """
import time; t = time.perf_counter()
from hybrid_dynamics_core import load
robot = load("forging_chu2020")
state = robot.close([0.0, 0.1, 0.15, 0.0])
tau = robot.inverse_dynamics(state, [0.0, 0.0, 0.0, 0.0])
print(time.perf_counter() - t, time.process_time())
"""


def find_sides(robot: Robot, modules: Sequence[str], say: Callable[[str], None]) -> list[Side]:
    """What is installed here; what is not is told and left out."""
    found: list[Side] = []
    for name in modules:
        try:
            found += importlib.import_module(f".sides.{name}", __package__).sides(robot)
        except (ImportError, OSError) as error:
            say(f"without {name}: {str(error).splitlines()[0]}")
    return found


def compare(
    robot: Robot,
    sides: Sequence[Side],
    rounds: int,
    seconds: float,
    size: int = BATCH,
    done: Callable[[int], None] = lambda _: None,
) -> dict[str, dict[str, Timing]]:
    """By work and side: seconds a call, or a state of a batch.

    `done` is told how many works are measured.
    """
    agree.check(robot, sides, list(WORKS))
    states = agree.random_states(robot, size)
    first = {key: values[0] for key, values in states.items()}
    result = {}
    for work in WORKS:
        given = agree.arguments(work, states if work == "id_batch" else first)
        calls = {side.name: (side.calls[work], given) for side in sides if work in side.calls}
        timings = measure(calls, rounds, seconds) if calls else {}
        share = 1 / size if work == "id_batch" else 1.0
        result[work] = {
            name: Timing(t.median * share, t.least * share) for name, t in timings.items()
        }
        done(len(result))
    return result


def starts() -> dict[str, tuple[float, float]]:
    """Import, load and first result, without and with what an earlier start left: seconds on the wall, and of CPU."""
    result = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in ("cold", "warm"):
            environment = {
                **os.environ,
                VARIABLE: str(Path(folder) / "cache"),
                "PYTHONPATH": os.pathsep.join(sys.path),
            }
            answer = subprocess.run(  # noqa: S603  this Python
                [sys.executable, "-c", START],
                env=environment,
                capture_output=True,
                text=True,
                check=True,
            )
            wall, cpu = map(float, answer.stdout.split())
            result[name] = (wall, cpu)
    return result


@contextmanager
def _no_cache() -> Iterator[None]:
    """What is compiled is not looked up, nor kept."""
    before = os.environ.get(VARIABLE)
    os.environ[VARIABLE] = "off"
    try:
        yield
    finally:
        if before is None:
            del os.environ[VARIABLE]
        else:
            os.environ[VARIABLE] = before


def scaling(stages: Sequence[int], rounds: int) -> list[tuple[int, float, float, float, float]]:
    """Per number of four-bar stages: seconds to compile, of inverse and forward dynamics, of a state of a batch."""
    rows = []
    for count in stages:
        robot = chain(count)
        with _no_cache():
            kernels = robot.kernels
            start = time.process_time()
            kernels.inverse_dynamics(robot.reference, np.zeros(count), np.zeros(count))
            made = time.process_time() - start
        rng = np.random.default_rng(count)
        u = 1.2 + rng.uniform(-0.1, 0.1, (4096, count))
        du, ddu = rng.uniform(-1.0, 1.0, (2, 4096, count))
        calls = {
            "id": (kernels.inverse_dynamics, (u[0], du[0], ddu[0])),
            "fd": (kernels.forward_dynamics, (u[0], du[0], ddu[0])),
            "batch": (kernels.inverse_dynamics, (u, du, ddu)),
        }
        t = {name: timing.median for name, timing in measure(calls, rounds).items()}
        rows.append((count, made, t["id"], t["fd"], t["batch"] / len(u)))
    return rows


def forging() -> Robot:
    """The robot of the tables."""
    return load("forging_chu2020")
