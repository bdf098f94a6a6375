"""Regrouping of inertial parameters between links, which preserves the efforts of active joints.

A mass on the axis of a revolute joint may be assigned to either of its links. So may its first and
second moment along the axis: three numbers. Both links of a slide have the same orientation, so all
six second moments may move. The same holds for pins of loops, and for links that stay parallel.
Parameters moved to the base have no effect.

The number of nonzero parameters becomes minimal, so kernels need fewer operations. The new
parameters are not those of bodies: a mass may be zero or negative. Energy, reactions and the
regressor use the described ones.

Mass m, first moment h and second moments E = integral of p p^T about the link origin are linear in
the mass distribution. They go to another frame x -> R x + t as

    m,  R h + m t,  R E R^T + R h t^T + t (R h)^T + m t t^T.

Khalil and Dombre (2002), Modeling, Identification and Control of Robots, Chapter 9, have the rules
for trees.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ..closure.constraints.angle_sum import AngleSum
from ..closure.constraints.ball_cut import Orientation
from ..closure.constraints.joint_coupling import JointCoupling
from ..closure.constraints.plane import plane_basis
from ..closure.plan import ClosurePlan
from ..description.model import Closure
from ..ground.arrays import Array
from ..mechanism.joint_transform import joint_transforms, poses_in_base
from ..mechanism.tree import Body, Tree, floats, rows

BASE = -1
# entries of a distribution: m, hx, hy, hz, Exx, Exy, Exz, Eyy, Eyz, Ezz
SIZE = 10
_PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
# a smaller pivot, as a share of the largest entry, would make large numbers that cancel
WELL = 0.1
DUST = 1e-15  # rounding error, as a share of the largest parameter
DEPENDENT = 1e-9  # rounding error of a move that depends on others
PARALLEL = 1e-12  # rounding error of cosines between axes, and of coefficients

# rotation and translation to the frame of another link
Pose = tuple[Array, Array]


def regrouped(tree: Tree, plan: ClosurePlan, closures: Sequence[Closure]) -> Tree:
    """The tree with fewer inertial parameters and the same forces along the given coordinates.

    Args:
        tree: the spanning tree.
        plan: closure plan.
        closures: closures of the description.
    """
    if not tree.bodies:
        return tree
    moves = _Moves(tree, plan).all(closures)
    scale = _scales(tree)
    distributions = [_distribution(body) for body in tree.bodies]
    described = np.concatenate(distributions) / scale
    order = _order(tree, plan)
    fewest = _with_most_zeros(described, moves / scale, order)
    values = _without_dust(fewest, described) * scale
    parts = np.split(values, len(tree.bodies))
    bodies = map(_with, tree.bodies, parts)
    return replace(tree, bodies=tuple(bodies))


class _Moves:
    """Allowed moves between links: rows (., 10 * bodies) of changes of all parameters."""

    def __init__(self, tree: Tree, plan: ClosurePlan) -> None:
        self._tree = tree
        self._plan = plan
        transforms = joint_transforms(tree, plan.reference)
        self._poses = [_arrays(pose) for pose in poses_in_base(tree, transforms)]
        self._rows: list[Array] = []

    def all(self, closures: Sequence[Closure]) -> Array:
        """All moves through joints, pins, and between parallel links."""
        for k, body in enumerate(self._tree.bodies):
            self._through_joint(k, body)
        for closure in closures:
            self._through_pin(closure)
        for a, b in self._parallel():
            pose = self._between(a, b)
            self._add(a, b, pose, _second_moments())
        return np.array(self._rows).reshape(-1, SIZE * len(self._tree.bodies))

    def _through_joint(self, k: int, body: Body) -> None:
        pose: Pose = np.array(body.rotation), np.array(body.translation)
        if body.chart is not None:
            distributions = [_point(np.zeros(3))]
        elif body.is_revolute:
            distributions = _line(np.zeros(3), np.array(body.axis))
        else:
            distributions = _second_moments()
        self._add(k, body.parent, pose, distributions)

    def _through_pin(self, closure: Closure) -> None:
        a = self._tree.body_index(closure.link_a)
        b = self._tree.body_index(closure.link_b)
        pose = self._between(a, b)
        if closure.kind == "frame":
            distributions = list(np.eye(SIZE))
        elif closure.kind == "axis":
            distributions = _line(closure.point_a, closure.rotation_a[:, 2])
        elif closure.kind == "point":
            distributions = [_point(closure.point_a)]
        else:
            distributions = _line(closure.point_a, self._normal(a, b))
        self._add(a, b, pose, distributions)

    def _normal(self, a: int, b: int) -> Array:
        """The normal of a planar loop (3,), in the axes of link a."""
        path_a, path_b, ancestor = self._tree.branches(a, b)
        basis = plane_basis(self._tree, path_a + path_b, ancestor)
        rotation, _ = self._tree.zero_pose(a, ancestor)
        normal: Array = (basis @ rotation)[2]
        return normal

    def _parallel(self) -> Iterator[tuple[int, int]]:
        """Pairs of links, including the base, with equal orientation in every assembly mode.

        The joints between them have parallel axes, and linear equations fix the sum of their
        angles. Equal bars alone make links parallel on one mode only.
        """
        constant_rows = self._constant_rows()
        groups: list[int] = [BASE]
        for body in range(len(self._tree.bodies)):
            for leader in groups:
                if self._is_parallel(body, leader, constant_rows):
                    yield body, leader
                    break
            else:
                groups.append(body)

    def _constant_rows(self) -> Array:
        """Linear equations of the loops (k, n_s)."""
        size = len(self._tree.coordinates)
        equations: list[Array] = []
        for loop in self._plan.loops:
            if isinstance(loop, AngleSum):
                coefficients = dict(loop.turns)
            elif isinstance(loop, JointCoupling):
                coefficients = loop.coefficients
            else:
                continue
            row = np.zeros(size)
            row[list(coefficients)] = list(coefficients.values())
            equations.append(row)
        return np.array(equations).reshape(-1, size)

    def _is_parallel(self, a: int, b: int, constant_rows: Array) -> bool:
        angle = self._angle_between(a, b)
        if angle is None:
            return False
        if not angle.any():
            return True
        solution, *_ = np.linalg.lstsq(constant_rows.T, angle, rcond=None)
        rest = constant_rows.T @ solution - angle
        return bool(np.abs(rest).max() < PARALLEL)

    def _angle_between(self, a: int, b: int) -> Array | None:
        """The angle by which link a is turned from link b, as coefficients of s (n_s,).

        None if the axes of the joints between them are not parallel.
        """
        path_a, path_b, ancestor = self._tree.branches(a, b)
        angle = np.zeros(len(self._tree.coordinates))
        axes: list[Array] = []
        for sign, path in ((1.0, path_a), (-1.0, path_b)):
            for k in path:
                body = self._tree.bodies[k]
                if not body.is_revolute:
                    continue
                rotation, _ = self._tree.zero_pose(k, ancestor)
                axes.append(rotation @ np.array(body.axis))
                along = float(axes[0] @ axes[-1])
                if body.chart is not None or abs(abs(along) - 1.0) > PARALLEL:
                    return None
                angle[body.coordinate] += sign * np.sign(along)
        return angle

    def _between(self, a: int, b: int) -> Pose:
        """The transform from the frame of link a to that of link b, at the reference."""
        rotation_a, origin_a = self._pose(a)
        rotation_b, origin_b = self._pose(b)
        rotation = rotation_b.T @ rotation_a
        translation = rotation_b.T @ (origin_a - origin_b)
        return rotation, translation

    def _pose(self, body: int) -> Pose:
        if body == BASE:
            return np.eye(3), np.zeros(3)
        return self._poses[body]

    def _add(self, a: int, b: int, pose: Pose, distributions: Sequence[Array]) -> None:
        """Add the moves of distributions from link a to link b."""
        for distribution in distributions:
            row = np.zeros((len(self._tree.bodies), SIZE))
            if a != BASE:
                row[a] -= distribution
            if b != BASE:
                row[b] += _transferred(distribution, pose)
            self._rows.append(row.reshape(-1))


def _with_most_zeros(values: Array, moves: Array, order: Sequence[int]) -> Array:
    """The values plus a sum of moves, with as many zeros as there are independent moves."""
    values = values.copy()
    moves = moves / np.abs(moves).max(axis=1, keepdims=True)
    for entry in order:
        largest = np.abs(moves).max(axis=1, initial=0.0)
        moves = moves[largest > DEPENDENT]
        if not len(moves):
            break
        shares = np.abs(moves[:, entry]) / np.abs(moves).max(axis=1)
        best = int(np.argmax(shares))
        if shares[best] < WELL:
            continue
        move = moves[best] / moves[best, entry]
        values -= values[entry] * move
        values[entry] = 0.0
        moves = np.delete(moves, best, axis=0)
        moves -= np.outer(moves[:, entry], move)
        moves[:, entry] = 0.0
    return values


def _without_dust(values: Array, described: Array) -> Array:
    """The values, with rounding errors of cancelled numbers set to zero."""
    dust = DUST * np.abs(described).max(initial=0.0)
    return np.where(np.abs(values) < dust, 0.0, values)


def _order(tree: Tree, plan: ClosurePlan) -> list[int]:
    """Entries in the order in which they become zero: from the tips to the base, masses first.

    Links behind ball joints that a weld determines come before all others. Without a mass there,
    efforts do not depend on the angles of these joints.
    """
    tips = range(len(tree.bodies) - 1, -1, -1)
    orientations = [loop for loop in plan.loops if isinstance(loop, Orientation)]
    names = {body.name for loop in orientations for body in loop.ball.joints}
    behind_balls = [k for k in tips if tree.bodies[k].name in names]
    entries: list[int] = []
    for body in dict.fromkeys((*behind_balls, *tips)):
        entries += range(SIZE * body, SIZE * (body + 1))
    return entries


def _scales(tree: Tree) -> Array:
    """Scales that convert the parameters to masses: powers of the size of the robot."""
    length = 1.0
    carried = [body for body in tree.bodies if body.parent >= 0]
    lengths = [float(np.linalg.norm(body.translation)) for body in carried]
    if any(lengths):
        length = max(lengths)
    of_first = [length] * 3
    of_second = [length**2] * 6
    of_one = np.array([1.0, *of_first, *of_second])
    return np.tile(of_one, len(tree.bodies))


def _distribution(body: Body) -> Array:
    """Mass, first moment and second moments of a body (10,)."""
    inertia: Array = np.array(body.inertia)
    second = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    return _packed(body.mass, np.array(body.first_moment), second)


def _with(body: Body, distribution: Array) -> Body:
    """The body with another distribution."""
    mass, first, second = _unpacked(distribution)
    inertia: Array = np.trace(second) * np.eye(3) - second
    return replace(
        body,
        mass=float(mass),
        first_moment=floats(first),
        inertia=rows(inertia),
        second_moments=rows(second),
    )


def _packed(mass: float, first: Array, second: Array) -> Array:
    return np.array([mass, *first, *(second[i, j] for i, j in _PAIRS)])


def _unpacked(distribution: Array) -> tuple[float, Array, Array]:
    second = np.zeros((3, 3))
    for (i, j), value in zip(_PAIRS, distribution[4:], strict=True):
        second[i, j] = second[j, i] = value
    return float(distribution[0]), distribution[1:4], second


def _transferred(distribution: Array, pose: Pose) -> Array:
    """A distribution in another frame."""
    rotation, translation = pose
    mass, first, second = _unpacked(distribution)
    turned = rotation @ first
    mixed = np.outer(turned, translation)
    second = rotation @ second @ rotation.T + mixed + mixed.T
    second += mass * np.outer(translation, translation)
    first = turned + mass * translation
    return _packed(mass, first, second)


def _point(place: Array) -> Array:
    """The distribution of a unit mass at a point."""
    return _packed(1.0, place, np.outer(place, place))


def _line(place: Array, axis: Array) -> list[Array]:
    """Distributions of a unit mass at a point, and of unit moments along an axis."""
    mixed = np.outer(place, axis)
    return [
        _point(place),
        _packed(0.0, axis, mixed + mixed.T),
        _packed(0.0, np.zeros(3), np.outer(axis, axis)),
    ]


def _second_moments() -> list[Array]:
    """The distributions of the six unit second moments."""
    return list(np.eye(SIZE)[4:])


def _arrays(pose: tuple[object, object]) -> Pose:
    rotation, origin = pose
    return np.array(rotation, dtype=float), np.array(origin, dtype=float)
