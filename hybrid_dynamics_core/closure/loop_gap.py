"""The gap [m, rad] of a loop that does not close, for error texts."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from ..algebra.independence import norm
from ..algebra.rotations import rotation_angle
from ..description.model import Closure, RobotDescription
from ..ground.arrays import Array
from ..mechanism.configuration import Configuration
from ..mechanism.tree import Tree
from .blocks.block_solver import BlockSolver
from .constraints.spatial import Chain, closure_chains

STARTS = 24  # of the search for the nearest approach
OPEN = 1e-6  # share of the longest length: a smaller gap counts as closed
UNLIKE = 100.0  # ratio of lengths in one loop that suggests different units
NEGLIGIBLE = 1e-10  # [m or rad] a smaller gap of a closure is not mentioned

ChainPair = tuple[Chain, Chain]


def describe_gap(
    tree: Tree, robot: RobotDescription, loop: str, configuration: Configuration
) -> str:
    """Text on how far the ends of a closure are apart, or how far a follower is off.

    It gives the distance of the points [m], and the angle between axes or frames [rad].

    Args:
        tree: the spanning tree.
        robot: its description.
        loop: name of a closure or of a follower.
        configuration: all coordinates, floats.
    """
    closure = next((closure for closure in robot.closures if closure.name == loop), None)
    if closure is None:
        return _describe_follower(tree, robot, loop, configuration)
    chain_a, chain_b = closure_chains(tree, closure)
    a = chain_a.at(configuration)
    b = chain_b.at(configuration)
    gaps = [(norm(np.subtract(a.end, b.end)), "m")]
    rotation_a = np.array(a.rotation, dtype=float)
    rotation_b = np.array(b.rotation, dtype=float)
    if closure.kind == "axis":
        angle = _angle_between(rotation_a[:, 2], rotation_b[:, 2])
        gaps.append((angle, "rad"))
    if closure.kind == "frame":
        gaps.append((rotation_angle(rotation_a @ rotation_b.T), "rad"))
    open_gaps = [f"{gap:.3g} {unit}" for gap, unit in gaps if gap > NEGLIGIBLE]
    text = " and ".join(open_gaps) or "0 m"
    return f"its ends on {closure.link_a} and {closure.link_b} stay {text} apart"


def _describe_follower(
    tree: Tree, robot: RobotDescription, name: str, configuration: Configuration
) -> str:
    mimic = robot.mimics[name]
    follower = tree.coordinates.index(name)
    expected = mimic.offset
    for source, multiplier in mimic.multipliers.items():
        expected += multiplier * float(configuration.q[tree.coordinates.index(source)])
    gap = abs(float(configuration.q[follower]) - expected)
    sources = ", ".join(mimic.multipliers)
    return f"it stays {gap:.3g} {tree.unit(follower)} off what it follows, {sources}"


def _angle_between(a: Array, b: Array) -> float:
    """Angle between two unit vectors [rad]."""
    sine = norm(np.cross(a, b))
    return float(np.arctan2(sine, a @ b))


def describe_least_gap(
    tree: Tree,
    closures: Mapping[str, Closure],
    block: BlockSolver,
    configuration: Configuration,
) -> str:
    """Text on the smallest gap of a block, the coordinates there, and lengths that look wrong.

    Args:
        tree: the spanning tree.
        closures: the robot's closures by name.
        block: a block that does not close.
        configuration: the coordinates before the block, floats.

    Returns:
        A text such as 'open by 0.1 m at best, at motor = 1 rad'; empty if the points can meet.
    """
    pairs = [closure_chains(tree, closures[name]) for name in block.loops if name in closures]
    if not pairs:
        return ""
    lengths = _lengths(pairs, configuration, block)
    gap = _least_gap(tree, pairs, block, configuration, max(lengths))
    if gap < OPEN * max(lengths):
        return ""
    values = [tree.value_text(k, configuration.q[k], digits=4) for k in block.inputs]
    place = ""
    if values:
        place = f", at {', '.join(values)}"
    hint = ""
    if max(lengths) >= UNLIKE * min(lengths):
        hint = f"; lengths are in metres: {max(lengths):g} m stands beside {min(lengths):g} m"
    return f"open by {gap:.3g} m at best{place}{hint}"


def _least_gap(
    tree: Tree,
    pairs: Sequence[ChainPair],
    block: BlockSolver,
    configuration: Configuration,
    length: float,
) -> float:
    """The largest distance of two points [m] where the sum of squared distances is least.

    The minimum is searched from several starts.
    """
    free = _free_coordinates(pairs, block, configuration)
    if not free:
        return 0.0
    # imported late: it is slow, and only errors need it
    from scipy.optimize import least_squares  # noqa: PLC0415

    gaps = _gaps_as_function(tree, pairs, configuration, free)
    spans = np.full(len(free), length)
    spans[[tree.is_revolute(k) for k in free]] = np.pi
    rng = np.random.default_rng(0)
    starts = spans * rng.uniform(-1.0, 1.0, (STARTS, len(free)))
    solutions = [least_squares(gaps, start, x_scale=spans) for start in starts]
    best = min(solutions, key=lambda solution: float(solution.cost))
    differences = best.fun.reshape(-1, 3)
    return max(norm(difference) for difference in differences)


def _free_coordinates(
    pairs: Sequence[ChainPair], block: BlockSolver, configuration: Configuration
) -> list[int]:
    """Coordinates of the chains that the block solves, or that are not set yet."""
    involved: set[int] = set()
    for a, b in pairs:
        involved |= a.coordinates | b.coordinates
    return sorted(k for k in involved if k in block.unknowns or configuration.q[k] is None)


def _gaps_as_function(
    tree: Tree, pairs: Sequence[ChainPair], configuration: Configuration, free: Sequence[int]
) -> Callable[[Array], Array]:
    """Differences of the end points (3 * pairs,) [m] as a function of the free coordinates."""

    def gaps(x: Array) -> Array:
        trial = configuration.copy()
        for k, value in zip(free, x, strict=True):
            trial.set_value(k, float(value), revolute=tree.is_revolute(k))
        differences: list[Array] = []
        for a, b in pairs:
            differences.append(np.subtract(a.at(trial).end, b.at(trial).end))
        return np.concatenate(differences).astype(float)

    return gaps


def _lengths(
    pairs: Sequence[ChainPair], configuration: Configuration, block: BlockSolver
) -> list[float]:
    """Lengths [m] in the loops: between joints, to the pins, and given strokes."""
    lengths: list[float] = []
    for pair in pairs:
        for chain in pair:
            lengths += chain.offsets
            strokes = [float(configuration.q[k]) for k in _given_strokes(chain, block)]
            lengths += map(abs, strokes)
    return [length for length in lengths if length > 0.0] or [1.0]


def _given_strokes(chain: Chain, block: BlockSolver) -> list[int]:
    """Prismatic coordinates of a chain that are given to the block."""
    slides = [body.coordinate for body in chain.bodies if not body.is_revolute]
    return [k for k in slides if k in block.inputs]
