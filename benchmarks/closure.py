"""Closures per second of every shipped robot, beside Newton on the same robot in Pinocchio.

python -m benchmarks.closure [robot ...]     (in the root of the repository)

All engines close the same states: small steps along a random motion inside the limits.
alone     robot.close(u), one state a call, without `near`
followed  robot.close(u, near=state), each state from the one before
batch     robot.close(u) of 2000 states at once, per state
Newton    Pinocchio's poses and Jacobians, NumPy's least squares, each state from the one before
Time is that of the process, the best of three rounds: other work on the machine hardly counts.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np

from hybrid_dynamics_core import Robot, load, shipped_robots
from tests.agreement.pinocchio_model import PinocchioRobot

STATES = 100
BATCH = 2000
ROUNDS = 3


def motion(robot: Robot) -> np.ndarray:
    """Active coordinates (STATES, n) of a smooth motion about the reference that closes."""
    rng = np.random.default_rng(1)
    limits = np.nan_to_num(robot.limits, posinf=1.0, neginf=-1.0)
    size = np.minimum(0.1, 0.1 * np.ptp(limits, axis=1))
    phase = np.linspace(0.0, 2.0 * np.pi, STATES)[:, None] + 0.3 * rng.uniform(size=len(size))
    for _ in range(8):
        u: np.ndarray = robot.reference + size * (np.sin(phase) - np.sin(phase[0]))
        if (np.asarray(robot.close(u, check=False).status) == 0).all():
            return u
        size = size / 2.0
    raise SystemExit(f"{robot.name}: no motion about the reference closes")


def rate(work: Callable[[], object], states: int) -> float:
    """States a second of process time, the best round."""
    work()
    best = np.inf
    for _ in range(ROUNDS):
        start = time.process_time()
        work()
        best = min(best, time.process_time() - start)
    return states / best


def measure(name: str) -> list[float]:
    """The four rates of a robot: alone, followed, batch, Newton."""
    robot = load(name)
    u = motion(robot)
    n = len(robot.active)
    home = robot.close(u[0])
    batch = np.resize(u, (BATCH, n))
    pinocchio = PinocchioRobot(robot.description, robot.coordinates)

    def followed() -> None:
        state = home
        for row in u:
            state = robot.close(row, near=state)

    def newton() -> np.ndarray:
        s = home.s
        for row in u:
            s = pinocchio.close(np.concatenate([row, s[n:]]), n)
        return s

    worst = float(np.abs(newton() - robot.close(u[-1]).s).max())
    if worst > 1e-8:
        raise SystemExit(
            f"{name}: Newton ends {worst:.2g} away; the engines do not do the same work"
        )
    return [
        rate(lambda: [robot.close(row) for row in u], STATES),
        rate(followed, STATES),
        rate(lambda: robot.close(batch), BATCH),
        rate(newton, STATES),
    ]


def main() -> None:
    """The table."""
    write = sys.stdout.write
    heads = f"{'alone':>10}{'followed':>10}{'batch':>12}{'Newton':>10}"
    write(f"{'closures per second':<20}{'joints':>8}{heads}\n")
    for name in sys.argv[1:] or shipped_robots():
        alone, followed, batch, newton = measure(name)
        rates = f"{alone:>10,.0f}{followed:>10,.0f}{batch:>12,.0f}{newton:>10,.0f}"
        write(f"{name:<20}{len(load(name).coordinates):>8}{rates}\n")


if __name__ == "__main__":
    main()
