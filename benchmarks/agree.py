"""Whether all sides give the same numbers, before any of them is timed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from hybrid_dynamics_core import Robot

from .side import Side

STATES = 20  # one by one
BATCH = 2000  # some sides take full thousands


class DisagreementError(RuntimeError):
    """Two sides give different numbers for the same work."""


def random_states(robot: Robot, count: int, seed: int = 0) -> dict[str, np.ndarray]:
    """u over most of the limits, and rates, accelerations and efforts, each (count, 4)."""
    rng = np.random.default_rng(seed)
    limits = np.where(np.isfinite(robot.limits), robot.limits, [-2.0, 2.0])
    width = limits[:, 1] - limits[:, 0]
    u = limits[:, 0] + width * rng.uniform(0.15, 0.85, (count, len(limits)))
    du, ddu = rng.uniform(-1.0, 1.0, (2, count, len(limits)))
    return {"u": u, "du": du, "ddu": ddu, "tau": rng.uniform(-1e3, 1e3, (count, len(limits)))}


def arguments(work: str, states: dict[str, np.ndarray]) -> tuple[Any, ...]:
    """What a work is called with: one state (4,), or all states of a batch (N, 4)."""
    u, du, ddu, tau = (states[name] for name in ("u", "du", "ddu", "tau"))
    return {
        "id": (u, du, ddu),
        "id_out": (u, du, ddu, np.empty_like(u)),
        "minimal": (u, du),
        "fd": (u, du, tau),
        "close": (u, du),
        "id_batch": (u, du, ddu),
    }[work]


def check(robot: Robot, sides: Sequence[Side], works: Sequence[str]) -> None:
    """Compare the answers of all sides.

    Raises:
        DisagreementError: a side differs from the first that does the same work.
    """
    states = random_states(robot, STATES)
    for work in works:
        able = [side for side in sides if work in side.calls]
        if work == "id_batch":
            _check_work(able, work, random_states(robot, BATCH))
            continue
        for k in range(STATES):
            state = {name: values[k] for name, values in states.items()}
            _check_work(able, work, state)


def _check_work(sides: Sequence[Side], work: str, states: dict[str, np.ndarray]) -> None:
    """Compare the answers of all sides to one call."""
    answers = [_flat(side.calls[work](*arguments(work, states))) for side in sides]
    for side, answer in zip(sides, answers, strict=True):
        scale = max(1.0, np.abs(answers[0]).max())
        error = np.abs(answer - answers[0]).max() / scale
        if not error < max(side.tolerance, sides[0].tolerance):
            raise DisagreementError(
                f"{side.name} differs from {sides[0].name} by {error:.1g} in {work}"
            )


def _flat(answer: Any) -> np.ndarray:
    """One vector; angles by their sine and cosine, so that full turns do not count."""
    if not isinstance(answer, tuple):
        return np.ravel(answer)
    if len(answer) == 2:
        s, ds = answer
        return np.concatenate([np.cos(s), np.sin(s), ds])
    return np.concatenate([np.ravel(part) for part in answer])
