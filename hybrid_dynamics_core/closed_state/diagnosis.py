"""The error for a state that failed: its loop, the value, and the range of that value."""

from __future__ import annotations

import numpy as np

from ..closure.blocks.block_solver import BlockSolver
from ..closure.closed_motion import ClosedMotion
from ..closure.constraints.equations import OPEN
from ..closure.limit_range import limited_range
from ..closure.toggle_range import closing_interval, given_inputs
from ..errors import ClosureError, HybridDynamicsError, InputError, SingularityError, StateError
from ..ground.arrays import Array
from ..ground.wording import singular_or_plural
from ..kernels.run import Codes
from ..programs import Model, Outcome, OutcomeKind

# [rad or m] a value this near the end of its range counts as being at it
EDGE = 1e-9


def raise_for_status(
    model: Model,
    u: Array,
    signs: Array,
    codes: Codes,
    distances: Array,
) -> None:
    """Raise the error of the first state that failed; return if all are closed.

    Args:
        model: tree and closure plan.
        u: given coordinates (n,) or (N, n) [rad, m].
        signs: branch signs (blocks,) or (N, blocks).
        codes: status codes () or (N,).
        distances: distances to a singularity (blocks,) or (N, blocks).

    Raises:
        ClosureError: a loop cannot close.
        SingularityError: a loop is singular, or the motion leaves its assembly mode.
        InputError: the result is not finite.
    """
    if not codes.any():
        return
    index = None
    if u.ndim == 2:
        index = int(np.flatnonzero(codes)[0])
        u, codes, distances = u[index], codes[index], distances[index]
        if signs.ndim == 2:
            signs = signs[index]
    outcome = Outcome.decode(int(codes))
    distance = 0.0
    if 0 <= outcome.block < len(distances):
        distance = float(distances[outcome.block])
    raise error_for(outcome, model, u, signs, distance, index)


def error_for(
    outcome: Outcome,
    model: Model,
    u: Array,
    signs: Array,
    distance: float = 0.0,
    index: int | None = None,
) -> HybridDynamicsError:
    """The error for one state.

    Args:
        outcome: status of the state.
        model: tree and closure plan.
        u: given coordinates (n,) [rad, m].
        signs: branch signs (blocks,).
        distance: distance of the block to a singularity, from 0 to 1.
        index: row of the state in its batch, None for a single state.

    Returns:
        The error, to be raised by the caller.
    """
    if outcome.kind is OutcomeKind.JUMP:
        return _jump(model, index)
    if outcome.kind is OutcomeKind.NOT_FINITE:
        return InputError("the result is not finite: the input is too large to compute with")
    blocks = model.plan.blocks
    if outcome.block > len(blocks):
        return _inconsistent(model, u, signs, index)
    if outcome.block == len(blocks):
        return _half_turn(blocks[-1], index)
    block = blocks[outcome.block]
    if outcome.kind is OutcomeKind.SINGULAR:
        return _singular(block.name, distance, index)
    return _unreachable(model, block, u, signs, index)


def _inconsistent(model: Model, u: Array, signs: Array, index: int | None) -> ClosureError:
    """The error for redundant equations that do not hold away from the reference."""
    loops = [equation.loop.name for equation in model.plan.redundant]
    names = "+".join(dict.fromkeys(loops))
    problem = (
        "closes at the reference but not here: it has more equations than it can meet in motion"
        f"{_misfit(model, u, signs)}"
    )
    return ClosureError(f"loop '{names}' {problem}", loop=names, index=index)


def _misfit(model: Model, u: Array, signs: Array) -> str:
    """The largest residual of the redundant equations, as text; empty after an iteration."""
    plan = model.plan
    if any(block.iterates for block in plan.blocks):
        return ""
    motion = ClosedMotion(model.tree, plan, u.tolist(), signs.tolist(), plan.reference.q)
    sizes = [abs(float(residual)) for residual in motion.surplus]
    worst = max(range(len(sizes)), key=sizes.__getitem__)
    loop = plan.redundant[worst].loop
    share = f"{sizes[worst]:.2g} of its length; {OPEN:g} is allowed"
    size = f"{sizes[worst] * loop.length:.3g} m"
    return f"; '{loop.name}' misses by {size} ({share}): take another mode, or mend its lengths"


def _half_turn(last: BlockSolver, index: int | None) -> ClosureError:
    """The error for equations that hold only with one frame turned by half a turn."""
    problem = (
        "the loops close only with a frame turned half round; the configuration belongs to no"
        " assembly"
    )
    return ClosureError(problem, loop=last.name, index=index)


def _singular(loop: str, distance: float, index: int | None) -> SingularityError:
    problem = (
        f"loop '{loop}' is singular here (distance {distance:.2g} of at most 1): rates and forces"
        " have no finite answer; move away from this place"
    )
    return SingularityError(problem, loop=loop, distance=distance, index=index)


def _jump(model: Model, index: int | None) -> SingularityError:
    """The error for a motion that cannot be continued without a jump."""
    loops: list[str] = []
    for block in model.plan.blocks:
        loops += block.loops
    names = "+".join(dict.fromkeys(loops))
    problem = (
        "the way there leaves this assembly mode: it meets a toggle or change point, or would have"
        " to jump to another mode; take another way, or start from a state on the wanted mode"
    )
    return SingularityError(problem, loop=names, distance=0.0, index=index)


def _unreachable(
    model: Model, block: BlockSolver, u: Array, signs: Array, index: int | None
) -> StateError:
    """The error for a block that cannot close at the coordinates it depends on."""
    inputs = given_inputs(model.plan, block)
    values = dict(zip(model.plan.given, u.tolist(), strict=True))
    texts = {k: _value_text(model, k, values[k]) for k in inputs}
    place = ", ".join(texts.values())
    # an iteration gives no range of values
    if block.iterates:
        problem = (
            f"loop '{block.name}' cannot close at {place}: no closed configuration was found on the"
            f" way there{_surplus_text(block)}"
        )
        return ClosureError(problem, loop=block.name, index=index)
    for k in inputs:
        allowed = closing_interval(model.tree, model.plan, u.tolist(), signs.tolist(), k)
        if allowed is not None:
            others = [texts[other] for other in inputs if other != k]
            return _out_of_range(model, block, (k, values[k]), others, allowed, index)
    problem = f"loop '{block.name}' cannot close at {place}: its links do not reach each other"
    return ClosureError(problem, loop=block.name, index=index)


def _surplus_text(block: BlockSolver) -> str:
    """A remark on loops that have more equations than unknowns; empty for others."""
    surplus = len(block.equations) - len(block.unknowns)
    if surplus == 0:
        return ""
    return (
        f"; it has {surplus} more {singular_or_plural(surplus, 'equation', 'equations')} than"
        " unknowns, and if they miss in motion, its lengths and axes have to be mended"
    )


def _value_text(model: Model, coordinate: int, value: float) -> str:
    # without a negative zero
    number = f"{value + 0.0:.9g}"
    return f"{model.tree.coordinates[coordinate]} = {number} {model.tree.unit(coordinate)}"


def _out_of_range(
    model: Model,
    block: BlockSolver,
    moved: tuple[int, float],
    others: list[str],
    allowed: tuple[float, float],
    index: int | None,
) -> StateError:
    """The error for a coordinate outside of the range in which the mechanism closes.

    Args:
        model: tree and closure plan.
        block: the block that does not close.
        moved: the coordinate, and its value [rad or m].
        others: the other given coordinates that the block depends on, as text.
        allowed: the range [rad or m].
        index: row of the state in its batch.
    """
    coordinate, value = moved
    lower, upper = allowed
    # the loop closes on both sides of the value: two modes meet at it
    if lower - EDGE < value < upper + EDGE:
        return _singular(block.name, 0.0, index)
    name, unit = model.tree.coordinates[coordinate], model.tree.unit(coordinate)
    condition = ""
    if others:
        condition = f" (at {', '.join(others)})"
    problem = (
        f"loop '{block.name}' cannot close: {name} = {value:.9g} {unit} is outside of "
        f"[{lower:.9g}, {upper:.9g}] {unit}, where the loop closes{condition}"
        f"{_narrower_limits(model, coordinate, allowed)}"
    )
    return ClosureError(
        problem, loop=block.name, coordinate=name, value=value, allowed=allowed, index=index
    )


def _narrower_limits(
    model: Model,
    coordinate: int,
    allowed: tuple[float, float],
) -> str:
    """The limits of a coordinate, if they are narrower than the range in which the loop closes.

    Joints that follow this coordinate alone narrow its limits by theirs.
    """
    tree = model.tree
    lower, upper = next(body.limits for body in tree.bodies if body.coordinate == coordinate)
    least, most = limited_range(tree, model.plan, coordinate)
    lower, upper = max(lower, least), min(upper, most)
    if lower <= allowed[0] and upper >= allowed[1]:
        return ""
    name, unit = tree.coordinates[coordinate], tree.unit(coordinate)
    return f"; the limits of {name} are [{lower:g}, {upper:g}] {unit}"
