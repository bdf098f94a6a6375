"""Closure with its evidence: all coordinates, rates and accelerations from the active ones."""

from __future__ import annotations

from typing import Any

from ..algebra.scalar import Scalar, absolute
from ..closure.closed_motion import ClosedMotion
from ..closure.constraints.equations import OPEN
from ..kernels.trace import Check, Results
from .following import Step
from .model import AT_STATE, Inputs, Model, Program
from .outcome import Outcome, OutcomeKind


def closed_motion(model: Model, x: Inputs) -> tuple[ClosedMotion, list[Check], list[Scalar]]:
    """Close the loops.

    Returns:
        The closed motion, its checks, and the distance of each block to a singularity.
    """
    step = Step(model, x) if x.start else None
    guess = x.guess
    if step is not None and not guess:
        guess = step.guess
    motion = ClosedMotion(model.tree, model.plan, x.u, x.branch, guess)
    distances = motion.distances()
    checks: list[Check] = []
    for k, block in enumerate(motion.blocks):
        checks.append(Check(block.margin, 0.0, unreachable(k)))
        singular = Outcome(OutcomeKind.SINGULAR, k).encode()
        checks.append(Check(block.excess(model.tree, model.singular), 0.0, singular))
    half_turn = unreachable(len(distances))
    checks += [Check(guard, 0.0, half_turn) for guard in motion.guards]
    inconsistent = unreachable(len(distances) + 1)
    checks += [Check(OPEN - absolute(residual), 0.0, inconsistent) for residual in motion.surplus]
    if step is not None:
        checks += step.checks(motion)
    return motion, checks, distances


def unreachable(block: int) -> int:
    """Status code of a state in which a block cannot close."""
    return Outcome(OutcomeKind.UNREACHABLE, block).encode()


def closed_outputs(
    motion: ClosedMotion, n: int, ds: list[Scalar], distances: list[Scalar]
) -> dict[str, Any]:
    """The outputs from which a `ClosedState` is built.

    Args:
        motion: the closed motion.
        n: number of active coordinates.
        ds: s' (n_s,).
        distances: distances of the blocks to a singularity.
    """
    return {
        "s": motion.configuration.q,
        "ds": ds,
        "R": motion.velocity_map(),
        "bias": motion.accelerations([0.0] * n, ds),
        "residuals": motion.residuals,
        "distances": distances,
    }


def _close(model: Model, x: Inputs) -> Results:
    """All coordinates, their rates, R, R' u', and the evidence."""
    motion, checks, distances = closed_motion(model, x)
    ds = motion.rates(x.du)
    outputs = closed_outputs(motion, len(x.u), ds, distances)
    return Results({**outputs, "iterations": [motion.iterations()]}, checks)


def _motion(model: Model, x: Inputs) -> Results:
    """All coordinates and their rates."""
    motion, checks, _ = closed_motion(model, x)
    outputs = {"s": motion.configuration.q, "ds": motion.rates(x.du)}
    return Results(outputs, checks)


def _accelerations(model: Model, x: Inputs) -> Results:
    """s'' of all coordinates."""
    motion, checks, _ = closed_motion(model, x)
    ds = motion.rates(x.du)
    return Results({"dds": motion.accelerations(x.ddu, ds)}, checks)


CLOSE = Program(AT_STATE, _close)
MOTION = Program(AT_STATE, _motion)
ACCELERATIONS = Program(("u", "du", "ddu", "branch", "guess"), _accelerations)
