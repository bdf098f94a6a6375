"""Inertia and Coriolis terms as linear maps, so that they can be had as matrices.

No derivative of M is formed. A body with spatial velocity V = (omega, v), about its link origin and
in link axes, has the inertia matrix I = [[J, h x], [-h x, m E]], with J about the origin and
h = m c. It needs the wrench I V' + B(omega) V, where

    B(omega) = [[(tr(J) omega / 2 - J omega) x,  h x omega x], [-omega x h x,  m omega x]]

is skew-symmetric and B(omega) V the Coriolis and centrifugal wrench. It is the one choice of that
kind for which the sum over the bodies is the matrix of Christoffel symbols of M: Echeandia and
Wensing (2021), doi 10.1115/1.4051169, written for link axes. V' is the rate of the components of V
in link axes.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..algebra.scalar import Scalar, Scalars
from ..algebra.vector import ZERO3, Vector, add, cross, matvec, scale, sub, trace, transpose
from ..mechanism.tree import Body
from .spanning import TreeDynamics, Wrench, total

Twist = tuple[Vector, Vector]  # angular velocity, linear velocity of the link origin, in link axes


def body_twists(tree: TreeDynamics, rates: Scalars) -> list[Twist]:
    """Velocity of every body for rates of s (n_s,)."""
    twists: list[Twist] = []
    for i, body in enumerate(tree.tree.bodies):
        twist: Twist = (ZERO3, ZERO3)
        if body.parent >= 0:
            twist = _at_joint(tree, i, twists[body.parent])
        twists.append(_with_joint(body, twist, rates[body.coordinate]))
    return twists


def twist_rates(
    tree: TreeDynamics,
    ds: Scalars,
    twists: Sequence[Twist],
    accelerations: Scalars,
) -> list[Twist]:
    """Rates of the components of some twists.

    With the twists of s' and with s'' this is the spatial acceleration of the bodies.

    Args:
        tree: the tree, which moves with s'.
        ds: s' (n_s,).
        twists: of rates that change with `accelerations`.
        accelerations: (n_s,).
    """
    rates: list[Twist] = []
    for i, body in enumerate(tree.tree.bodies):
        alpha, accel = ZERO3, ZERO3
        if body.parent >= 0:
            alpha, accel = _at_joint(tree, i, rates[body.parent])
            omega, v = _at_joint(tree, i, twists[body.parent])
            rate = scale(ds[body.coordinate], body.axis)
            if body.is_revolute:
                accel = add(accel, cross(v, rate))
                alpha = add(alpha, cross(omega, rate))
            else:
                accel = add(accel, cross(omega, rate))
        rates.append(_with_joint(body, (alpha, accel), accelerations[body.coordinate]))
    return rates


def tree_forces(
    tree: TreeDynamics,
    ds: Scalars,
    rates: Scalars,
    accelerations: Scalars,
) -> list[Scalar]:
    """M(s) a + C(s, s') r along s, for any rates r and accelerations a, all (n_s,)."""
    velocities = body_twists(tree, ds)
    twists = body_twists(tree, rates)
    changes = twist_rates(tree, ds, twists, accelerations)
    wrenches: list[Wrench] = []
    parts = zip(tree.tree.bodies, velocities, twists, changes, strict=True)
    for body, (omega, _), twist, change in parts:
        inertial = momentum(body, change)
        wrenches.append(total(inertial, coriolis(body, omega, twist)))
    return tree.along_joints(tree.transmitted(wrenches))


def momentum(body: Body, twist: Twist) -> Wrench:
    """I V: linear and angular momentum, or, of an acceleration, the wrench."""
    omega, v = twist
    h = body.first_moment
    linear = sub(scale(body.mass, v), cross(h, omega))
    return linear, add(matvec(body.inertia, omega), cross(h, v))


def coriolis(body: Body, omega: Vector, twist: Twist) -> Wrench:
    """B(omega) V of this module's head."""
    turning, v = twist
    h = body.first_moment
    half = scale(0.5 * trace(body.inertia), omega)
    of_mass = scale(body.mass, cross(omega, v))
    of_moment = cross(omega, cross(h, turning))
    force = sub(of_mass, of_moment)
    gyroscopic = cross(sub(half, matvec(body.inertia, omega)), turning)
    return force, add(gyroscopic, cross(h, cross(omega, v)))


def _at_joint(tree: TreeDynamics, body: int, twist: Twist) -> Twist:
    """A twist of the parent, about the child's origin and in its axes."""
    omega, v = twist
    rotation, origin = tree.transforms[body]
    to_child = transpose(rotation)
    at_origin = add(v, cross(omega, origin))
    return matvec(to_child, omega), matvec(to_child, at_origin)


def _with_joint(body: Body, twist: Twist, rate: Scalar) -> Twist:
    """A twist with that of the body's joint."""
    omega, v = twist
    motion = scale(rate, body.axis)
    if body.is_revolute:
        return add(omega, motion), v
    return omega, add(v, motion)
