"""How generalised forces and multipliers change with displacements of a loaded robot.

A place moves by a product of exponentials of joints and deformations, from the base to the tip. So
a displacement j turns the twist of i if it is nearer to the base. With the displacement d_i of a
point per unit of i, and its turn w_i,

    d^2 x / dq_i dq_j = w_j x d_i, where j carries i.

Deformations of one spring are those of one exponential: each carries the other by half.
"""

from __future__ import annotations

import numpy as np

from ...ground.arrays import Array
from ..attachments import Key
from ..equations import HeldClosure
from ..load_columns import Acting
from ..posed_tree import skew
from ..structure import Structure


def carrying(order: Array) -> Array:
    """How much (n, n) coordinate j carries coordinate i: one, zero, or half."""
    nearer = np.sign(order[:, None] - order[None, :])
    carried: Array = 0.5 * (1.0 + nearer)
    return carried


def change_of_wrench(carried: Array, acting: Acting) -> Array:
    """Generalised force i of a wrench, by displacement j (n, n).

    Args:
        carried: of `carrying`.
        acting: the wrench. Its force follows its place, in constant directions or in those of the
            place.
    """
    angular = acting.twists[3:]
    change = curvature_along(carried, acting.twists, acting.place, acting.force)
    turning = angular.T @ skew(acting.moment) @ angular
    change += carried * turning
    if acting.turns:
        linear = displaced(acting.twists, acting.place)
        change -= linear.T @ skew(acting.force) @ angular + turning
    return change


def change_of_closure(
    structure: Structure, carried: Array, one: HeldClosure, multipliers: Array
) -> Array:
    """Gap of a closure along its multipliers: second derivatives (n, n).

    The axes of the pin are fixed to its link a. The turn is the antisymmetric part of the rotation.

    Args:
        structure: the elastic structure.
        carried: of `carrying`.
        one: the closure.
        multipliers: of the directions that it holds.
    """
    closure, held = one
    key: Key = ("closure", closure.name)
    tree = structure.posed.tree
    a = structure.places[tree.body_index(closure.link_a), key]
    b = structure.places[tree.body_index(closure.link_b), key]
    pin = structure.posed.pin_pose(closure)
    wrench = held.rows.T @ multipliers
    force = pin.rotation @ wrench[:3]
    moment = pin.rotation @ wrench[3:]
    change = curvature_along(carried, a, pin.origin, force)
    change -= curvature_along(carried, b, pin.origin, force)
    gap = displaced(a - b, pin.origin)
    axes = (skew(force) @ a[3:]).T @ gap
    change -= axes + axes.T
    turned = _turned(carried, a, moment) - _turned(carried, b, moment)
    between = a[3:].T @ skew(moment) @ b[3:]
    change += 0.5 * (turned - between - between.T)
    return change


def curvature_along(carried: Array, twists: Array, place: Array, force: Array) -> Array:
    """Second derivatives (n, n) of a place (3,) along a force (3,)."""
    linear = displaced(twists, place)
    product = carried * (linear.T @ skew(force) @ twists[3:])
    both: Array = product + product.T
    return both


def displaced(twists: Array, place: Array) -> Array:
    """Displacements (3, n) of a place by twists about the base origin."""
    moved: Array = twists[:3] - skew(place) @ twists[3:]
    return moved


def _turned(carried: Array, twists: Array, moment: Array) -> Array:
    """Second derivatives (n, n) of twice the antisymmetric part of a rotation, along a moment."""
    angular = twists[3:]
    product = angular.T @ skew(moment) @ angular
    both: Array = (carried - carried.T) * product
    return both
