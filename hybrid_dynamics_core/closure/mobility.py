"""How many independent coordinates a mechanism has, and which: for files that list motors, not coordinates.

A motor set may be short (a rod that turns about its own axis, a free foot) or redundant. Motors
that depend on the ones before them become passive; what the motors leave free becomes a further
independent coordinate, without effort.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..description.model import RobotDescription
from ..ground.arrays import Array
from ..mechanism.configuration import configuration_at
from ..mechanism.tree import Tree, build_tree
from .constraints.equations import LoopEquations
from .constraints.from_description import loop_equations
from .loop_gap import gap_of
from .rank import CLOSED, close_numerically, jacobian_of

INDEPENDENT = (
    1e-6  # share of a coordinate's motion that must not follow from the coordinates chosen before
)
SPREADS = (0.3, 1.0)  # [rad or m] how far from a reference that does not close others are tried


@dataclass(frozen=True)
class Mobility:
    """`active`: independent coordinates; `idle`: those among them that no motor drives; `dependent`: passive motors."""

    active: tuple[str, ...]
    idle: tuple[str, ...]
    dependent: tuple[str, ...]
    reference: Mapping[str, float]  # the closed configuration at which it was read


def find_mobility(tree: Tree, robot: RobotDescription) -> Mobility:
    """Read the mobility from the null space of J_s at a closed configuration near the reference."""
    names = tree.coordinates
    start = [robot.reference.get(name, 0.0) for name in names]
    loops = loop_equations(tree, robot, frozenset(range(len(names))))
    passive = [k for k, name in enumerate(names) if name not in robot.active]
    s, residual = _closed(tree, loops, start, passive)
    worst = max(residual, key=lambda name: residual[name], default="")
    if worst and residual[worst] > CLOSED:
        raise robot.error(
            robot.closure_key(worst),
            f"does not close: {gap_of(tree, robot, worst, configuration_at(tree, s))} "
            f"({residual[worst]:.2g} of the loop's length) at best; mend the geometry",
        )
    motions = _null_space(jacobian_of(tree, loops, s, range(len(names)))[1])
    order = [names.index(name) for name in robot.active] + passive
    chosen = _independent(motions, order)
    if names and not chosen:
        raise robot.error(
            "active", "the loops hold every joint fast: nothing is left to move; mend the geometry"
        )
    motors = tuple(names[k] for k in chosen if names[k] in robot.active)
    idle = tuple(names[k] for k in chosen if names[k] not in robot.active)
    dependent = tuple(name for name in robot.active if name not in motors)
    return Mobility(motors + idle, idle, dependent, dict(zip(names, s.tolist(), strict=True)))


def _closed(
    tree: Tree, loops: Sequence[LoopEquations], start: Sequence[float], passive: Sequence[int]
) -> tuple[Array, dict[str, float]]:
    """The reference if it closes, else a closed configuration within the limits if one is found, else a closed one.

    The least open one where none closes.
    """
    found = close_numerically(tree, loops, start, passive)
    best = 0.0 if _is_closed(tree, loops, start) else _merit(tree, *found)
    held = sorted(
        {k for loop in loops for k in loop.coordinates}
    )  # all else stays where the reference has it
    for begin in (np.asarray(start, dtype=float), *_other_starts(start, held, _limits(tree))):
        if best == 0.0:
            break
        other = close_numerically(tree, loops, begin, held)  # redundant motors must give way
        merit = _merit(tree, *other)
        if merit < best:
            found, best = other, merit
    return found


def _is_closed(tree: Tree, loops: Sequence[LoopEquations], s: Sequence[float]) -> bool:
    try:
        gaps = jacobian_of(tree, loops, np.asarray(s), ())[0]
    except ZeroDivisionError:  # frames half a turn apart
        return False
    return float(np.abs(gaps).max(initial=0.0)) <= CLOSED


def _merit(tree: Tree, s: Array, residual: Mapping[str, float]) -> float:
    """0 where the loops close within the limits, below 1 where they close, more the more they are open."""
    worst = max(residual.values(), default=0.0)
    if worst > CLOSED:
        return 1.0 + worst
    limits = _limits(tree)
    beyond = np.maximum(limits[:, 0] - s, s - limits[:, 1]).max(initial=0.0)
    return 0.0 if beyond <= CLOSED else float(beyond / (1.0 + beyond))


def _limits(tree: Tree) -> Array:
    """(n_s, 2) in the order of the coordinates."""
    return np.array([body.limits for body in sorted(tree.bodies, key=lambda body: body.coordinate)])


def _other_starts(start: Sequence[float], held: Sequence[int], limits: Array) -> Iterator[Array]:
    """Configurations about the reference, always the same ones, for files whose neutral one is far from closed.

    Only what the loops hold is moved, and not beyond its limits.
    """
    rng = np.random.default_rng(0)
    for size in np.repeat(SPREADS, 6):
        begin = np.array(start, dtype=float)
        begin[held] += rng.uniform(-size, size, len(held))
        yield np.clip(begin, limits[:, 0], limits[:, 1])


def with_mobility(robot: RobotDescription, mobility: Mobility) -> tuple[RobotDescription, Tree]:
    """The description with its independent coordinates as active ones, and its tree."""
    notes = (*robot.notes, *_beyond(robot, mobility.reference))
    settled = replace(robot, active=mobility.active, reference=mobility.reference, notes=notes)
    return settled, build_tree(settled)


def _beyond(robot: RobotDescription, reference: Mapping[str, float]) -> Iterator[str]:
    """What is said of joints that the found reference has beyond their limits: the file named no reference itself."""
    for name, joint in robot.joints.items():
        value, (lower, upper) = reference[name], joint.limits
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
    rank = int((sizes > 1e-8 * max(float(sizes[0]), 1e-300)).sum())
    return vectors[rank:].T


def _independent(motions: Array, order: Sequence[int]) -> list[int]:
    """Coordinates in order, each kept if its motion does not follow from the ones kept before."""
    basis: list[Array] = []
    kept: list[int] = []
    for k in order:
        row = motions[k].copy()
        for direction in basis:
            row = row - (direction @ row) * direction
        size = float(np.linalg.norm(row))
        if size > INDEPENDENT and len(kept) < motions.shape[1]:
            basis.append(row / size)
            kept.append(k)
    return kept
