"""What each link carries: the points between which its body reaches, and prismatic joints that are cylinders."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..ground.arrays import Array
from .groups import Group
from .points import SAME
from .skeleton import PlacedJoint, Skeleton


@dataclass(frozen=True, eq=False)
class Cylinder:
    """A prismatic joint drawn as a barrel from `foot` to `mouth` and a rod from there to `end`.

    shortest: the least that there ever is between foot and end [m]; the barrel stays below it.
    """

    joint: PlacedJoint
    foot: Array
    end: Array
    shortest: float = np.inf

    @property
    def along(self) -> Array:
        """Unit vector from foot to end."""
        return (self.end - self.foot) / np.linalg.norm(self.end - self.foot)

    @property
    def mouth(self) -> Array:
        """Where the barrel ends: at the joint's own zero where that looks like a barrel's end."""
        length = float(np.linalg.norm(self.end - self.foot))
        told = float((self.joint.start - self.foot) @ self.along / length)
        return np.asarray(
            self.foot + min(np.clip(told, 0.42, 0.66) * length, 0.9 * self.shortest) * self.along
        )


@dataclass(eq=False)
class Attached:
    """What a link carries: `fixed` points of joints and closures, `ends` of frames, `own` points inside cylinders."""

    fixed: list[Array] = field(default_factory=list)
    ends: list[Array] = field(default_factory=list)
    barrels: list[Cylinder] = field(default_factory=list)
    rods: list[Cylinder] = field(default_factory=list)


def attach(skeleton: Skeleton, groups: Sequence[Group]) -> dict[str, Attached]:
    """By link, the points between which its body reaches."""
    found = {link: Attached() for link in skeleton.links}
    for group in groups:
        if group.kind not in ("prismatic", "carrier"):
            found[group.first.parent].fixed.append(group.first.start)
            found[group.last.child].fixed.append(group.last.point)
    for closure in skeleton.closures:
        for link, point in zip(closure.links, closure.points, strict=True):
            found[link].fixed.append(point)
    for frame in skeleton.frames:
        if frame.link != skeleton.base:
            found[frame.link].ends.append(frame.point)
    for group in groups:
        _attach_slides(skeleton, found, group)
    return found


def _attach_slides(skeleton: Skeleton, found: dict[str, Attached], group: Group) -> None:
    """Prismatic joints, whose place depends on what else their links carry."""
    joint, parent, child = group.first, found[group.first.parent], found[group.last.child]
    if group.kind == "carrier" and not child.fixed:
        child.fixed.append(group.last.point)
    if group.kind != "prismatic":
        return
    grounded = joint.parent == skeleton.base  # held in one place, wherever the joint is
    cylinder = (
        None if grounded else _cylinder(skeleton, joint, parent.fixed, child.fixed + child.ends)
    )
    if cylinder is None:
        way = _way(joint)
        held = (
            0.5 * (min(way) + max(way))
            if grounded
            else np.clip(0.0, min(*way, joint.here), max(*way, joint.here))
        )
        parent.fixed.append(joint.start + held * joint.axis)
        child.fixed.append(joint.point)
    else:
        parent.barrels.append(cylinder)
        child.rods.append(cylinder)


def _cylinder(
    skeleton: Skeleton, joint: PlacedJoint, feet: Sequence[Array], ends: Sequence[Array]
) -> Cylinder | None:
    """The joint as a cylinder, where parent and child have points on its axis; the two farthest apart."""
    size = extent(skeleton)

    def on_axis(point: Array) -> bool:
        return bool(np.linalg.norm(np.cross(point - joint.point, joint.axis)) < SAME * size)

    pairs = [(a, b) for a in feet for b in ends if on_axis(a) and on_axis(b)]
    lengths = [float(np.linalg.norm(b - a)) for a, b in pairs]
    if not pairs or max(lengths) < 0.02 * size:
        return None
    return Cylinder(joint, *pairs[int(np.argmax(lengths))])


def rail(joint: PlacedJoint) -> Array:
    """(2, 3) ends of the way of a prismatic joint: its limits, or zero and the reference, and where it is [m]."""
    way = [joint.here, *_way(joint)]
    return np.asarray(joint.start + np.outer([min(way), max(way)], joint.axis))


def _way(joint: PlacedJoint) -> list[float]:
    """Values between which the rail reaches in every configuration [m]."""
    return [joint.home, *([limit for limit in joint.limits if np.isfinite(limit)] or [0.0])]


def extent(skeleton: Skeleton) -> float:
    """Size of the mechanism [m]."""
    return max(float(np.linalg.norm(np.ptp(skeleton.points, axis=0))), 1e-9)
