"""The points and cylinders on each link, from which its body is drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from ..ground.arrays import Array
from .groups import JointGroup
from .points import COINCIDENT
from .skeleton import PlacedJoint, Skeleton

_MOUTH = (0.42, 0.66)  # least and largest length of a barrel, as shares of the cylinder's length
_LONGEST = 0.9  # largest share of a barrel in the cylinder's shortest length
_SHORT = 0.02  # share of the mechanism's size below which a cylinder is drawn as a slide
_SMALLEST = 1e-9  # [m] least size of a mechanism


@dataclass(frozen=True, eq=False)
class CylinderShape:
    """A prismatic joint drawn as a barrel and a rod.

    Attributes:
        joint: the prismatic joint.
        foot: (3,) start of the barrel [m].
        end: (3,) end of the rod [m].
        shortest: least distance from foot to end in any configuration [m].
    """

    joint: PlacedJoint
    foot: Array
    end: Array
    shortest: float = np.inf

    @property
    def length(self) -> float:
        """From foot to end [m]."""
        return float(np.linalg.norm(self.end - self.foot))

    @property
    def direction(self) -> Array:
        """(3,) unit vector from foot to end."""
        return (self.end - self.foot) / self.length

    @property
    def mouth(self) -> Array:
        """(3,) end of the barrel [m]; at the joint's zero if that gives a plausible length."""
        length = self.length
        direction = self.direction
        zero = float((self.joint.start - self.foot) @ direction / length)
        suitable = np.clip(zero, *_MOUTH) * length
        barrel = min(suitable, _LONGEST * self.shortest)
        return np.asarray(self.foot + barrel * direction)


@dataclass(eq=False)
class Attached:
    """The points and cylinders on a link.

    Attributes:
        fixed: (3,) points of joints and closures [m].
        ends: (3,) points of frames [m].
        barrels: cylinders whose barrel is on this link.
        rods: cylinders whose rod is on this link.
    """

    fixed: list[Array] = field(default_factory=list)
    ends: list[Array] = field(default_factory=list)
    barrels: list[CylinderShape] = field(default_factory=list)
    rods: list[CylinderShape] = field(default_factory=list)

    @property
    def inside(self) -> list[Array]:
        """(3,) points at which its cylinders are attached [m]."""
        points = [cylinder.foot for cylinder in self.barrels]
        return points + [cylinder.end for cylinder in self.rods]


def attach(skeleton: Skeleton, groups: Sequence[JointGroup]) -> dict[str, Attached]:
    """The points and cylinders of each link, by name."""
    attached = {link: Attached() for link in skeleton.links}
    for group in groups:
        if group.kind not in ("prismatic", "carrier"):
            first, last = group.first, group.last
            attached[first.parent].fixed.append(first.start)
            attached[last.child].fixed.append(last.point)
    for closure in skeleton.closures:
        for link, point in zip(closure.links, closure.points, strict=True):
            attached[link].fixed.append(point)
    for frame in skeleton.frames:
        if frame.link != skeleton.base:
            attached[frame.link].ends.append(frame.point)
    _attach_slides(skeleton, attached, groups)
    return attached


def cylinders_of(attached: Mapping[str, Attached]) -> dict[str, CylinderShape]:
    """Cylinders by the name of their joint."""
    cylinders = {}
    for carried in attached.values():
        for cylinder in carried.barrels:
            cylinders[cylinder.joint.name] = cylinder
    return cylinders


def _attach_slides(
    skeleton: Skeleton, attached: Mapping[str, Attached], groups: Sequence[JointGroup]
) -> None:
    """Add prismatic joints, whose place depends on the other points of their links."""
    for group in groups:
        joint = group.last
        child = attached[joint.child]
        if group.kind == "prismatic":
            _attach_slide(skeleton, joint, attached[joint.parent], child)
        elif group.kind == "carrier" and not child.fixed:
            child.fixed.append(joint.point)


def _attach_slide(
    skeleton: Skeleton,
    joint: PlacedJoint,
    parent: Attached,
    child: Attached,
) -> None:
    """Add a cylinder if parent and child have points on the axis, otherwise a block on a rail."""
    grounded = joint.parent == skeleton.base  # its rail is fixed
    cylinder = None
    if not grounded:
        ends = child.fixed + child.ends
        cylinder = _cylinder(skeleton, joint, parent.fixed, ends)
    if cylinder is not None:
        parent.barrels.append(cylinder)
        child.rods.append(cylinder)
        return
    held = _held_at(joint, grounded)
    parent.fixed.append(joint.start + held * joint.axis)
    child.fixed.append(joint.point)


def _held_at(joint: PlacedJoint, grounded: bool) -> float:
    """Position along its rail [m] at which a slide is attached to its parent."""
    reach = _reach(joint)
    if grounded:
        return 0.5 * (min(reach) + max(reach))
    reach.append(joint.displacement)
    return float(np.clip(0.0, min(reach), max(reach)))


def _cylinder(
    skeleton: Skeleton,
    joint: PlacedJoint,
    feet: Sequence[Array],
    ends: Sequence[Array],
) -> CylinderShape | None:
    """The joint as a cylinder between the two points on its axis that are farthest apart.

    None if parent and child have no points on the axis.
    """
    size = mechanism_size(skeleton)
    feet = [foot for foot in feet if _is_on_axis(foot, joint, size)]
    ends = [end for end in ends if _is_on_axis(end, joint, size)]
    cylinders = [CylinderShape(joint, foot, end) for foot, end in product(feet, ends)]
    if not cylinders:
        return None
    longest = max(cylinders, key=lambda cylinder: cylinder.length)
    if longest.length < _SHORT * size:
        return None
    return longest


def _is_on_axis(point: Array, joint: PlacedJoint, size: float) -> bool:
    off = np.cross(point - joint.point, joint.axis)
    return bool(np.linalg.norm(off) < COINCIDENT * size)


def rail(joint: PlacedJoint) -> Array:
    """(2, 3) ends of the rail of a prismatic joint [m].

    It covers the limits, or zero and the reference, and the present position.
    """
    reach = [joint.displacement, *_reach(joint)]
    ends = np.outer([min(reach), max(reach)], joint.axis)
    return np.asarray(joint.start + ends)


def _reach(joint: PlacedJoint) -> list[float]:
    """Positions that the rail covers in every configuration [m]."""
    limits = [limit for limit in joint.limits if np.isfinite(limit)]
    return [joint.reference, *(limits or [0.0])]


def mechanism_size(skeleton: Skeleton) -> float:
    """Size of the mechanism [m]."""
    diagonal = np.ptp(skeleton.points, axis=0)
    return max(float(np.linalg.norm(diagonal)), _SMALLEST)
