"""States of a robot with the library's results, which a build of the C code is checked against."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ...closed_state.state import ClosedState
from ...errors import MassSingularityError
from ...ground.arrays import Array
from ...programs import OutcomeKind
from ...robot.robot import Robot
from .answers import answers, random_arguments
from .calls import GUESS
from .tracer import TracedFunction

REACH = 0.03  # [rad or m] longest step of the walk; it is halved where states do not close
REGULAR = 0.02  # least distance to a singularity
STEP = 1e-3  # [rad or m] longest move from the guess
ATTEMPTS = 4  # for each state


@dataclass(frozen=True)
class Vector:
    """Arguments and results of a C function.

    Attributes:
        inputs: those of the call, then the guess.
        outputs: results of the call, then the configuration.
        status: the public status; outputs are zero where it is not 0.
    """

    inputs: Array
    outputs: Array
    status: int


def random_states(
    robot: Robot, count: int, rng: np.random.Generator
) -> Iterator[tuple[Array, ClosedState]]:
    """Guesses (n_s,), and closed states near them, on a walk from the reference.

    Each state is followed from the one before. A state far off may be on no assembly mode, and to
    find that out takes a search.
    """
    n = len(robot.active)
    lower, upper = robot.limits.T
    reference = robot.close(robot.reference)
    here, reach, made = reference, REACH, 0
    for _ in range(ATTEMPTS * count):
        u = here.u + reach * rng.uniform(-1.0, 1.0, n)
        near = robot.close(np.clip(u, lower, upper), near=here, check=False)
        if near.status or not near.singularity > REGULAR:
            here, reach = reference, 0.5 * reach
            continue
        du = rng.uniform(-1.0, 1.0, n)
        state = robot.close(near.u + STEP * rng.uniform(-1.0, 1.0, n), du, near=near, check=False)
        if state.status:
            continue
        yield near.s, state
        here = near
        made += 1
        if made == count:
            return


def vectors(robot: Robot, traced: Sequence[TracedFunction], count: int) -> dict[str, list[Vector]]:
    """Arguments and results by name of the call, in random states, or at the reference."""
    rng = np.random.default_rng(0)
    states = list(random_states(robot, count, rng))
    if not states:
        reference = robot.close(robot.reference)
        states = [(reference.s, reference)]
    return {one.call.name: _vectors_of(robot, one, states, rng) for one in traced}


def _vectors_of(
    robot: Robot,
    traced: TracedFunction,
    states: Sequence[tuple[Array, ClosedState]],
    rng: np.random.Generator,
) -> list[Vector]:
    result = []
    loaded = "payload" in traced.inputs
    for guess, state in states:
        arguments = random_arguments(robot, state, rng)
        arguments[GUESS] = guess
        inputs = np.concatenate([arguments[name] for name in (*traced.inputs, GUESS)])
        try:
            outputs = answers(robot, traced.call.name, state, arguments, loaded)
            ordered = [np.ravel(outputs[name]) for name in traced.results]
            result.append(Vector(inputs, np.concatenate([*ordered, state.s]), 0))
        except MassSingularityError:
            nothing = np.zeros(traced.total + len(state.s))
            result.append(Vector(inputs, nothing, int(OutcomeKind.MASS_SINGULAR)))
    return result
