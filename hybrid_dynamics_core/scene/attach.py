"""What each link carries: points between which its body reaches, and cylinders."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from ..ground.arrays import Array
from .groups import JointGroup
from .points import COINCIDENT
from .skeleton import PlacedJoint, Skeleton

_MOUTH = (0.42, 0.66)  # least and largest share of a cylinder's length at which its barrel ends
_LONGEST = 0.9  # of the least length that there ever is: the barrel stays below it
_SHORT = 0.02  # of the size of the mechanism: shorter cylinders are drawn as slides
_SMALLEST = 1e-9  # [m] size of a mechanism, at least


@dataclass(frozen=True, eq=False)
class CylinderShape:
    """A prismatic joint drawn as a barrel and a rod.

    Attributes:
        joint: that slides.
        foot: (3,) where the barrel begins [m].
        end: (3,) where the rod ends [m].
        shortest: the least that there ever is between foot and end [m].
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
        """(3,) where the barrel ends [m]: at the joint's zero where that suits a barrel."""
        length = self.length
        direction = self.direction
        zero = float((self.joint.start - self.foot) @ direction / length)
        suitable = np.clip(zero, *_MOUTH) * length
        barrel = min(suitable, _LONGEST * self.shortest)
        return np.asarray(self.foot + barrel * direction)


@dataclass(eq=False)
class Attached:
    """What a link carries.

    Attributes:
        fixed: (3,) points of joints and closures [m].
        ends: (3,) points of frames [m].
        barrels: cylinders whose barrel it is.
        rods: cylinders whose rod it is.
    """

    fixed: list[Array] = field(default_factory=list)
    ends: list[Array] = field(default_factory=list)
    barrels: list[CylinderShape] = field(default_factory=list)
    rods: list[CylinderShape] = field(default_factory=list)

    @property
    def inside(self) -> list[Array]:
        """(3,) points at which its cylinders are held [m]."""
        points = [cylinder.foot for cylinder in self.barrels]
        return points + [cylinder.end for cylinder in self.rods]


def attach(skeleton: Skeleton, groups: Sequence[JointGroup]) -> dict[str, Attached]:
    """By link, the points between which its body reaches."""
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
    """Prismatic joints, whose place depends on what else their links carry."""
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
    """A cylinder where parent and child have points on the axis, else a block on a rail."""
    grounded = joint.parent == skeleton.base  # held in one place, wherever the joint is
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
    """Where along its rail a slide is held by its parent [m]."""
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
    """The joint as a cylinder between the two points on its axis that are the farthest apart.

    None where parent and child have no points there.
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
    """(2, 3) ends of the way of a prismatic joint [m].

    It reaches to its limits, or to zero and the reference, and to where it is.
    """
    reach = [joint.displacement, *_reach(joint)]
    ends = np.outer([min(reach), max(reach)], joint.axis)
    return np.asarray(joint.start + ends)


def _reach(joint: PlacedJoint) -> list[float]:
    """Values between which the rail reaches in every configuration [m]."""
    limits = [limit for limit in joint.limits if np.isfinite(limit)]
    return [joint.reference, *(limits or [0.0])]


def mechanism_size(skeleton: Skeleton) -> float:
    """Size of the mechanism [m]."""
    diagonal = np.ptp(skeleton.points, axis=0)
    return max(float(np.linalg.norm(diagonal)), _SMALLEST)
