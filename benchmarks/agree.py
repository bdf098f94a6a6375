"""Whether all sides give the same numbers, before any of them is timed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from hybrid_dynamics_core import Robot

from .side import Side

STATES = 20  # one by one
MANY = 2000  # in a batch; some sides take whole thousands


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
    """What a work is called with: one state (4,) or, for a batch, all of them."""
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
    """Raise DisagreementError where a side differs from the first that does the same work."""
    states = random_states(robot, STATES)
    for work in works:
        able = [side for side in sides if work in side.calls]
        singles = [{k: v[i] for k, v in states.items()} for i in range(STATES)]
        rows = [random_states(robot, MANY)] if work == "id_batch" else singles
        for row in rows:
            answers = [_flat(side.calls[work](*arguments(work, row))) for side in able]
            for side, answer in zip(able, answers, strict=True):
                error = np.abs(answer - answers[0]).max() / max(1.0, np.abs(answers[0]).max())
                if not error < max(side.tolerance, able[0].tolerance):
                    raise DisagreementError(
                        f"{side.name} differs from {able[0].name} by {error:.1g} in {work}"
                    )


def _flat(answer: Any) -> np.ndarray:
    """One vector; angles by their sine and cosine, so that whole turns do not count."""
    if isinstance(answer, tuple) and len(answer) == 2:
        s, ds = answer
        return np.concatenate([np.cos(s), np.sin(s), ds])
    return np.concatenate(
        [np.ravel(part) for part in (answer if isinstance(answer, tuple) else (answer,))]
    )
