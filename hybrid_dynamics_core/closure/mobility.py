"""The independent coordinates of a mechanism, for files that list motors.

There may be fewer motors than freedoms (a rod that turns about its own axis, a free foot), or more.
A motor that depends on the ones before it becomes passive. A freedom without a motor becomes a
further independent coordinate without effort.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from ..algebra.independence import independent_rows, null_space
from ..description.model import RobotDescription
from ..errors import DescriptionError
from ..ground.arrays import Array
from ..mechanism.configuration import configuration_at
from ..mechanism.tree import Tree, build_tree
from .constraints.equations import LoopEquations
from .constraints.from_description import loop_equations
from .constraints.joint_coupling import JointCoupling
from .drawn_flat import with_parallelograms
from .loop_gap import describe_gap
from .numeric_closure import CLOSED, gaps_and_jacobian
from .reference_search import (
    Closed,
    closed_near,
    generic_near,
    is_closed_at,
    is_singular_for,
    may_be_singular,
)

# share of a coordinate's motion that must be independent of the coordinates chosen before
INDEPENDENT = 1e-6
ZERO = 1e-8  # singular values below this share of the largest count as zero
MAX_EQUATIONS = 600  # of loops in files of others; their dense equations take seconds
_MAX_LISTED = 5  # closures in a message
NOTED = 0.01  # [rad or m] smaller changes from the drawn pose come from rounding in the file


@dataclass(frozen=True)
class Mobility:
    """The independent coordinates of a mechanism.

    Attributes:
        active: names of all independent coordinates.
        idle: names of those that no motor drives.
        dependent: names of motors that follow from the others, hence passive.
        reference: the closed configuration of this analysis, by coordinate [rad or m].
        description: the robot's description, with reference, assembly modes and notes that were
            added.
    """

    active: tuple[str, ...]
    idle: tuple[str, ...]
    dependent: tuple[str, ...]
    reference: Mapping[str, float]
    description: RobotDescription


def find_mobility(tree: Tree, robot: RobotDescription) -> Mobility:
    """Find the mobility from the null space of J_s at a closed configuration near the reference.

    Args:
        tree: the spanning tree.
        robot: its description, whose active joints are motors.

    Raises:
        DescriptionError: a loop does not close, or nothing can move.
    """
    names = tree.coordinates
    start = [robot.reference.get(name, 0.0) for name in names]
    loops = loop_equations(tree, robot, frozenset(range(len(names))))
    _check_equation_count(robot, loops)
    passive = [k for k, name in enumerate(names) if name not in robot.active]
    closed = closed_near(tree, loops, start, passive)
    _require_closed(tree, robot, closed)
    generic = generic_near(tree, loops, closed.s)
    chosen = _independent_names(tree, robot, loops, generic)
    if names and not chosen:
        raise _held_fast(robot)
    if not is_closed_at(tree, loops, start):
        robot = _with_note_of_closing(tree, robot, start, closed.s)
    robot, s = _regular(tree, robot, closed.s, chosen)
    driven = (*robot.motors, *robot.actuators)
    motors = tuple(name for name in chosen if name in driven)
    idle = tuple(name for name in chosen if name not in driven)
    dependent = tuple(name for name in robot.motors if name not in motors)
    reference = dict(zip(names, s.tolist(), strict=True))
    return Mobility(motors + idle, idle, dependent, reference, robot)


def _held_fast(robot: RobotDescription) -> DescriptionError:
    """The error of a robot without a freedom, at its first closure or coupling."""
    names = [closure.name for closure in robot.closures]
    shown = ", ".join(names[:_MAX_LISTED])
    more = f" and {len(names) - _MAX_LISTED} more" if len(names) > _MAX_LISTED else ""
    problem = (
        f"the loops hold every joint fast: nothing is left to move; take out one of {shown}{more},"
        " or mend lengths and axes"
    )
    return robot.error(robot.closure_key(names[0]), problem)


def _check_equation_count(robot: RobotDescription, loops: Sequence[LoopEquations]) -> None:
    """Raise if loops have more equations than are solved in seconds."""
    closing = [loop for loop in loops if not isinstance(loop, JointCoupling)]
    count = sum(loop.size for loop in closing)
    if count > MAX_EQUATIONS:
        raise robot.error(
            "closures",
            f"{len(closing)} loops with {count} equations; at most {MAX_EQUATIONS} are solved"
            " together; take out what is no mechanism, such as springs that make up a cloth",
        )


def _with_note_of_closing(
    tree: Tree, robot: RobotDescription, start: Sequence[float], s: Array
) -> RobotDescription:
    """The description with a note on the joint values that close loops which are drawn open.

    Joints that end at the values given in the file are not noted.
    """
    places: list[str] = []
    for name, drawn, value in zip(tree.coordinates, start, s.tolist(), strict=True):
        if abs(value - drawn) > NOTED:
            places.append(f"{name} = {value:.4g}")
    if not places:
        return robot
    note = f"the loops are open as the file draws them; they close nearby at {', '.join(places)}"
    return replace(robot, notes=(*robot.notes, note))


def _independent_names(
    tree: Tree, robot: RobotDescription, loops: Sequence[LoopEquations], s: Array
) -> list[str]:
    """Independent coordinates at a configuration; driven ones are preferred."""
    names = tree.coordinates
    held = sorted({k for loop in loops for k in loop.coordinates})
    _, jacobian = gaps_and_jacobian(tree, loops, s, held)
    motions = null_space(jacobian, ZERO)  # that keep all loops closed
    order = _indices(names, (*robot.motors, *robot.actuators, *robot.idle, *names))
    rows = {k: row for row, k in enumerate(held)}
    in_loops = [rows[k] for k in order if k in rows]
    independent = independent_rows(motions, in_loops, INDEPENDENT, passes=1)
    dependent = set(held).difference(held[row] for row in independent)
    return [names[k] for k in order if k not in dependent]


def _regular(
    tree: Tree, robot: RobotDescription, s: Array, active: Sequence[str]
) -> tuple[RobotDescription, Array]:
    """The description, and a closed configuration (n_s,) at which J_z is regular.

    A parallelogram that is drawn flat gets its assembly mode by name. Any other mechanism is moved
    a little off a change point or dead centre. Notes say so.

    Args:
        tree: the spanning tree.
        robot: its description.
        s: the pose of the file, closed [rad or m].
        active: names of the independent coordinates.
    """
    names = tree.coordinates
    passive = [k for k, name in enumerate(names) if name not in active]
    candidates = [robot]
    flat = with_parallelograms(tree, robot, s)
    if flat.closures != robot.closures:
        candidates.append(flat)
    generic = s
    everything = frozenset(range(len(names)))
    for candidate in candidates:
        robot = candidate
        loops = loop_equations(tree, robot, everything)
        generic = generic_near(tree, loops, s)
        if not is_singular_for(tree, loops, s, generic, passive):
            return robot, s
    if may_be_singular(tree, loop_equations(tree, robot, everything), generic, passive):
        return candidates[0], s  # singular all around, as a pose in which nothing moves
    places: list[str] = []
    for name, old, new in zip(names, s.tolist(), generic.tolist(), strict=True):
        if name in active and abs(new - old) > CLOSED:
            places.append(f"{name} = {new:.4g}")
    note = (
        "the pose of the file is at a change point or a dead centre, where links can go either way;"
        f" the reference beside it was taken: {', '.join(places)}"
    )
    return replace(robot, notes=(*robot.notes, note)), generic


def with_regular_reference(
    tree: Tree, robot: RobotDescription, closed_at: Array | None = None
) -> RobotDescription | None:
    """The description with a closed regular reference, if the file has none.

    Args:
        tree: the spanning tree.
        robot: its description, whose active joints are the independent ones.
        closed_at: where the loops close with the active joints at zero (n_s,) [rad or m]; None if
            that is not known.

    Returns:
        The description with a note, None where the pose of the file closes and is regular, or
        where no closed configuration was found.
    """
    if any(name in robot.reference for name in robot.active):
        return None
    names = tree.coordinates
    start = [robot.reference.get(name, 0.0) for name in names]
    loops = loop_equations(tree, robot, frozenset(range(len(names))))
    passive = [k for k, name in enumerate(names) if name not in robot.active]
    if closed_at is not None and not may_be_singular(tree, loops, closed_at, passive):
        return None
    closed = closed_near(tree, loops, start, passive)
    if not closed.is_closed:
        return None
    moved = robot
    if not is_closed_at(tree, loops, start):
        moved = _with_note_of_closing(tree, robot, start, closed.s)
    settled, s = _regular(tree, moved, closed.s, robot.active)
    if settled is robot:
        return None
    reference = dict(robot.reference)
    for k, name in enumerate(names):
        if name in robot.active or name in reference:
            reference[name] = float(s[k])
    return replace(settled, reference=reference)


def with_mobility(mobility: Mobility) -> tuple[RobotDescription, Tree]:
    """The description with its independent coordinates as active ones, and its tree."""
    robot = mobility.description
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
    numbers = {name: number for number, name in enumerate(names)}
    return [numbers[name] for name in dict.fromkeys(preferred)]


def _require_closed(tree: Tree, robot: RobotDescription, closed: Closed) -> None:
    """Raise if a loop is open; the error names the one with the largest gap."""
    if closed.is_closed:
        return
    worst = max(closed.gaps, key=lambda name: closed.gaps[name])
    gap = describe_gap(tree, robot, worst, configuration_at(tree, closed.s))
    raise robot.error(
        robot.closure_key(worst),
        f"does not close: {gap} ({closed.gaps[worst]:.2g} of the loop's length; {CLOSED:g} is"
        " allowed) at best; mend the geometry",
    )


def _beyond_limits(robot: RobotDescription, reference: Mapping[str, float]) -> Iterator[str]:
    """Notes on joints beyond their limits in a reference that the file does not name."""
    for name, joint in robot.joints.items():
        value = reference[name]
        lower, upper = joint.limits
        if not lower - CLOSED <= value <= upper + CLOSED:
            yield (
                f"{name}: the loops close at {value:.6g}, outside its limits [{lower:.6g},"
                f" {upper:.6g}]; within all limits no closed configuration was found"
            )
