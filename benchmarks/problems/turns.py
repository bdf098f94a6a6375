"""All engines on one problem, by turns, each in a process of its own.

A process that takes too long is ended: some engines find no step on, and do not say so.
"""

from __future__ import annotations

import math
import multiprocessing
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection

from .catalogue import DRIFT, PROBLEMS, Problem
from .sides import OURS, SIMULATE, Reached, opened, settings_of

LONGEST = 2.0  # [s] of CPU time: a finer setting is not tried after such a run
PATIENCE = 60.0  # [s] of waiting for a run
START = 600.0  # [s] of waiting until a problem is read and compiled
READY = "ready"
ROUNDS = 5


@dataclass(frozen=True)
class Result:
    """The coarsest setting of a side that reaches what is asked, else the nearest.

    Attributes:
        side: its name.
        best: error, drift and median of the CPU times.
        setting: tolerance or number of steps.
        trouble: why there is no number; empty if there is one.
        is_reached: whether the accuracy asked is reached.
    """

    side: str
    best: Reached
    setting: float
    trouble: str
    is_reached: bool


NOTHING = Reached(math.inf, math.nan, math.nan)


class Worker:
    """One side of one problem, in a process of its own."""

    def __init__(self, side: str, problem: Problem) -> None:
        self.side = side
        context = multiprocessing.get_context("spawn")
        self._pipe, other = context.Pipe()
        self._process = context.Process(
            target=_serve, args=(other, side, problem.name), daemon=True
        )
        self._process.start()
        self.trouble = ""
        if not self._pipe.poll(START):
            self.trouble = f"did not start within {START:.0f} s"
        elif self._answer() != READY:
            self.close()

    def run(self, setting: float) -> Reached:
        """One run; `trouble` is set if there is no result."""
        if self.trouble:
            return NOTHING
        self._pipe.send(setting)
        if not self._pipe.poll(PATIENCE):
            self.trouble = f"no end within {PATIENCE:.0f} s"
            self.close()
            return NOTHING
        answer = self._answer()
        if isinstance(answer, Reached):
            return answer
        return NOTHING

    def _answer(self) -> Reached | str:
        try:
            answer: Reached | str = self._pipe.recv()
        except EOFError:
            self.trouble = "its process died"
            return self.trouble
        if isinstance(answer, str) and answer.startswith("cannot"):
            self.trouble = answer
        return answer

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.join()


def _serve(pipe: Connection, side: str, name: str) -> None:
    """Run settings as they come; a text is the reason why there is no result."""
    problem = next(one for one in PROBLEMS if one.name == name)
    try:
        run = opened(side, problem)
    except (ImportError, OSError) as error:
        pipe.send(f"cannot run: {error}")
        return
    pipe.send(READY)
    while True:
        setting = pipe.recv()
        try:
            pipe.send(run(setting))
        except Exception as error:  # noqa: BLE001  of any engine; it is reported
            pipe.send(f"failed: {error}")


def results(problem: Problem, sides: Sequence[str], rounds: int = ROUNDS) -> list[Result]:
    """What each side reaches, and how long it takes.

    Args:
        problem: with a reference.
        sides: to be asked.
        rounds: how often each side runs at its setting, by turns.
    """
    workers = [Worker(side, problem) for side in sides]
    found = [_search(worker, problem.asked) for worker in workers]
    times: list[list[float]] = [[best.seconds] for best, _ in found]
    for _ in range(rounds - 1):
        for worker, (best, setting), seconds in zip(workers, found, times, strict=True):
            if best.seconds < LONGEST:
                seconds.append(worker.run(setting).seconds)
    answers = []
    for worker, (best, setting), seconds in zip(workers, found, times, strict=True):
        timed = best._replace(seconds=statistics.median(seconds))
        is_reached = _is_enough(worker.side, best, problem.asked)
        answers.append(Result(worker.side, timed, setting, worker.trouble, is_reached))
        worker.close()
    return answers


def _search(worker: Worker, asked: float) -> tuple[Reached, float]:
    """The coarsest setting that is enough, else that with the least error."""
    best = (NOTHING, math.nan)
    for setting in settings_of(worker.side):
        reached = worker.run(setting)
        if reached.error < best[0].error:
            best = (reached, setting)
        if _is_enough(worker.side, reached, asked) or reached.seconds > LONGEST:
            break
    return best


def _is_enough(side: str, reached: Reached, asked: float) -> bool:
    """Whether the error is small enough; of this library, the drift too."""
    if side in (OURS, SIMULATE) and reached.drift > DRIFT:
        return False
    return reached.error <= asked
