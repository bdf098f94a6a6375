"""Joints and closures as symbols: hinges, collars, balls, pins, axes, and arrows of what is driven."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..ground.arrays import Array
from .attach import Cylinder
from .groups import Group
from .parts import Part, stub
from .skeleton import PlacedClosure, PlacedJoint
from .view import View

StrokeRole = Literal["axis", "turn", "travel", "carrier", "triad", "base axes", "dot"]


@dataclass(frozen=True, eq=False)
class Stroke:
    """A line (k, 3) [m] beside the parts: an axis, an arrow, a coordinate without a body."""

    owner: str
    role: StrokeRole
    points: Array


Mark = Part | Stroke


def joint_marks(group: Group, cylinder: Cylinder | None, view: View, unit: float) -> list[Mark]:
    """The symbol of a joint, or of several drawn as one."""
    if group.kind == "carrier":
        return [
            Stroke(
                f"joint:{group.names}", "carrier", np.stack([group.first.start, group.last.point])
            )
        ]
    if group.kind == "spherical":
        return [
            _ball(group, unit),
            *(Stroke(f"link:{link}", "dot", group.last.point[None]) for link in group.inner),
        ]
    if group.kind == "universal":
        return _cross(group, unit)
    if group.kind == "prismatic":
        return [_collar(group.first, cylinder, unit)] if cylinder else []
    return _hinge(group.first, view, unit)


def closure_marks(
    closure: PlacedClosure, normal: Array, hinges: Sequence[Array], unit: float
) -> list[Mark]:
    """Where a loop was cut: pin, spherical joint, hinge or weld; a wider pin round a hinge at the same place."""
    owner, point, links = f"closure:{closure.name}", closure.point, closure.links
    if closure.kind == "point":
        return [Part(owner, "ball", point[None], 1.15 * unit, None, links)]
    if closure.kind == "frame":
        return [
            Part(
                owner,
                "weld",
                stub(point, closure.axis, 0.9 * unit),
                0.9 * unit,
                closure.axis,
                links,
            )
        ]
    axis = closure.axis if closure.kind == "axis" else normal
    shared = any(np.linalg.norm(hinge - point) < 0.5 * unit for hinge in hinges)
    radius = (1.55 if shared else 1.1) * unit
    return [Part(owner, "pin", stub(point, axis, 1.2 * unit), radius, axis, links)]


def triad(owner: str, point: Array, rotation: Array, length: float) -> list[Stroke]:
    """Three arrows along the axes of a frame; x, y, z in this order."""
    return [
        Stroke(f"{owner}.{'xyz'[k]}", "triad", np.stack([point, point + length * rotation[:, k]]))
        for k in range(3)
    ]


def _hinge(joint: PlacedJoint, view: View, unit: float) -> list[Mark]:
    owner, links = f"joint:{joint.name}", (joint.parent, joint.child)
    marks: list[Mark] = []
    if abs(joint.axis @ view.toward) < 0.98:
        half = (4.2 if joint.active else 3.0) * unit
        marks.append(Stroke(f"axis:{joint.name}", "axis", stub(joint.point, joint.axis, half)))
    marks.append(
        Part(owner, "hinge", stub(joint.point, joint.axis, 1.25 * unit), unit, joint.axis, links)
    )
    return marks


def _collar(joint: PlacedJoint, cylinder: Cylinder, unit: float) -> Part:
    ends = stub(cylinder.mouth, cylinder.along, 0.45 * unit)
    return Part(
        f"joint:{joint.name}",
        "collar",
        ends,
        1.55 * unit,
        cylinder.along,
        (joint.parent, joint.child),
    )


def _ball(group: Group, unit: float) -> Part:
    links = (group.first.parent, group.last.child)
    return Part(f"joint:{group.names}", "ball", group.last.point[None], 1.3 * unit, None, links)


def _cross(group: Group, unit: float) -> list[Mark]:
    links = (group.first.parent, group.last.child)
    marks: list[Mark] = [
        Part(
            f"joint:{joint.name}",
            "hinge",
            stub(joint.point, joint.axis, 1.6 * unit),
            0.42 * unit,
            joint.axis,
            links,
        )
        for joint in group.joints
    ]
    middle = group.last.point[None]
    return marks + [
        Part(f"link:{link}", "cross", middle, 0.62 * unit, None, links) for link in group.inner
    ]
