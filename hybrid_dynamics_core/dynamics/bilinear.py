"""Inertia and Coriolis terms that are linear in a second motion, as matrices need them.

No derivative of M is formed. A body has the spatial velocity V = (omega, v): its angular velocity
and the velocity of its link origin, in link axes. Its inertia matrix about that origin is

    I = [[J, h x], [-h x, m E]],

with J the inertia about the origin, m the mass, and h = m c its first moment. Let V' be the rate of
the components of V in link axes. The body then needs the wrench I V' + B(omega) V, where

    B(omega) = [[(tr(J) omega / 2 - J omega) x,  h x omega x], [-omega x h x,  m omega x]].

B(omega) is skew-symmetric, and B(omega) V is the Coriolis and centrifugal wrench. Other matrices B
give the same wrench. With this one the sum over the bodies is the matrix of Christoffel symbols of
M: Echeandia and Wensing (2021), doi 10.1115/1.4051169, here in link axes.

Mind the order of components. The formulas have angular before linear: their rows are moment, force.
In the code a Twist is (angular, linear) and a Wrench is (force, moment).
"""

from __future__ import annotations

from collections.abc import Sequence

from ..algebra.scalar import Scalar, Scalars
from ..algebra.vector import ZERO3, Vector, add, cross, matvec, scale, sub, trace, transpose
from ..mechanism.tree import Body
from .spanning import TreeDynamics, Wrench, total

# angular velocity [rad/s] and linear velocity of the link origin [m/s], in link axes
Twist = tuple[Vector, Vector]


def body_twists(tree: TreeDynamics, rates: Scalars) -> list[Twist]:
    """Velocity of every body relative to the base.

    Args:
        tree: the tree at its configuration.
        rates: any rates of s (n_s,) [rad/s, m/s].

    Returns:
        A twist for each body.
    """
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
    """Time derivatives of twists of rates r, by component in link axes that move with s'.

    With r = s' and r' = s'' they are the V' of the bodies.

    Args:
        tree: the tree at its configuration.
        ds: s' (n_s,) [rad/s, m/s], with which the tree moves.
        twists: twists of r, as `body_twists` gives them.
        accelerations: r' (n_s,) [rad/s^2, m/s^2].

    Returns:
        For each body, the rates of the angular [rad/s^2] and the linear components [m/s^2].
    """
    rates: list[Twist] = []
    for i, body in enumerate(tree.tree.bodies):
        alpha, accel = ZERO3, ZERO3
        if body.parent >= 0:
            alpha, accel = _at_joint(tree, i, rates[body.parent])
            omega, v = _at_joint(tree, i, twists[body.parent])
            rate = scale(ds[body.coordinate], body.axis)
            if body.is_revolute:
                # the link axes turn relative to the parent's: a constant vector v of the parent has
                # components that change by v x rate
                accel = add(accel, cross(v, rate))
                alpha = add(alpha, cross(omega, rate))
            else:
                # the link origin moves through the parent, whose velocity there is v + omega x r
                accel = add(accel, cross(omega, rate))
        rates.append(_with_joint(body, (alpha, accel), accelerations[body.coordinate]))
    return rates


def tree_forces(
    tree: TreeDynamics,
    ds: Scalars,
    rates: Scalars,
    accelerations: Scalars,
) -> list[Scalar]:
    """M(s) a + C(s, s') r along s, for any rates r and accelerations a.

    Gravity, friction, springs and rotors are left out.

    Args:
        tree: the tree at its configuration s.
        ds: s' (n_s,) [rad/s, m/s].
        rates: r (n_s,) [rad/s, m/s].
        accelerations: a (n_s,) [rad/s^2, m/s^2].

    Returns:
        Forces along s (n_s,) [N m, N].
    """
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
    """I V about the link origin, in link axes.

    Args:
        body: the body.
        twist: V, or V' as `twist_rates` gives it.

    Returns:
        Linear [kg m/s] and angular momentum [kg m^2/s]. For V' they are force [N] and moment [N m].
    """
    omega, v = twist
    h = body.first_moment
    linear = sub(scale(body.mass, v), cross(h, omega))
    angular = add(matvec(body.inertia, omega), cross(h, v))
    return linear, angular


def coriolis(body: Body, omega: Vector, twist: Twist) -> Wrench:
    """B(omega) V about the link origin, in link axes.

    Args:
        body: the body.
        omega: angular velocity (3,) [rad/s] of the motion s'.
        twist: V, of s' or of any other rates.

    Returns:
        Force [N] and moment [N m].
    """
    angular, linear = twist
    h = body.first_moment
    half_trace = scale(0.5 * trace(body.inertia), omega)
    from_mass = scale(body.mass, cross(omega, linear))
    from_first_moment = cross(omega, cross(h, angular))
    force = sub(from_mass, from_first_moment)
    gyroscopic = cross(sub(half_trace, matvec(body.inertia, omega)), angular)
    moment = add(gyroscopic, cross(h, cross(omega, linear)))
    return force, moment


def _at_joint(tree: TreeDynamics, body: int, twist: Twist) -> Twist:
    """A twist of a body's parent, at the body's origin and in its axes."""
    omega, v = twist
    rotation, origin = tree.transforms[body]
    to_body = transpose(rotation)
    at_origin = add(v, cross(omega, origin))
    return matvec(to_body, omega), matvec(to_body, at_origin)


def _with_joint(body: Body, twist: Twist, rate: Scalar) -> Twist:
    """The sum of a twist and that of the body's joint, which moves at a rate [rad/s or m/s]."""
    omega, v = twist
    motion = scale(rate, body.axis)
    if body.is_revolute:
        return add(omega, motion), v
    return omega, add(v, motion)
