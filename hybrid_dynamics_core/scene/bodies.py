"""Links as bodies between what they carry: bars, plates, posts on plates, and cylinders with rods."""

from __future__ import annotations

from itertools import combinations
from typing import Final

import numpy as np
from scipy.spatial import ConvexHull

from ..ground.arrays import Array
from .attach import Attached, rail
from .parts import Part, Role, stub
from .points import distinct, ends_of, rank
from .skeleton import PlacedJoint

_POST: Final = 3.0  # radii of a joint: shorter posts are left out


def link_parts(link: str, what: Attached, unit: float, size: float) -> list[Part]:
    """The body of a moving link; `unit` is the radius of a joint in the drawing [m]."""
    owner = f"link:{link}"
    parts = [
        Part(owner, "barrel", np.stack([c.foot, c.mouth]), 1.2 * unit, c.along, (link,))
        for c in what.barrels
    ]
    parts += [
        Part(owner, "rod", np.stack([c.mouth, c.end]), 0.45 * unit, c.along, (link, c.joint.parent))
        for c in what.rods
    ]
    inside = [c.foot for c in what.barrels] + [c.end for c in what.rods]
    fixed = distinct(what.fixed, size)
    everything = distinct([*what.fixed, *what.ends], size)
    if parts and len(distinct([*everything, *inside], size)) == len(distinct(inside, size)):
        return parts
    return [
        Part(owner, role, points, 0.72 * unit, None, (link,))
        for role, points in shapes(fixed, everything, unit)
    ] + parts


def shapes(fixed: Array, everything: Array, unit: float) -> list[tuple[Role, Array]]:
    """Points (k, 3) of a body as plates and bars: [(role, points), ...].

    A plate with posts where many `fixed` points lie in one plane, otherwise the faces of a solid.
    """
    if rank(everything) < 2:
        return [("bar", ends_of(everything))]
    if rank(everything) == 2:
        return [("plate", everything)]
    plate = _plate(fixed)
    if len(plate) < 4:
        return [("plate", everything[corners]) for corners in ConvexHull(everything).simplices]
    centre = plate.mean(axis=0)
    posts = [
        np.stack([centre, p]) for p in everything if np.linalg.norm(plate - p, axis=1).min() > 1e-12
    ]
    tall = [post for post in posts if np.linalg.norm(post[1] - post[0]) > _POST * unit]
    return [("plate", plate), *(("bar", post) for post in tall)]


def _plate(points: Array) -> Array:
    """The most points that lie in one plane."""
    if rank(points) < 3:
        return points
    planes = [
        [p for p in points if rank(np.array([*three, p])) < 3] for three in combinations(points, 3)
    ]
    return np.array(max(planes, key=len))


def slide_parts(joint: PlacedJoint, unit: float) -> list[Part]:
    """A prismatic joint that is no cylinder: a block on a rail."""
    ends = rail(joint) + np.outer([-3.0 * unit, 3.0 * unit], joint.axis)
    owner = f"joint:{joint.name}"
    return [
        Part(owner, "rail", ends, 0.4 * unit, joint.axis, (joint.parent,)),
        Part(
            owner,
            "block",
            stub(joint.point, joint.axis, 1.7 * unit),
            1.2 * unit,
            joint.axis,
            (joint.child,),
        ),
    ]
