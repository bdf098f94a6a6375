"""Every engine on a problem: a number of steps goes in; error, drift and time come out."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from .catalogue import Problem, error
from .exported import Exported
from .peers.model import model_of
from .solve import TOLERANCES, Solver

USUAL = 1e-9  # relative tolerance of `simulate`
STEPS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)  # between two output steps
OURS = "C export, RK4"
SIMULATE = "`simulate`"
PEERS = ("exudyn", "mujoco", "pinocchio", "drake")
SIDES = (OURS, SIMULATE, *PEERS)


class Reached(NamedTuple):
    """One run of one engine.

    Attributes:
        error: relative, as the problem measures it.
        drift: of the energy [J]; NaN where it is not at hand.
        seconds: CPU time of the motion alone.
    """

    error: float
    drift: float
    seconds: float


Run = Callable[[float], Reached]


def settings_of(side: str) -> tuple[float, ...]:
    """From coarse to fine: relative tolerances for `simulate`, steps for all others."""
    if side == SIMULATE:
        return TOLERANCES
    return STEPS


def opened(side: str, problem: Problem) -> Run:
    """The problem, read and compiled for a side.

    Raises:
        ImportError: the engine is not installed.
        OSError: there is no C compiler.
    """
    if side == SIMULATE:
        return _simulate(Solver(problem))
    if side == OURS:
        return _exported(Solver(problem))
    return _peer(side, problem)


def _simulate(solver: Solver) -> Run:
    solver.run(USUAL)  # compiles
    solver.prepare()

    def run(tolerance: float) -> Reached:
        answer = solver.answer(tolerance)
        return Reached(answer.reached, answer.drift, answer.seconds)

    return run


def _exported(solver: Solver) -> Run:
    exported = Exported(solver)
    solver.prepare()
    problem = solver.problem
    loses = bool(solver.robot.loads.effects.viscous.any())

    def run(inner: float) -> Reached:
        seconds, rows = exported.rows(int(inner))
        states = exported.states(rows)
        observed = problem.observed.of_states(solver.robot, states)
        reached = error(observed, solver.reference)
        drift = float("nan")
        if not loses:
            done = (states.u - states.u[0]) @ np.array(problem.tau or np.zeros(states.u.shape[1]))
            energy = solver.robot.energy(states).total - done
            drift = float(np.abs(energy - energy[0]).max())
        return Reached(reached, drift, seconds)

    return run


def _peer(name: str, problem: Problem) -> Run:
    peer = importlib.import_module(f"benchmarks.problems.peers.{name}")
    model = model_of(problem)
    times = np.linspace(0.0, problem.end, problem.samples + 1)
    reference = problem.reference(times)

    def run(inner: float) -> Reached:
        seconds, rows = peer.Engine(model, int(inner)).run()
        return Reached(error(rows, reference), float("nan"), seconds)

    return run
