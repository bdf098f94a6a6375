"""A mechanism in one configuration as marks: everything that will be painted, with the colours of its links."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.path import Path

from ..description.model import RobotDescription
from ..ground.arrays import Array
from .attach import Cylinder, attach, extent, rail
from .drives import travel_arrow, turn_arrow
from .groups import Group, group_joints
from .marks import base_marks, link_colours, solid_marks
from .parts import Part
from .points import distinct
from .skeleton import Skeleton
from .symbols import Stroke, triad
from .view import View

_UNIT = 0.0125  # radius of a joint, of the size of the picture
_SMALLEST = 0.1  # [m] size of the picture of a robot that is one point
_TRIAD = 0.075  # length of the end effector's axes


@dataclass(frozen=True, eq=False)
class Scene:
    """What is painted.

    `unit`: radius of a joint [m]; `colours` by link, and by closure under "closure:NAME".
    """

    skeleton: Skeleton
    view: View
    groups: tuple[Group, ...]
    parts: tuple[Part, ...]
    strokes: tuple[Stroke, ...]
    colours: Mapping[str, str]
    unit: float
    ground: tuple[Array, ...]  # (3,) each: where the base of a planar mechanism is held
    home: Scene | None = None  # the reference configuration, unless this is it

    @property
    def standing(self) -> Scene:
        """The configuration that says how the mechanism stands: ground and floor are the same in all its pictures."""
        return self.home or self


def build_scene(
    description: RobotDescription,
    skeleton: Skeleton,
    view: View,
    unit: float | None = None,
    home: Scene | None = None,
) -> Scene:
    """Turn a skeleton into marks; `unit` as in another scene, or such that it suits this one."""
    if view.planar:
        skeleton = skeleton.pressed(view.toward)
    groups = group_joints(skeleton)
    attached = attach(skeleton, groups)
    cylinders = {c.joint.name: c for what in attached.values() for c in what.barrels}
    slides = [g.first for g in groups if g.kind == "prismatic" and g.first.name not in cylinders]
    if unit is None:
        points = view.flat(np.vstack([skeleton.points, *(rail(joint) for joint in slides)]))
        width, height = np.ptp(points, axis=0)
        unit = _UNIT * (max(float(width), 1.25 * float(height)) or _SMALLEST)
    marks = solid_marks(skeleton, groups, attached, view, unit)
    if not view.planar:
        marks += base_marks(skeleton, groups, attached[skeleton.base], unit)
    parts = tuple(mark for mark in marks if isinstance(mark, Part))
    strokes = [mark for mark in marks if isinstance(mark, Stroke)]
    strokes += _drives(skeleton, cylinders, view, unit, parts)
    size = _TRIAD * unit / _UNIT
    strokes += triad(f"frame:{skeleton.tip.name}", skeleton.tip.point, skeleton.tip.rotation, size)
    ground = tuple(distinct(attached[skeleton.base].fixed, extent(skeleton))) if view.planar else ()
    colours = link_colours(skeleton, description.loops)
    return Scene(skeleton, view, groups, parts, tuple(strokes), colours, unit, ground, home)


def _drives(
    skeleton: Skeleton,
    cylinders: Mapping[str, Cylinder],
    view: View,
    unit: float,
    parts: Sequence[Part],
) -> list[Stroke]:
    """An arrow for every active joint; arrows round one place get growing radii."""
    covered = [Path(part.outline(view)) for part in parts]
    strokes: list[Stroke] = []
    turned: list[Array] = []
    for joint in skeleton.joints:
        if joint.active and joint.type == "prismatic":
            strokes.append(travel_arrow(joint, cylinders.get(joint.name), view, unit, covered))
        elif joint.active:
            shell = sum(float(np.linalg.norm(joint.point - place)) < unit for place in turned)
            turned.append(joint.point)
            strokes.append(turn_arrow(joint, view, unit, shell))
    return strokes
