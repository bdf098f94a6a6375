"""The time this library takes to the accuracy that is asked."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core.simulation import Settings, Simulation, simulate

from .catalogue import Problem, error

Array = NDArray[np.float64]
TOLERANCES = (1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11)


@dataclass(frozen=True)
class Answer:
    """What one engine reached on a problem.

    Attributes:
        reached: relative error; NaN without a reference.
        drift: largest change of the energy without the work done [J].
        seconds: of the run alone, without reading and compiling.
        setting: of the engine's accuracy.
    """

    reached: float
    drift: float
    seconds: float
    setting: float


class Solver:
    """A problem, read and compiled."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.robot = problem.robot()
        self.start = self.robot.close(self.robot.reference, problem.rates)

    def run(self, tolerance: float) -> Simulation:
        """The motion at a relative tolerance.

        Raises:
            RuntimeError: the motion ends early.
        """
        problem = self.problem
        settings = Settings(
            method=problem.method,
            rtol=tolerance,
            atol=0.01 * tolerance,
            rate=problem.samples / problem.end,
        )
        span = (0.0, problem.end)
        motion = simulate(self.robot, self.start, None, problem.tau, span, settings)
        if not motion.completed:
            raise RuntimeError(motion.message)
        return motion

    def answer(self, tolerance: float) -> Answer:
        """Error, drift and time at a relative tolerance."""
        begin = time.perf_counter()
        motion = self.run(tolerance)
        seconds = time.perf_counter() - begin
        reached = float("nan")
        if self.reference is not None:
            values = self.problem.measured(self.robot, motion)
            reached = error(values, self.reference)
        drift = float(np.abs(motion.energy_error).max())
        return Answer(reached, drift, seconds, tolerance)

    @cached_property
    def reference(self) -> Array | None:
        """Rows at the output steps, where there is a reference."""
        problem = self.problem
        if problem.reference is None:
            return None
        times = np.linspace(0.0, problem.end, problem.samples + 1)
        return problem.reference(times)

    def all_answers(self) -> list[Answer]:
        """The answers at all tolerances at which the motion comes to its end.

        Each is the second of two runs, so that all kernels are compiled.
        """
        answers = []
        for tolerance in TOLERANCES:
            try:
                self.run(tolerance)
            except RuntimeError:
                continue
            answers.append(self.answer(tolerance))
        return answers
