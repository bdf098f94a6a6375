"""Mass and inertia of a whole mechanism, independent of the choice of link frames."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..ground.arrays import Array
from .configuration import Configuration
from .joint_transform import joint_transforms, poses_in_base
from .tree import Body, Tree


def total_mass(tree: Tree) -> float:
    """Mass of all moving links [kg]."""
    return sum(body.mass for body in tree.bodies)


def total_inertia(tree: Tree, configuration: Configuration) -> float:
    """The largest inertia of all moving links together about any hinge.

    Each link adds the trace of its inertia about its centre of mass. So the result depends neither
    on the place of the base, nor on where a hinge's frame lies along its axis.

    Args:
        tree: the spanning tree.
        configuration: all coordinates, as floats.

    Returns:
        The inertia [kg m^2].
    """
    poses = poses_in_base(tree, joint_transforms(tree, configuration))
    central = sum(_central_moments(body) for body in tree.bodies)
    centres: list[Array] = []
    for body, (rotation, origin) in zip(tree.bodies, poses, strict=True):
        centres.append(np.array(rotation) @ _centre(body) + np.array(origin))
    largest = central
    for body, (rotation, origin) in zip(tree.bodies, poses, strict=True):
        if body.is_revolute:
            axis = np.array(rotation) @ np.array(body.axis)
            about_axis = central + _of_points(tree.bodies, centres, np.array(origin), axis)
            largest = max(largest, about_axis)
    return largest


def _of_points(
    bodies: Iterable[Body], centres: Iterable[Array], origin: Array, axis: Array
) -> float:
    """Inertia of the links as points at their centres of mass, about an axis [kg m^2]."""
    inertia = 0.0
    for body, centre in zip(bodies, centres, strict=True):
        arm = np.cross(axis, centre - origin)
        inertia += body.mass * float(arm @ arm)
    return inertia


def _centre(body: Body) -> Array:
    """Centre of mass (3,) [m], in the link frame."""
    return np.array(body.first_moment) / (body.mass or 1.0)


def _central_moments(body: Body) -> float:
    """Sum of the three moments of inertia about the centre of mass [kg m^2]."""
    centre = _centre(body)
    about_origin = float(np.trace(np.array(body.inertia)))
    return max(about_origin - 2.0 * body.mass * float(centre @ centre), 0.0)
