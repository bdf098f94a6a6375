"""How far a loop that does not close stays open, in metres and radians: what an error can say of its geometry."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..description.model import Closure, RobotDescription
from ..ground.arrays import Array
from ..mechanism.configuration import Configuration
from ..mechanism.tree import Tree
from .blocks.block_solver import BlockSolver
from .constraints.spatial import Chain, closure_chains

STARTS = 24  # of the search for the nearest approach
OPEN = 1e-6  # of the longest length: a gap worth telling
UNLIKE = 100.0  # lengths of one loop this far apart are hardly in one unit
TOLD = 1e-9  # [m or rad] a gap of a closure that is worth a number of its own


def gap_of(tree: Tree, robot: RobotDescription, loop: str, configuration: Configuration) -> str:
    """Which ends of a closure stay how far apart at a configuration of floats, or how far a follower is off.

    Beside the points [m], of axes the angle between them and of frames that of the turn between
    them [rad].
    """
    closure = next((closure for closure in robot.closures if closure.name == loop), None)
    if closure is None:
        return _off_course(tree, robot, loop, configuration)
    a, b = (chain.at(configuration) for chain in closure_chains(tree, closure))
    gaps = [(float(np.linalg.norm(np.subtract(a.end, b.end).astype(float))), "m")]
    if closure.kind in ("axis", "frame"):
        gaps.append(
            (
                _angle(
                    np.array(a.rotation, dtype=float),
                    np.array(b.rotation, dtype=float),
                    closure.kind,
                ),
                "rad",
            )
        )
    told = [f"{gap:.3g} {unit}" for gap, unit in gaps if gap > TOLD] or ["0 m"]
    return f"its ends on {closure.link_a} and {closure.link_b} stay {' and '.join(told)} apart"


def _off_course(
    tree: Tree, robot: RobotDescription, follower: str, configuration: Configuration
) -> str:
    mimic, own = robot.mimics[follower], tree.coordinates.index(follower)
    source = float(configuration.q[tree.coordinates.index(mimic.source)])
    off = abs(float(configuration.q[own]) - mimic.multiplier * source - mimic.offset)
    return f"it stays {off:.3g} {tree.unit(own)} off what it follows, {mimic.source}"


def _angle(a: Array, b: Array, kind: str) -> float:
    """Between the z axes of two frames, or of the turn from one to the other [rad]."""
    if kind == "axis":
        return float(np.arctan2(np.linalg.norm(np.cross(a[:, 2], b[:, 2])), a[:, 2] @ b[:, 2]))
    from scipy.spatial.transform import (  # noqa: PLC0415  slow to import, and only a failure needs it
        Rotation,
    )

    return float(Rotation.from_matrix(a @ b.T).magnitude())


def shortfall(
    tree: Tree, closures: Mapping[str, Closure], step: BlockSolver, configuration: Configuration
) -> str:
    """'open by ... m at best, at motor = 1 rad' and what the lengths look like; empty where the points do meet.

    `configuration`: what is known before the step. The least distance is searched for from several
    starts.
    """
    chains = [closure_chains(tree, closures[name]) for name in step.loops if name in closures]
    if not chains:
        return ""
    lengths = _lengths(chains, configuration, step)
    gap = _least_gap(tree, chains, step, configuration, max(lengths))
    if gap < OPEN * max(lengths):
        return ""
    known = [
        f"{tree.coordinates[k]} = {float(configuration.q[k]):.4g} {tree.unit(k)}"
        for k in step.inputs
    ]
    place = f", at {', '.join(known)}" if known else ""
    unlike = max(lengths) >= UNLIKE * min(lengths)
    hint = (
        f"; lengths are in metres: {max(lengths):g} m stands beside {min(lengths):g} m"
        if unlike
        else ""
    )
    return f"open by {gap:.3g} m at best{place}{hint}"


def _least_gap(
    tree: Tree,
    chains: Sequence[tuple[Chain, Chain]],
    step: BlockSolver,
    configuration: Configuration,
    length: float,
) -> float:
    """The farthest that two points stay apart [m] where all pairs together come nearest."""
    from scipy.optimize import (  # noqa: PLC0415  slow to import, and only a failure needs it
        least_squares,
    )

    involved = frozenset().union(*(chain.coordinates for pair in chains for chain in pair))
    free = sorted(k for k in involved if k in step.unknowns or configuration.q[k] is None)

    def apart(x: Array) -> Array:
        trial = configuration.copy()
        for k, value in zip(free, x, strict=True):
            put = trial.set_angle if tree.is_revolute(k) else trial.set_length
            put(k, float(value))
        return np.concatenate(
            [np.subtract(a.at(trial).end, b.at(trial).end) for a, b in chains]
        ).astype(float)

    if not free:
        return 0.0
    spans = np.array([np.pi if tree.is_revolute(k) else length for k in free])
    starts = spans * np.random.default_rng(0).uniform(-1.0, 1.0, (STARTS, len(free)))
    best = min(
        (least_squares(apart, start, x_scale=spans) for start in starts),
        key=lambda found: float(found.cost),
    )
    return float(np.linalg.norm(best.fun.reshape(-1, 3), axis=1).max())


def _lengths(
    chains: Sequence[tuple[Chain, Chain]], configuration: Configuration, step: BlockSolver
) -> list[float]:
    """Lengths [m] of which the loops are made: between joints, to the pins, and strokes that are known."""
    lengths = [0.0]
    for chain in (chain for pair in chains for chain in pair):
        lengths += [
            float(np.linalg.norm(np.array(b.translation, dtype=float))) for b in chain.bodies
        ]
        lengths.append(float(np.linalg.norm(np.array(chain.point, dtype=float))))
        slides = (
            b.coordinate
            for b in chain.bodies
            if b.type == "prismatic" and b.coordinate in step.inputs
        )
        lengths += [abs(float(configuration.q[k])) for k in slides]
    return [length for length in lengths if length > 0.0] or [1.0]
