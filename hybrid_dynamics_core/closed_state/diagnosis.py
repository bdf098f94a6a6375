"""From the status of a refused state to an error that names the loop, the value and the allowed range."""

from __future__ import annotations

import numpy as np

from ..closure.blocks.block_solver import Step
from ..closure.blocks.newton import NewtonStep
from ..closure.plan import given_configuration
from ..closure.toggle_range import allowed_range
from ..errors import ClosureError, HybridDynamicsError, InputError, SingularityError, StateError
from ..ground.arrays import Array
from ..kernels.run import Codes
from ..kernels.status import JUMP, NOT_FINITE
from ..mechanism.configuration import Configuration
from ..programs import Model, closure_code

EDGE = 1e-9  # a value this near the end of its range counts as being at it


def refuse(model: Model, u: Array, signs: Array, codes: Codes, distances: Array) -> None:
    """Raise for the first of the states u (n,) or (N, n) whose status is not 0; distances are (..., steps)."""
    if not codes.any():
        return
    row = None if u.ndim == 1 else int(np.flatnonzero(codes)[0])
    u, code, near = (u, codes, distances) if row is None else (u[row], codes[row], distances[row])
    step = (int(code) - 1) // 2
    distance = float(near[step]) if 0 <= step < len(near) else 0.0
    raise refusal(model, u, signs, int(code), distance, row)


def refusal(
    model: Model, u: Array, signs: Array, code: int, distance: float, index: int | None
) -> HybridDynamicsError:
    """The error for one state u (n,) whose status is `code`."""
    if code == JUMP:
        return _jump(model, index)
    if code == NOT_FINITE:
        return InputError("the result is not finite: the input is too large to compute with")
    return _not_closed(model, u, signs, code, distance, index)


def _not_closed(
    model: Model, u: Array, signs: Array, code: int, distance: float, index: int | None
) -> StateError:
    """The error for a status that the closure kernel gives."""
    k = (code - 1) // 2
    steps = model.plan.steps
    if k > len(steps):
        names = "+".join(dict.fromkeys(e.loop.name for e in model.plan.redundant))
        problem = (
            "closes at the reference but not here: it has more equations than it can meet in motion"
        )
        return ClosureError(f"loop '{names}' {problem}", loop=names, index=index)
    if k == len(steps):
        problem = (
            "the loops close only with a frame turned half round; the configuration belongs to no"
            " assembly"
        )
        return ClosureError(problem, loop=steps[-1].name, index=index)
    if code != closure_code(k):
        return _singular(steps[k].name, distance, index)
    configuration = given_configuration(
        model.tree, dict(zip(model.plan.given, u.tolist(), strict=True))
    )
    guess = model.plan.reference.q
    for earlier, sign in zip(steps[:k], signs[:k], strict=True):
        earlier.solve(configuration, float(sign), guess)
    return _open(model, steps[k], configuration, index)


def _singular(loop: str, distance: float, index: int | None) -> SingularityError:
    return SingularityError(
        f"loop '{loop}' is singular here (distance {distance:.2g} of at most 1): rates and forces"
        " have no finite answer; move away from this place",
        loop=loop,
        distance=distance,
        index=index,
    )


def _open(model: Model, step: Step, configuration: Configuration, index: int | None) -> StateError:
    names = model.tree.coordinates
    known = step.known
    told = {c: f"{names[c]} = {configuration.q[c] + 0.0:.9g} {model.tree.unit(c)}" for c in known}
    values = ", ".join(told.values())
    if isinstance(step, NewtonStep):  # an iteration knows no range
        problem = (
            f"loop '{step.name}' cannot close at {values}: no closed configuration was found on the"
            " way there"
        )
        return ClosureError(problem, loop=step.name, index=index)
    for coordinate in (c for c in known if c in model.plan.given):
        value = float(configuration.q[coordinate])
        near = float(model.plan.reference.q[coordinate])
        allowed = allowed_range(model.tree, step, configuration, coordinate, near)
        if allowed is None:
            continue
        if (
            allowed[0] - EDGE < value < allowed[1] + EDGE
        ):  # closes on both sides: two modes meet here
            return _singular(step.name, 0.0, index)
        unit = model.tree.unit(coordinate)
        others = ", ".join(text for c, text in told.items() if c != coordinate)
        return ClosureError(
            f"loop '{step.name}' cannot close: {names[coordinate]} = {value:.9g} {unit} is"
            " outside of "
            f"[{allowed[0]:.9g}, {allowed[1]:.9g}] {unit}, where the loop"
            f" closes{f' (at {others})' if others else ''}"
            f"{_narrower(model, coordinate, allowed, unit)}",
            loop=step.name,
            coordinate=names[coordinate],
            value=value,
            allowed=allowed,
            index=index,
        )
    problem = f"loop '{step.name}' cannot close at {values}: its links do not reach each other"
    return ClosureError(problem, loop=step.name, index=index)


def _narrower(model: Model, coordinate: int, closes: tuple[float, float], unit: str) -> str:
    """The limits of a coordinate, where they leave less than the loop does."""
    lower, upper = next(body.limits for body in model.tree.bodies if body.coordinate == coordinate)
    if lower <= closes[0] and upper >= closes[1]:
        return ""
    return f"; the limits of {model.tree.coordinates[coordinate]} are [{lower:g}, {upper:g}] {unit}"


def _jump(model: Model, index: int | None) -> SingularityError:
    """The error for a motion that has no smooth way on."""
    names = "+".join(dict.fromkeys(name for step in model.plan.steps for name in step.loops))
    return SingularityError(
        "the way there leaves this assembly mode: it meets a toggle or change point, or would have"
        " to jump to another mode; take another way, or start from a state on the wanted mode",
        loop=names,
        distance=0.0,
        index=index,
    )
