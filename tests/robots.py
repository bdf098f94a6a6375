"""Robots and states for laws: the shipped robots, and small mechanisms of each kind."""

from __future__ import annotations

import os
from functools import cache

import numpy as np

from hybrid_dynamics_core import ClosedState, ClosureStatus, Robot, load, shipped_robots
from hybrid_dynamics_core.kernels.run import VARIABLE
from tests.mechanisms import MECHANISMS, mechanism, with_masses

ROBOTS = (*shipped_robots(), *MECHANISMS)
REACH = 0.25  # [rad or m] about the reference, where a coordinate has no limits
REGULAR = 0.02  # distance to a singularity below which rounding is no longer what a law is about


def robot(name: str) -> Robot:
    """A shipped robot or a mechanism; one that comes without masses gets some."""
    return robot_of(name, backend())


def backend() -> str:
    """What robots made now compute with: those of one backend are not for tests of another."""
    return os.environ.get(VARIABLE, "")


@cache
def robot_of(name: str, _backend: str) -> Robot:
    """The same for tests of a backend."""
    machine = made(name)
    if any(link.mass for link in machine.description.links.values()):
        return machine
    return with_masses(machine)


def made(name: str) -> Robot:
    """A new shipped robot or mechanism, with the masses that it comes with."""
    if name in MECHANISMS:
        return Robot(mechanism(name).description)
    return load(name)


def random_states(
    name: str, count: int = 4, seed: int = 0, regular: float = REGULAR
) -> tuple[ClosedState, ...]:
    """Closed states with random rates up to 1 rad/s or m/s, away from singularities."""
    return _random_states(name, count, seed, regular, backend())


@cache
def _random_states(
    name: str, count: int, seed: int, regular: float, _backend: str
) -> tuple[ClosedState, ...]:
    machine = robot(name)
    rng = np.random.default_rng(seed)
    n = len(machine.active)
    reach = REACH
    states = []
    for _ in range(40 * count):
        lower = np.maximum(machine.limits[:, 0], machine.reference - reach)
        upper = np.minimum(machine.limits[:, 1], machine.reference + reach)
        u = lower + rng.uniform(0.05, 0.95, n) * (upper - lower)
        state = machine.close(u, rng.uniform(-1.0, 1.0, n), check=False)
        if state.status is ClosureStatus.OK and float(state.singularity) > regular:
            states.append(state)
        else:
            reach *= 0.7
        if len(states) == count:
            return tuple(states)
    raise AssertionError(f"{name}: only {len(states)} of {count} random states close")


def random_vector(machine: Robot, seed: int, size: float = 1.0) -> np.ndarray:
    """A vector (n,) of accelerations or efforts."""
    return np.random.default_rng(1000 + seed).uniform(-size, size, len(machine.active))


def scaled(error: np.ndarray, *scales: np.ndarray) -> float:
    """Largest error relative to the largest of the terms that make the value up."""
    worst = float(np.abs(error).max(initial=0.0))
    if not worst:
        return 0.0
    return worst / max(float(np.abs(scale).max()) for scale in scales)
