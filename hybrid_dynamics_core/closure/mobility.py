"""How many independent coordinates a mechanism has, for files that list motors.

A motor set may be short (a rod that turns about its own axis, a free foot) or redundant. Motors
that depend on the ones before them become passive. What the motors leave free becomes a further
independent coordinate, without effort.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..algebra.independence import independent_rows
from ..description.model import RobotDescription
from ..ground.arrays import Array
from ..mechanism.configuration import configuration_at
from ..mechanism.tree import Tree, build_tree
from .constraints.equations import LoopEquations
from .constraints.from_description import loop_equations
from .loop_gap import describe_gap
from .numeric_closure import CLOSED, close_numerically, gaps_and_jacobian

# share of a coordinate's motion that must not follow from the coordinates chosen before
INDEPENDENT = 1e-6
ZERO = 1e-8  # singular values below this share of the largest count as zero
# [rad or m] how far from a reference that does not close other starts are
DISTANCES = (0.3, 1.0)
STARTS = 6  # at each of these distances
TINY = 1e-300

Closed = tuple[Array, dict[str, float]]  # s (n_s,), and the residual of each loop


@dataclass(frozen=True)
class Mobility:
    """The independent coordinates of a mechanism.

    Attributes:
        active: all of them.
        idle: those among them that no motor drives.
        dependent: motors that follow from the others, hence passive.
        reference: the closed configuration at which this was read, by coordinate [rad or m].
    """

    active: tuple[str, ...]
    idle: tuple[str, ...]
    dependent: tuple[str, ...]
    reference: Mapping[str, float]


def find_mobility(tree: Tree, robot: RobotDescription) -> Mobility:
    """Read the mobility from the null space of J_s at a closed configuration near the reference.

    Args:
        tree: the spanning tree.
        robot: its description, whose active joints are motors.

    Raises:
        DescriptionError: a loop does not close, or nothing can move.
    """
    names = tree.coordinates
    start = [robot.reference.get(name, 0.0) for name in names]
    loops = loop_equations(tree, robot, frozenset(range(len(names))))
    passive = [k for k, name in enumerate(names) if name not in robot.active]
    s, residual = _closed(tree, loops, start, passive)
    _require_closed(tree, robot, s, residual)
    _, jacobian = gaps_and_jacobian(tree, loops, s, range(len(names)))
    motions = _null_space(jacobian)
    driven = (*robot.motors, *robot.actuators)
    order = _indices(names, (*driven, *robot.idle, *names))
    independent = independent_rows(motions, order, INDEPENDENT, passes=1)
    chosen = [names[k] for k in independent]
    if names and not chosen:
        raise robot.error(
            "active", "the loops hold every joint fast: nothing is left to move; mend the geometry"
        )
    motors = tuple(name for name in chosen if name in driven)
    idle = tuple(name for name in chosen if name not in driven)
    dependent = tuple(name for name in robot.motors if name not in motors)
    reference = dict(zip(names, s.tolist(), strict=True))
    return Mobility(motors + idle, idle, dependent, reference)


def with_mobility(robot: RobotDescription, mobility: Mobility) -> tuple[RobotDescription, Tree]:
    """The description with its independent coordinates as active ones, and its tree."""
    notes = (*robot.notes, *_beyond_limits(robot, mobility.reference))
    settled = replace(
        robot,
        active=mobility.active,
        idle=mobility.idle,
        reference=mobility.reference,
        notes=notes,
    )
    return settled, build_tree(settled)


def _indices(names: Sequence[str], preferred: Sequence[str]) -> list[int]:
    """Indices of names in an order of preference, each once."""
    return [names.index(name) for name in dict.fromkeys(preferred)]


def _require_closed(
    tree: Tree, robot: RobotDescription, s: Array, residual: Mapping[str, float]
) -> None:
    """Raise for the loop that is most open."""
    worst = max(residual, key=lambda name: residual[name], default="")
    if not worst or not residual[worst] > CLOSED:
        return
    gap = describe_gap(tree, robot, worst, configuration_at(tree, s))
    raise robot.error(
        robot.closure_key(worst),
        f"does not close: {gap} ({residual[worst]:.2g} of the loop's length) at best; mend the"
        " geometry",
    )


def _closed(
    tree: Tree, loops: Sequence[LoopEquations], start: Sequence[float], passive: Sequence[int]
) -> Closed:
    """A closed configuration: the reference, else one within the limits, else any.

    The least open one where none closes.
    """
    best = close_numerically(tree, loops, start, passive)
    if _is_closed(tree, loops, start):
        return best
    least = _merit(tree, *best)
    # all that no loop holds stays where the reference has it; redundant motors must give way
    held = sorted({k for loop in loops for k in loop.coordinates})
    other_starts = [np.asarray(start, dtype=float), *_other_starts(tree, start, held)]
    for other_start in other_starts:
        if least == 0.0:
            break
        other = close_numerically(tree, loops, other_start, held)
        merit = _merit(tree, *other)
        if merit < least:
            best = other
            least = merit
    return best


def _is_closed(tree: Tree, loops: Sequence[LoopEquations], s: Sequence[float]) -> bool:
    try:
        gaps, _ = gaps_and_jacobian(tree, loops, np.asarray(s), ())
    except ZeroDivisionError:  # frames half a turn apart
        return False
    return float(np.abs(gaps).max(initial=0.0)) <= CLOSED


def _merit(tree: Tree, s: Array, residual: Mapping[str, float]) -> float:
    """How good a configuration is, 0 at best.

    0 where the loops close within the limits, below 1 where they close, more the more they are
    open.
    """
    worst = max(residual.values(), default=0.0)
    if worst > CLOSED:
        return 1.0 + worst
    lower, upper = _limits(tree).T
    beyond = np.maximum(lower - s, s - upper).max(initial=0.0)
    if beyond <= CLOSED:
        return 0.0
    return float(beyond / (1.0 + beyond))


def _limits(tree: Tree) -> Array:
    """(n_s, 2) in the order of the coordinates."""
    bodies = sorted(tree.bodies, key=lambda body: body.coordinate)
    return np.array([body.limits for body in bodies])


def _other_starts(tree: Tree, start: Sequence[float], held: Sequence[int]) -> Iterator[Array]:
    """Configurations about the reference, always the same, where the file's neutral one is open.

    Only what the loops hold is moved, and not beyond its limits.
    """
    lower, upper = _limits(tree).T
    rng = np.random.default_rng(0)
    for size in np.repeat(DISTANCES, STARTS):
        moved = np.array(start, dtype=float)
        moved[held] += rng.uniform(-size, size, len(held))
        yield np.clip(moved, lower, upper)


def _beyond_limits(robot: RobotDescription, reference: Mapping[str, float]) -> Iterator[str]:
    """Notes of joints that a reference, which the file did not name, has beyond their limits."""
    for name, joint in robot.joints.items():
        value = reference[name]
        lower, upper = joint.limits
        if not lower - CLOSED <= value <= upper + CLOSED:
            yield (
                f"{name}: the loops close at {value:.6g}, outside its limits [{lower:.6g},"
                f" {upper:.6g}]; within all limits no closed configuration was found"
            )


def _null_space(jacobian: Array) -> Array:
    """Motions (n_s, mobility) that keep all loops closed."""
    if not len(jacobian):
        return np.eye(jacobian.shape[1])
    _, sizes, vectors = np.linalg.svd(jacobian)
    least = ZERO * max(float(sizes[0]), TINY)
    rank = np.count_nonzero(sizes > least)
    return vectors[rank:].T
