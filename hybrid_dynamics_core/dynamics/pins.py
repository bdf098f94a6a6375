"""What a closure can transmit, as forces and moments in space, whatever equations close its loop.

The closure's multipliers give generalised forces along the joints of its loop; the wrench is the
one that does the same work. It is sought in the directions that the closure holds and that the
loop's joints do not all leave at rest: the joints of a planar loop never move its pin sideways, so
the model cannot tell a sideways force from none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..algebra.definite import Definite
from ..algebra.scalar import Scalar
from ..algebra.vector import ZERO3, Rotation, Vector, add, constant, dot, matvec, scale
from ..closure.closed_motion import ClosedMotion
from ..closure.constraints.plane import plane_basis
from ..closure.constraints.spatial import chains_length, closure_chains
from ..closure.plan import ClosurePlan
from ..description.model import Closure
from ..ground.arrays import Array
from ..mechanism.configuration import Configuration
from ..mechanism.tree import Tree
from .spanning import TreeDynamics

INDEPENDENT = 1e-7  # share of a direction's work that the directions before it must leave
NOTHING = 1e-30  # share that is far below the rounding of every share that counts
STIR = (0.0, 0.07, -0.11)  # [rad or m] off the reference, which may be a special place
FORCE_3, FORCE_2 = (0, 1, 2), (0, 1)
_HELD = {
    "planar": FORCE_2,
    "point": FORCE_3,
    "axis": (*FORCE_3, 3, 4),
    "frame": (*FORCE_3, 3, 4, 5),
}
_NAMES = (
    "force along x",
    "force along y",
    "force along z",
    "moment about x",
    "moment about y",
    "moment about z",
)


@dataclass(frozen=True)
class Pin:
    """A closure's place and axes on its link a, and which of six directions (force, then moment) it is taken to bear.

    `axes`: rows in link a's frame, the third one the normal of a planar loop or the closure's z
    axis. `silent`: what the closure may transmit, or the joints of its loop would bear in its
    place, and the model cannot tell.
    """

    name: str
    body_a: int
    point_a: Vector
    body_b: int
    point_b: Vector
    axes: Rotation
    length: float
    loop: frozenset[int]  # coordinates of the loop's joints
    borne: tuple[int, ...]
    silent: tuple[str, ...]

    def work(self, tree: TreeDynamics) -> list[dict[int, Scalar]]:
        """For each direction borne, the work of a unit wrench on link a (against b) per unit rate of each joint.

        Moments count per `length`.
        """
        rotation, (point_a, point_b) = self._rotation(tree), self.ends(tree)
        rows: list[dict[int, Scalar]] = [{} for _ in self.borne]
        for sign, body, point in ((1.0, self.body_a, point_a), (-1.0, self.body_b, point_b)):
            for k, (linear, angular) in tree.jacobian(body, point).items():
                if k not in self.loop:
                    continue
                for row, direction in zip(rows, self.borne, strict=True):
                    moved = linear if direction < 3 else scale(self.length, angular)
                    part = sign * dot(rotation[direction % 3], moved)
                    row[k] = part
        return rows

    def wrench(
        self, tree: TreeDynamics, generalised: Mapping[int, Scalar]
    ) -> tuple[Vector, Vector, Scalar]:
        """Force and moment (base axes, about the pin) on link a that give these generalised forces; and how well.

        The last value is the determinant of the system, 1 where it is best: 0 where the split is
        undefined.
        """
        work = self.work(tree)
        products = [[_product(a, b) for b in work] for a in work]
        size = sum((row[k] for k, row in enumerate(products)), 0.0) / max(len(products), 1)
        gram = Definite(products, NOTHING * size)
        parts = gram.solve([_product(row, generalised) for row in work])
        rotation = self._rotation(tree)
        force, moment = ZERO3, ZERO3
        for direction, part in zip(self.borne, parts, strict=True):
            if direction < 3:
                force = add(force, scale(part, rotation[direction]))
            else:
                moment = add(moment, scale(self.length * part, rotation[direction % 3]))
        share: Scalar = 1.0
        for pivot in gram.pivots:
            share = share * (pivot / size)
        return force, moment, share

    def ends(self, tree: TreeDynamics) -> tuple[Vector, Vector]:
        """The pin's place on both links, in the base frame."""
        (turn_a, at_a), (turn_b, at_b) = tree.pose(self.body_a), tree.pose(self.body_b)
        return add(at_a, matvec(turn_a, self.point_a)), add(at_b, matvec(turn_b, self.point_b))

    def _rotation(self, tree: TreeDynamics) -> Rotation:
        """The pin's axes as rows, in base axes."""
        rotation = tree.pose(self.body_a)[0]
        return tuple(matvec(rotation, axis) for axis in self.axes)  # type: ignore[return-value]


def _product(a: Mapping[int, Scalar], b: Mapping[int, Scalar]) -> Scalar:
    total: Scalar = 0.0
    for k, value in a.items():
        if k in b:
            total = total + value * b[k]
    return total


def find_pins(tree: Tree, plan: ClosurePlan, closures: Sequence[Closure]) -> list[Pin]:
    """The pins of all closures, in their order."""
    postures = _closed_postures(tree, plan)
    return [_pin(tree, closure, postures) for closure in closures]


def _pin(tree: Tree, closure: Closure, postures: Sequence[Configuration]) -> Pin:
    a, b = tree.body_index(closure.link_a), tree.body_index(closure.link_b)
    path_a, path_b, ancestor = tree.branches(a, b)
    try:
        axes = plane_basis(tree, path_a + path_b, ancestor) @ tree.zero_pose(a, ancestor)[0]
        planar = True
    except ValueError:
        axes, planar = closure.rotation_a.T, False
    length = chains_length(*closure_chains(tree, closure))
    loop = frozenset(tree.bodies[i].coordinate for i in path_a + path_b)
    rows: Rotation = tuple(constant(row) for row in axes)  # type: ignore[assignment]
    place_a, place_b = constant(closure.point_a), constant(closure.point_b)
    whole = Pin(closure.name, a, place_a, b, place_b, rows, length, loop, tuple(range(6)), ())
    held = _HELD[closure.kind]
    borne: tuple[int, ...] = ()
    for configuration in postures:
        work = _matrix(whole.work(TreeDynamics(tree, configuration)), len(tree.coordinates))
        found = _independent(work, held)
        borne = found if len(found) > len(borne) else borne
    silent = (2, 3, 4) if planar else ()
    told = tuple(_NAMES[k] for k in sorted({*silent, *held} - set(borne)))
    return Pin(closure.name, a, place_a, b, place_b, rows, length, loop, borne, told)


def _closed_postures(tree: Tree, plan: ClosurePlan) -> list[Configuration]:
    """The reference configuration, and others around it that close."""
    reference = np.array(plan.reference.q, dtype=float)
    given = list(plan.given)
    postures = []
    for step in STIR:
        u = reference[given] + step * np.cos(1.0 + 2.0 * np.arange(len(given)))
        try:
            motion = ClosedMotion(tree, plan, u.tolist(), plan.branch, reference.tolist())
        except ZeroDivisionError:
            continue
        if all(block.margin > 0.0 for block in motion.blocks):
            postures.append(motion.configuration)
    return postures


def _matrix(work: Sequence[Mapping[int, Scalar]], size: int) -> Array:
    return np.array([[float(row.get(k, 0.0)) for k in range(size)] for row in work])


def _independent(work: Array, held: Sequence[int]) -> tuple[int, ...]:
    """Directions of `held`, in order, each kept if the ones before do not make up its work (Gram-Schmidt)."""
    largest = float(np.abs(work).max(initial=0.0))
    basis: list[Array] = []
    kept = []
    for k in held:
        rest = work[k].copy()
        for _ in range(2):
            for direction in basis:
                rest = rest - (direction @ rest) * direction
        left = float(np.linalg.norm(rest))
        if left > INDEPENDENT * max(largest, 1e-300):
            basis.append(rest / left)
            kept.append(k)
    return tuple(kept)
