"""From the status of a refused state to an error that names the loop, the value and the allowed range."""

from __future__ import annotations

import math

from .closure.plan import given_posture
from .closure.reach import allowed_range
from .description.model import Array
from .errors import ClosureError, SingularityError, StateError
from .programs import Model, closure_code


def refusal(model: Model, u: Array, signs: Array, code: int, distance: float, index: int | None) -> StateError:
    """The error for one state u (n,) whose kernel status is `code`."""
    k = (code - 1) // 2
    step = model.plan.steps[k]
    if code != closure_code(k):
        return SingularityError(
            f"loop '{step.loop}' is singular here (distance {distance:.2g} of at most 1): its cylinder or bars are in line, "
            "so rates and forces have no finite answer; move away from this place",
            loop=step.loop,
            distance=distance,
            index=index,
        )
    names = model.tree.coordinates
    posture = given_posture(model.tree, u.tolist())
    for earlier, sign in zip(model.plan.steps[:k], signs[:k], strict=True):
        earlier.solve(posture, float(sign))
    given = [j.coordinate for j in step.geometry.joints if j.coordinate < len(u)]
    others = [
        j.coordinate for j in step.geometry.joints if j.coordinate >= len(u) and j.coordinate not in step.unknowns
    ]
    for coordinate in given:
        value = float(u[coordinate])
        allowed = allowed_range(step, step.geometry, posture, coordinate, model.plan.reference.q[coordinate])
        if allowed is None or (math.isinf(allowed[0]) and math.isinf(allowed[1])):
            continue
        unit = "rad" if next(b.type for b in model.tree.bodies if b.coordinate == coordinate) == "revolute" else "m"
        here = (
            f" with {', '.join(names[i] for i in given + others if i != coordinate)} as given"
            if len(given + others) > 1
            else ""
        )
        return ClosureError(
            f"loop '{step.loop}' cannot close: {names[coordinate]} = {value:.9g} {unit} is outside "
            f"[{allowed[0]:.9g}, {allowed[1]:.9g}] {unit}{here}",
            loop=step.loop,
            coordinate=names[coordinate],
            value=value,
            allowed=allowed,
            index=index,
        )
    values = ", ".join(f"{names[i]} = {posture.q[i]:.9g}" for i in given + others)
    return ClosureError(
        f"loop '{step.loop}' cannot close at {values}: its links do not reach each other", loop=step.loop, index=index
    )
