"""Joint velocities, with the angular velocity of ball and free joints.

Friction and rotors act on angular velocity, not on the rates of three angles. So these rates become
the angular velocity of the child relative to its parent, in child axes. Torques along its
components become forces along the coordinates. All other joints keep their rates.
"""

from __future__ import annotations

from ..algebra.charts import FIRST, Turns, rotation_vector
from ..algebra.scalar import Scalar, Scalars
from ..algebra.vector import ZERO3, add, dot, scale
from .configuration import Configuration
from .tree import Tree


def joint_velocities(tree: Tree, configuration: Configuration, rates: Scalars) -> list[Scalar]:
    """Rates (n_s,) of all joints; three angles of a joint give its angular velocity."""
    result = list(rates)
    for places in tree.turns:
        omega = ZERO3
        for axis, k in zip(_turns(configuration, places).axes(), places, strict=True):
            omega = add(omega, scale(rates[k], axis))
        for k, component in zip(places, omega, strict=True):
            result[k] = component
    return result


def joint_stretches(tree: Tree, configuration: Configuration) -> list[Scalar]:
    """Coordinates (n_s,); three angles of a joint give its rotation vector."""
    result = list(configuration.q)
    for number, places in enumerate(tree.turns):
        chart: Scalar = FIRST
        if configuration.charts:
            chart = configuration.charts[number]
        angles = [configuration.q[k] for k in places]
        for k, component in zip(places, rotation_vector(angles, chart), strict=True):
            result[k] = component
    return result


def joint_bias(
    tree: Tree, configuration: Configuration, first: Scalars, second: Scalars
) -> list[Scalar]:
    """Rate of `joint_velocities` (n_s,) at s'' = 0, as a bilinear form of two rates."""
    result: list[Scalar] = [0.0] * len(first)
    for places in tree.turns:
        pair = [[rates[k] for k in places] for rates in (first, second)]
        for k, value in zip(places, _turns(configuration, places).bias(*pair), strict=True):
            result[k] = value
    return result


def joint_accelerations(
    tree: Tree, configuration: Configuration, dds: Scalars, ds: Scalars, other: Scalars
) -> list[Scalar]:
    """Accelerations (n_s,) of all joints; three angles of a joint give its angular acceleration.

    Args:
        tree: the spanning tree.
        configuration: all coordinates.
        dds: s''.
        ds: s'.
        other: s' again, or another rate: the bias is bilinear in both.
    """
    accelerations = joint_velocities(tree, configuration, dds)
    if not tree.turns:
        return accelerations
    return list(add(accelerations, joint_bias(tree, configuration, ds, other)))


def forces_along(tree: Tree, configuration: Configuration, forces: Scalars) -> list[Scalar]:
    """Forces along s (n_s,) from forces along the components of `joint_velocities`."""
    result = list(forces)
    for places in tree.turns:
        moment = tuple(forces[k] for k in places)
        for axis, k in zip(_turns(configuration, places).axes(), places, strict=True):
            result[k] = dot(axis, moment)
    return result


def _turns(configuration: Configuration, places: tuple[int, int, int]) -> Turns:
    _, b, c = places
    return Turns(configuration.c[b], configuration.s[b], configuration.c[c], configuration.s[c])
