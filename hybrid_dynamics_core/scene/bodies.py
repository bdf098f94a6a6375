"""Bodies of links: bars, plates, posts on plates, and cylinders with rods."""

from __future__ import annotations

from itertools import combinations
from typing import Final

import numpy as np
from scipy.spatial import ConvexHull

from ..ground.arrays import Array
from .attach import Attached, CylinderShape, rail
from .parts import Part, PartRole, axis_segment
from .points import distinct, ends_of_line, span_dimension
from .skeleton import PlacedJoint

_POST: Final = 3.0  # [radii of a joint] shorter posts are left out
_ON_PLATE: Final = 1e-12  # [m] distance to a plate's corner below which there is no post

Shape = tuple[PartRole, Array]  # role and points (k, 3) [m] of a piece of a body


def link_parts(
    link: str,
    attached: Attached,
    joint_radius: float,
    size: float,
) -> list[Part]:
    """The body of a moving link.

    Args:
        link: its name.
        attached: its points and cylinders.
        joint_radius: radius of a joint in the drawing [m].
        size: size of the mechanism [m].

    Returns:
        Its parts, cylinders last.
    """
    barrels = [_barrel(link, cylinder, joint_radius) for cylinder in attached.barrels]
    rods = [_rod(link, cylinder, joint_radius) for cylinder in attached.rods]
    cylinders = barrels + rods
    inside = attached.inside
    fixed = distinct(attached.fixed, size)
    everything = distinct(attached.fixed + attached.ends, size)
    reached = distinct([*everything, *inside], size)
    # all points are inside cylinders: these are the body
    if cylinders and len(reached) == len(distinct(inside, size)):
        return cylinders
    shapes = body_shapes(fixed, everything, joint_radius)
    return [_body(link, role, points, joint_radius) for role, points in shapes] + cylinders


def _body(
    link: str,
    role: PartRole,
    points: Array,
    joint_radius: float,
) -> Part:
    return Part(
        owner=f"link:{link}",
        role=role,
        points=points,
        radius=0.72 * joint_radius,
        links=(link,),
    )


def _barrel(link: str, cylinder: CylinderShape, joint_radius: float) -> Part:
    return Part(
        owner=f"link:{link}",
        role="barrel",
        points=np.stack([cylinder.foot, cylinder.mouth]),
        radius=1.2 * joint_radius,
        axis=cylinder.direction,
        links=(link,),
    )


def _rod(link: str, cylinder: CylinderShape, joint_radius: float) -> Part:
    return Part(
        owner=f"link:{link}",
        role="rod",
        points=np.stack([cylinder.mouth, cylinder.end]),
        radius=0.45 * joint_radius,
        axis=cylinder.direction,
        links=(link, cylinder.joint.parent),
    )


def body_shapes(fixed: Array, everything: Array, joint_radius: float) -> list[Shape]:
    """A body as plates and bars.

    If many `fixed` points lie in one plane, it is a plate with posts, otherwise a polyhedron.

    Args:
        fixed: (k, 3) points of joints and closures [m].
        everything: (m, 3) these points and those of frames [m].
        joint_radius: radius of a joint in the drawing [m].

    Returns:
        Role and points of each piece.
    """
    dimension = span_dimension(everything)
    if dimension < 2:
        return [("bar", ends_of_line(everything))]
    if dimension == 2:
        return [("plate", everything)]
    plate = _largest_plane(fixed)
    if len(plate) < 4:
        faces = ConvexHull(everything).simplices
        return [("plate", everything[corners]) for corners in faces]
    shapes: list[Shape] = [("plate", plate)]
    centre = plate.mean(axis=0)
    for point in everything:
        to_plate = np.linalg.norm(plate - point, axis=1).min()
        length = np.linalg.norm(point - centre)
        if to_plate > _ON_PLATE and length > _POST * joint_radius:
            post = np.stack([centre, point])
            shapes.append(("bar", post))
    return shapes


def _largest_plane(points: Array) -> Array:
    """The largest subset of points in one plane."""
    if span_dimension(points) < 3:
        return points
    planes = [_in_plane(points, three) for three in combinations(points, 3)]
    return np.array(max(planes, key=len))


def _in_plane(points: Array, three: tuple[Array, ...]) -> list[Array]:
    """The points that lie in the plane of three."""
    inside = []
    for point in points:
        four = np.array([*three, point])
        if span_dimension(four) < 3:
            inside.append(point)
    return inside


def slide_parts(joint: PlacedJoint, joint_radius: float) -> list[Part]:
    """A prismatic joint that is no cylinder: a block on a rail."""
    owner = f"joint:{joint.name}"
    beyond = np.outer([-3.0 * joint_radius, 3.0 * joint_radius], joint.axis)
    rail_part = Part(
        owner=owner,
        role="rail",
        points=rail(joint) + beyond,
        radius=0.4 * joint_radius,
        axis=joint.axis,
        links=(joint.parent,),
    )
    block = Part(
        owner=owner,
        role="block",
        points=axis_segment(joint.point, joint.axis, 1.7 * joint_radius),
        radius=1.2 * joint_radius,
        axis=joint.axis,
        links=(joint.child,),
    )
    return [rail_part, block]
