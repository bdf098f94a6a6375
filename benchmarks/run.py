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

MODULES = (
    "ours",
    "c_extension",
    "c_export",
    "pinocchio",
    "mujoco",
    "drake",
    "casadi",
    "jax",
    "plain_numpy",
)
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
    """What is installed here.

    Args:
        robot: the robot of the tables.
        modules: of `benchmarks.sides`.
        say: called with a sentence for each that is not installed.
    """
    sides: list[Side] = []
    for name in modules:
        try:
            sides += importlib.import_module(f".sides.{name}", __package__).sides(robot)
        except (ImportError, OSError) as error:
            say(f"without {name}: {str(error).splitlines()[0]}")
    return sides


def compare(
    robot: Robot,
    sides: Sequence[Side],
    rounds: int,
    seconds: float,
    size: int = BATCH,
    done: Callable[[int], None] = lambda _: None,
) -> dict[str, dict[str, Timing]]:
    """Time all works of all sides.

    Args:
        robot: the robot of the tables.
        sides: what takes part.
        rounds: how often each is timed.
        seconds: about how long a round of one work of one side takes.
        size: states of a batch.
        done: called with the count of works that are measured.

    Returns:
        Seconds a call, or a state of a batch, by work and name of the side.
    """
    agree.check(robot, sides, list(WORKS))
    states = agree.random_states(robot, size)
    first = {key: values[0] for key, values in states.items()}
    result: dict[str, dict[str, Timing]] = {}
    for work in WORKS:
        arguments = agree.arguments(work, first)
        share = 1.0
        if work == "id_batch":
            arguments = agree.arguments(work, states)
            share = 1 / size
        calls = {side.name: (side.calls[work], arguments) for side in sides if work in side.calls}
        result[work] = {}
        for name, timing in measure(calls, rounds, seconds).items():
            result[work][name] = Timing(timing.median * share, timing.least * share)
        done(len(result))
    return result


def starts() -> dict[str, tuple[float, float]]:
    """Import, load and first result, with an empty cache (`cold`) and with a filled one (`warm`).

    Returns:
        Seconds on the wall, and of CPU, by name.
    """
    result = {}
    with tempfile.TemporaryDirectory() as folder:
        paths = {VARIABLE: str(Path(folder) / "cache"), "PYTHONPATH": os.pathsep.join(sys.path)}
        for name in ("cold", "warm"):
            answer = subprocess.run(  # noqa: S603  this Python
                [sys.executable, "-c", START],
                env={**os.environ, **paths},
                capture_output=True,
                text=True,
                check=True,
            )
            wall, cpu = map(float, answer.stdout.split())
            result[name] = (wall, cpu)
    return result


@contextmanager
def _no_cache() -> Iterator[None]:
    """Compile without a cache."""
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
    """Time chains of four-bar stages.

    Returns:
        For each number of stages: the number, and seconds to compile, of inverse dynamics, of
        forward dynamics, and of a state of a batch.
    """
    rows = []
    for count in stages:
        robot = chain(count)
        with _no_cache():
            kernels = robot.kernels
            start = time.process_time()
            kernels.inverse_dynamics(robot.reference, np.zeros(count), np.zeros(count))
            compiled = time.process_time() - start
        rng = np.random.default_rng(count)
        u = 1.2 + rng.uniform(-0.1, 0.1, (4096, count))
        du, ddu = rng.uniform(-1.0, 1.0, (2, 4096, count))
        calls = {
            "id": (kernels.inverse_dynamics, (u[0], du[0], ddu[0])),
            "fd": (kernels.forward_dynamics, (u[0], du[0], ddu[0])),
            "batch": (kernels.inverse_dynamics, (u, du, ddu)),
        }
        times = measure(calls, rounds)
        id_time = times["id"].median
        fd_time = times["fd"].median
        batch_time = times["batch"].median / len(u)
        rows.append((count, compiled, id_time, fd_time, batch_time))
    return rows


def forging() -> Robot:
    """The robot of the tables."""
    return load("forging_chu2020")
