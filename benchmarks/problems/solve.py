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
        reached: relative error.
        drift: largest change of the energy without the work done [J].
        seconds: CPU time of the run alone, without reading and compiling.
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
        begin = time.process_time()
        motion = self.run(tolerance)
        seconds = time.process_time() - begin
        values = self.problem.observed.of_states(self.robot, motion.state)
        reached = error(values, self.reference)
        drift = float(np.abs(motion.energy_error).max())
        return Answer(reached, drift, seconds, tolerance)

    def prepare(self) -> None:
        """Compute the reference, which may take longer than the motion."""
        self.reference.flags.writeable = False

    @cached_property
    def reference(self) -> Array:
        """Rows at the output steps."""
        problem = self.problem
        return problem.reference(np.linspace(0.0, problem.end, problem.samples + 1))
