"""What two cores give over one: a batch of this library, and work that shares nothing, for comparison."""

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
    """Work done by two threads in the time in which one does 1, by the medians: of a batch, and of work apart."""

    batch: float
    apart: float

    def table(self) -> list[str]:
        """As lines of Markdown."""
        verdict = "reached" if self.batch >= WANTED else "not reached"
        return [
            "| inverse dynamics, batch, two cores (time on the wall) | wanted | measured | |",
            "|---|---|---:|---|",
            (
                f"| two threads beside one | {WANTED:g} times the states | {self.batch:.3g} |"
                f" {verdict} |"
            ),
            f"| the machine: two threads that share nothing | | {self.apart:.3g} | |",
        ]


def two_cores(robot: Robot, rounds: int, size: int) -> TwoCores:
    """Time a batch on one thread and on two, each thread kept on a core of its own, beside what the machine allows."""
    states = agree.random_states(robot, size)
    u, du, ddu, out = states["u"], states["du"], states["ddu"], np.empty((size, len(robot.active)))

    def batch(count: int) -> None:
        robot.kernels.inverse_dynamics(u, du, ddu, out, threads=count)

    with ThreadPoolExecutor(1, thread_name_prefix="apart") as other:
        numbers = [np.linspace(0.0, 1.0, SINES) for _ in range(2)]

        def sines(own: np.ndarray) -> None:
            result = np.empty_like(own)
            for _ in range(max(1, size // 400)):  # about as long as the batch
                np.sin(own, out=result)

        def apart(count: int) -> None:
            beside = [other.submit(sines, numbers[1])] if count == 2 else []
            sines(numbers[0])
            for task in beside:
                task.result()

        batch(2)
        apart(2)
        calls = {
            (work.__name__, count): (work, (count,)) for work in (batch, apart) for count in (1, 2)
        }
        with _threads_on_cores():
            times = measure(
                {f"{name} {n}": call for (name, n), call in calls.items()},
                rounds,
                clock=time.perf_counter,
            )
    return TwoCores(
        batch=times["batch 1"].median / times["batch 2"].median,
        apart=2.0 * times["apart 1"].median / times["apart 2"].median,
    )


@contextmanager
def _threads_on_cores() -> Iterator[None]:
    """Keep this thread on one core and all others on another, where the system can do that."""
    if not hasattr(os, "sched_setaffinity") or len(allowed := sorted(os.sched_getaffinity(0))) < 2:
        yield
        return
    threads = {thread.native_id for thread in threading.enumerate() if thread.native_id is not None}
    own = threading.get_native_id()
    try:
        for thread in threads:
            os.sched_setaffinity(thread, {allowed[0 if thread == own else 1]})
        yield
    finally:
        for thread in threads:
            os.sched_setaffinity(thread, allowed)
