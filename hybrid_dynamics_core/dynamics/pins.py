"""The wrench that a closure transmits, whatever equations close its loop.

The closure's multipliers give generalised forces along the joints of its loop. The wrench has the
same virtual work. It is determined only in directions that the closure constrains and in which the
loop's joints do work. The joints of a planar loop never move its pin along the normal. So a force
along the normal is undetermined.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..algebra.definite import Definite
from ..algebra.independence import independent_rows
from ..algebra.scalar import Scalar
from ..algebra.vector import ZERO3, Rotation, Vector, add, constant, dot, matvec, scale
from ..closure.closed_motion import ClosedMotion
from ..closure.constraints.plane import plane_basis
from ..closure.constraints.spatial import chains_length, closure_chains
from ..closure.numeric_closure import fixed_perturbation
from ..closure.plan import ClosurePlan
from ..description.model import Closure
from ..ground.arrays import Array
from ..mechanism.configuration import Configuration
from ..mechanism.tree import Tree, rows
from .spanning import TreeDynamics

Work = list[dict[int, Scalar]]  # for each direction, by coordinate

INDEPENDENT = 1e-7  # least share of a direction's work that is independent of the directions before
NEGLIGIBLE = 1e-30  # share far below the rounding of any determined one
MOVES = (
    0.0,
    0.07,
    -0.11,
)  # [rad or m] away from the reference, which may be symmetric
TINY = 1e-300

# directions: a force along x, y, z of the pin, then a moment about them
DIRECTIONS = tuple(range(6))
_PLANAR_FORCE = (0, 1)
_FORCE = (0, 1, 2)
_HELD = {
    "planar": _PLANAR_FORCE,
    "point": _FORCE,
    "axis": (*_FORCE, 3, 4),
    "frame": (*_FORCE, 3, 4, 5),
}
_OUT_OF_PLANE = (2, 3, 4)
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
    """A closure's place and axes, and the directions in which its wrench is determined.

    Attributes:
        name: name of the closure.
        body_a: body of link a, -1 for the base.
        point_a: the pin on it (3,) [m].
        body_b: body of link b, -1 for the base.
        point_b: the pin on it (3,) [m].
        axes: rows in link a's frame. The third one is the normal of a planar loop, otherwise the
            closure's z axis.
        length: typical of the loop [m].
        loop: coordinates of the loop's joints.
        borne: indices of the determined directions, of six.
        silent: names of undetermined directions, in which either the closure or the joints of its
            loop may bear the load.
    """

    name: str
    body_a: int
    point_a: Vector
    body_b: int
    point_b: Vector
    axes: Rotation
    length: float
    loop: frozenset[int]
    borne: tuple[int, ...]
    silent: tuple[str, ...]

    def work(self, tree: TreeDynamics) -> Work:
        """Work of a unit wrench on link a, against b, per unit rate of each joint.

        One entry for each direction in `borne`. Moments are divided by `length`.
        """
        rotation = self._rotation(tree)
        place_a, place_b = self.ends(tree)
        work: Work = [{} for _ in self.borne]
        sides = (
            (1.0, self.body_a, place_a),
            (-1.0, self.body_b, place_b),
        )
        for sign, body, place in sides:
            for k, (linear, angular) in tree.jacobian(body, place).items():
                if k not in self.loop:
                    continue
                for row, direction in zip(work, self.borne, strict=True):
                    moved = linear
                    if direction not in _FORCE:
                        moved = scale(self.length, angular)
                    row[k] = sign * dot(rotation[direction % 3], moved)
        return work

    def wrench(
        self, tree: TreeDynamics, generalised: Mapping[int, Scalar]
    ) -> tuple[Vector, Vector, Scalar]:
        """The wrench on link a that gives some generalised forces.

        Args:
            tree: the tree at a configuration.
            generalised: forces along the joints of the loop, by coordinate.

        Returns:
            Force and moment about the pin in base axes, and how well they are determined: the
            determinant of the system, 1 at best, 0 where the wrench is undefined.
        """
        work = self.work(tree)
        products = [_products(row, work) for row in work]
        diagonal = [row[k] for k, row in enumerate(products)]
        size = sum(diagonal, 0.0) / max(len(products), 1)
        gram = Definite(products, NEGLIGIBLE * size)
        parts = gram.solve([_product(row, generalised) for row in work])
        rotation = self._rotation(tree)
        force, moment = ZERO3, ZERO3
        for direction, part in zip(self.borne, parts, strict=True):
            axis = rotation[direction % 3]
            if direction in _FORCE:
                force = add(force, scale(part, axis))
            else:
                moment = add(moment, scale(self.length * part, axis))
        share: Scalar = 1.0
        for pivot in gram.pivots:
            share = share * (pivot / size)
        return force, moment, share

    def ends(self, tree: TreeDynamics) -> tuple[Vector, Vector]:
        """The pin's place on both links (3,) [m], in the base frame."""
        rotation_a, origin_a = tree.pose(self.body_a)
        rotation_b, origin_b = tree.pose(self.body_b)
        place_a = add(origin_a, matvec(rotation_a, self.point_a))
        return place_a, add(origin_b, matvec(rotation_b, self.point_b))

    def _rotation(self, tree: TreeDynamics) -> Rotation:
        """The pin's axes as rows, in base axes."""
        rotation, _ = tree.pose(self.body_a)
        x, y, z = (matvec(rotation, axis) for axis in self.axes)
        return x, y, z


def _products(a: Mapping[int, Scalar], work: Work) -> list[Scalar]:
    return [_product(a, b) for b in work]


def _product(a: Mapping[int, Scalar], b: Mapping[int, Scalar]) -> Scalar:
    total: Scalar = 0.0
    for k, value in a.items():
        if k in b:
            total = total + value * b[k]
    return total


def find_pins(tree: Tree, plan: ClosurePlan, closures: Sequence[Closure]) -> list[Pin]:
    """The pins of all closures, in their order."""
    configurations = _closed_configurations(tree, plan)
    return [_pin(tree, closure, configurations) for closure in closures]


def moved_pins(pins: Sequence[Pin], tree: Tree, closures: Sequence[Closure]) -> list[Pin]:
    """The same pins in a tree of the same structure with other numbers."""
    moved: list[Pin] = []
    for pin, closure in zip(pins, closures, strict=True):
        axes, _ = _axes(tree, closure)
        other = _pin_of_all_directions(tree, closure, axes)
        moved.append(replace(other, borne=pin.borne, silent=pin.silent))
    return moved


def _pin(tree: Tree, closure: Closure, configurations: Sequence[Configuration]) -> Pin:
    """The pin of a closure; its determined directions are found at some configurations."""
    axes, silent = _axes(tree, closure)
    held = _HELD[closure.kind]
    pin = _pin_of_all_directions(tree, closure, axes)
    borne: tuple[int, ...] = ()
    for configuration in configurations:
        at_place = TreeDynamics(tree, configuration)
        work = _matrix(pin.work(at_place), len(tree.coordinates))
        largest = float(np.abs(work).max(initial=0.0))
        least = INDEPENDENT * max(largest, TINY)
        independent = tuple(independent_rows(work, held, least))
        if len(independent) > len(borne):
            borne = independent
    unsettled = sorted({*silent, *held} - set(borne))
    return replace(pin, borne=borne, silent=tuple(_NAMES[k] for k in unsettled))


def _axes(tree: Tree, closure: Closure) -> tuple[Rotation, tuple[int, ...]]:
    """Axes of a pin as rows in link a's frame, and undetermined directions of a planar loop."""
    a = tree.body_index(closure.link_a)
    path_a, path_b, ancestor = tree.branches(a, tree.body_index(closure.link_b))
    try:
        basis = plane_basis(tree, path_a + path_b, ancestor)
    except ValueError:
        return rows(closure.rotation_a.T), ()
    rotation, _ = tree.zero_pose(a, ancestor)
    return rows(basis @ rotation), _OUT_OF_PLANE


def _pin_of_all_directions(tree: Tree, closure: Closure, axes: Rotation) -> Pin:
    a = tree.body_index(closure.link_a)
    b = tree.body_index(closure.link_b)
    path_a, path_b, _ = tree.branches(a, b)
    return Pin(
        name=closure.name,
        body_a=a,
        point_a=constant(closure.point_a),
        body_b=b,
        point_b=constant(closure.point_b),
        axes=axes,
        length=chains_length(*closure_chains(tree, closure)),
        loop=frozenset(tree.bodies[i].coordinate for i in path_a + path_b),
        borne=DIRECTIONS,
        silent=(),
    )


def _closed_configurations(tree: Tree, plan: ClosurePlan) -> list[Configuration]:
    """The reference configuration, and others around it that close."""
    reference = np.array(plan.reference.q, dtype=float)
    given = list(plan.given)
    configurations: list[Configuration] = []
    for size in MOVES:
        u = reference[given] + size * fixed_perturbation(len(given))
        try:
            motion = ClosedMotion(tree, plan, u.tolist(), plan.signs, reference.tolist())
        except ZeroDivisionError:
            continue
        if all(block.margin > 0.0 for block in motion.blocks):
            configurations.append(motion.configuration)
    return configurations


def _matrix(work: Work, size: int) -> Array:
    """The work as an array (directions, coordinates)."""
    matrix = np.zeros((len(work), size))
    for direction, row in enumerate(work):
        for k, value in row.items():
            matrix[direction, k] = float(value)
    return matrix
