"""Gain by two cores over one, for a batch of this library and for independent work."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from hybrid_dynamics_core import Robot

from . import agree
from .measure import measure

SINES = 4096  # numbers that stay in the first cache
WANTED = 1.8


@dataclass(frozen=True)
class TwoCores:
    """Speed-up by two threads over one, from the medians.

    Attributes:
        batch: of a batch of this library.
        apart: of threads that share nothing, which is the most that the machine allows.
    """

    batch: float
    apart: float

    def table(self) -> list[str]:
        """The speed-ups as lines of Markdown."""
        verdict = "not reached"
        if self.batch >= WANTED:
            verdict = "reached"
        goal, gain = f"at least {WANTED:g} times faster", f"{self.batch:.3g} times faster"
        return [
            "| inverse dynamics, batch, two cores (time on the wall) | goal | measured | |",
            "|---|---|---|---|",
            f"| two threads against one | {goal} | {gain} | {verdict} |",
            f"| the machine: two threads that share nothing | | {self.apart:.3g} times faster | |",
        ]


def two_cores(robot: Robot, rounds: int, size: int) -> TwoCores:
    """Time a batch on one thread and on two, and work that shares nothing, for comparison.

    Each thread is kept on a core of its own.

    Args:
        robot: the robot of the batch.
        rounds: how often each is timed.
        size: states of the batch.
    """
    states = agree.random_states(robot, size)
    u = states["u"]
    du = states["du"]
    ddu = states["ddu"]
    out = np.empty((size, len(robot.active)))

    def batch(count: int) -> None:
        robot.kernels.inverse_dynamics(u, du, ddu, out, threads=count)

    with ThreadPoolExecutor(1, thread_name_prefix="apart") as other:
        numbers = [np.linspace(0.0, 1.0, SINES) for _ in range(2)]
        repeats = max(1, size // 400)  # about as long as the batch

        def apart(count: int) -> None:
            tasks = []
            if count == 2:
                tasks.append(other.submit(_sines, numbers[1], repeats))
            _sines(numbers[0], repeats)
            for task in tasks:
                task.result()

        batch(2)
        apart(2)
        calls = {
            "batch 1": (batch, (1,)),
            "batch 2": (batch, (2,)),
            "apart 1": (apart, (1,)),
            "apart 2": (apart, (2,)),
        }
        with _threads_on_cores():
            times = measure(calls, rounds, clock=time.perf_counter)
    return TwoCores(
        batch=times["batch 1"].median / times["batch 2"].median,
        apart=2.0 * times["apart 1"].median / times["apart 2"].median,
    )


def _sines(numbers: np.ndarray, repeats: int) -> None:
    result = np.empty_like(numbers)
    for _ in range(repeats):
        np.sin(numbers, out=result)


@contextmanager
def _threads_on_cores() -> Iterator[None]:
    """Keep this thread on one core and all others on another, where the system can do that."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    allowed = sorted(os.sched_getaffinity(0))
    if len(allowed) < 2:
        yield
        return
    threads = {thread.native_id for thread in threading.enumerate() if thread.native_id is not None}
    try:
        for thread in threads:
            os.sched_setaffinity(thread, {allowed[1]})
        os.sched_setaffinity(threading.get_native_id(), {allowed[0]})
        yield
    finally:
        for thread in threads:
            os.sched_setaffinity(thread, allowed)
