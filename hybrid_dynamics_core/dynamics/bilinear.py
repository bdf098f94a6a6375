"""Inertia and Coriolis terms as linear maps, so that they can be had as matrices: no derivative of M is formed.

A body with spatial velocity V = (omega, v), about its link origin and in link axes, and with
inertia matrix I = [[J, h x], [-h x, m E]] (J about the origin, h = m c) needs the wrench I V' +
B(omega) V, where

    B(omega) = [[(tr(J) omega / 2 - J omega) x,  h x omega x], [-omega x h x,  m omega x]]

is skew-symmetric and B(omega) V the Coriolis and centrifugal wrench. It is the one choice of that
kind for which the sum over the bodies is the matrix of Christoffel symbols of M: Echeandia and
Wensing (2021), doi 10.1115/1.4051169, written for link axes. V' is the rate of the components of V
in link axes.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..algebra.scalar import Scalar
from ..algebra.vector import ZERO3, Vector, add, cross, matvec, scale, sub, transpose
from ..mechanism.tree import Body
from .spanning import TreeDynamics, Wrench

Twist = tuple[Vector, Vector]  # angular velocity, linear velocity of the link origin, in link axes


def body_twists(tree: TreeDynamics, rates: Sequence[Scalar]) -> list[Twist]:
    """Velocity of every body for rates of s."""
    twists: list[Twist] = []
    for i, b in enumerate(tree.tree.bodies):
        omega, v = _at_joint(tree, i, twists[b.parent]) if b.parent >= 0 else (ZERO3, ZERO3)
        twists.append(_plus(b, (omega, v), rates[b.coordinate]))
    return twists


def twist_rates(
    tree: TreeDynamics,
    ds: Sequence[Scalar],
    twists: Sequence[Twist],
    accelerations: Sequence[Scalar],
) -> list[Twist]:
    """Rate of the components of `twists` while the tree moves with s' and the rates behind them with `accelerations`.

    With the twists of s' and with s'' this is the spatial acceleration of the bodies.
    """
    result: list[Twist] = []
    for i, b in enumerate(tree.tree.bodies):
        alpha, accel = ZERO3, ZERO3
        if b.parent >= 0:
            alpha, accel = _at_joint(tree, i, result[b.parent])
            omega, v = _at_joint(tree, i, twists[b.parent])
            step = scale(ds[b.coordinate], b.axis)
            accel = add(accel, cross(v if b.type == "revolute" else omega, step))
            alpha = add(alpha, cross(omega, step)) if b.type == "revolute" else alpha
        result.append(_plus(b, (alpha, accel), accelerations[b.coordinate]))
    return result


def tree_forces(
    tree: TreeDynamics,
    ds: Sequence[Scalar],
    rates: Sequence[Scalar],
    accelerations: Sequence[Scalar],
) -> list[Scalar]:
    """M(s) a + C(s, s') r along s, for any rates r and accelerations a."""
    own = body_twists(tree, ds)
    twists = body_twists(tree, rates)
    wrenches = []
    for b, (omega, _), twist, rate in zip(
        tree.tree.bodies, own, twists, twist_rates(tree, ds, twists, accelerations), strict=True
    ):
        (f1, m1), (f2, m2) = momentum(b, rate), coriolis(b, omega, twist)
        wrenches.append((add(f1, f2), add(m1, m2)))
    return tree.along_joints(tree.transmitted(wrenches))


def momentum(b: Body, twist: Twist) -> Wrench:
    """I V: linear and angular momentum, or, of an acceleration, the wrench."""
    omega, v = twist
    linear = sub(scale(b.mass, v), cross(b.first_moment, omega))
    return linear, add(matvec(b.inertia, omega), cross(b.first_moment, v))


def coriolis(b: Body, omega: Vector, twist: Twist) -> Wrench:
    """B(omega) V of this module's head."""
    turning, v = twist
    half = scale(0.5 * (b.inertia[0][0] + b.inertia[1][1] + b.inertia[2][2]), omega)
    force = sub(scale(b.mass, cross(omega, v)), cross(omega, cross(b.first_moment, turning)))
    moment = add(
        cross(sub(half, matvec(b.inertia, omega)), turning), cross(b.first_moment, cross(omega, v))
    )
    return force, moment


def _at_joint(tree: TreeDynamics, body: int, twist: Twist) -> Twist:
    """A twist of the parent, about the child's origin and in its axes."""
    omega, v = twist
    rotation, origin = tree.transforms[body]
    to_child = transpose(rotation)
    return matvec(to_child, omega), matvec(to_child, add(v, cross(omega, origin)))


def _plus(b: Body, twist: Twist, rate: Scalar) -> Twist:
    omega, v = twist
    own = scale(rate, b.axis)
    return (add(omega, own), v) if b.type == "revolute" else (omega, add(v, own))
