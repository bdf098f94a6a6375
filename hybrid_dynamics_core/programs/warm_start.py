"""Programs along a motion: each state starts from the previous one, and outputs the next start."""

from __future__ import annotations

from ..algebra.scalar import Scalar
from ..kernels.trace import Results
from .closure import closed_motion
from .model import FROM_START, Inputs, Model, Program


def warm_started(program: Program) -> Program:
    """A program that starts from a nearby closed configuration, and also outputs its own.

    Args:
        program: a program with the input `guess`.

    Returns:
        The program with `start` and `start_map` in place of the guess, and as further outputs.
    """

    def run(model: Model, x: Inputs) -> Results:
        results = program.run(model, x)
        following = next_start(model, x)
        outputs = {**results.outputs, **following.outputs}
        return Results(outputs, results.checks, results.rewritable, results.kept)

    return Program(program.from_start().inputs, run, program.sizes)


def next_start(model: Model, x: Inputs) -> Results:
    """The start of the next state of a motion: all coordinates, and R row by row."""
    motion, checks, _ = closed_motion(model, x)
    start_map: list[Scalar] = []
    for row in motion.velocity_map():
        start_map += row
    return Results({"start": motion.configuration.q, "start_map": start_map}, checks)


def _place(model: Model, x: Inputs) -> Results:
    """All coordinates, and their changes to the next state by R."""
    motion, checks, _ = closed_motion(model, x)
    forecast = motion.rates(x.move_after)
    return Results({"place": motion.configuration.q, "forecast": forecast}, checks)


PLACE = Program(("u", "branch", *FROM_START, "move_after"), _place)
STEP = Program(("u", "branch", *FROM_START), next_start)
