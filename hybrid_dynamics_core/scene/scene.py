"""A mechanism in one configuration as parts and lines, with the colours of its links."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.path import Path

from ..description.model import RobotDescription
from ..ground.arrays import Array
from .attach import CylinderShape, attach, cylinders_of, mechanism_size, rail
from .drives import travel_arrow, turn_arrow
from .groups import JointGroup, group_joints
from .marks import base_marks, joints_on_rails, link_colours, solid_marks
from .parts import Part
from .points import distinct
from .projection import Projection
from .skeleton import PlacedJoint, Pose, Skeleton
from .symbols import LineMark, triad
from .visuals.surfaces import Surface, Surfaces, is_covered

_JOINT_RADIUS = 0.0125  # radius of a joint, as a share of the picture's size
_UPRIGHT = 1.25  # weight of a picture's height against its width
_SMALLEST = 0.1  # [m] least size of a picture
_TRIAD = 0.075  # length of the end effector's axes, as a share of the picture's size


@dataclass(frozen=True, eq=False)
class Scene:
    """All bodies and marks of a picture.

    Attributes:
        skeleton: the mechanism.
        projection: projection of the picture.
        groups: its joints as they are drawn.
        parts: its bodies and symbols.
        lines: axes, arrows and frames.
        colours: colours by link, and by closure under "closure:NAME".
        joint_radius: radius of a joint [m].
        ground: places (3,) at which the base of a planar mechanism is fixed [m].
        reference: the scene of the reference configuration, unless this is it.
        surfaces: visuals of links in base axes, in place of the bodies of these links.
    """

    skeleton: Skeleton
    projection: Projection
    groups: tuple[JointGroup, ...]
    parts: tuple[Part, ...]
    lines: tuple[LineMark, ...]
    colours: Mapping[str, str]
    joint_radius: float
    ground: tuple[Array, ...]
    reference: Scene | None = None
    surfaces: tuple[Surface, ...] = ()

    @property
    def standing(self) -> Scene:
        """The scene that defines ground and floor, the same in all pictures of a robot."""
        return self.reference or self

    def with_surfaces(self, surfaces: Surfaces, poses: Mapping[str, Pose]) -> Scene:
        """The scene with surfaces in place of the bodies of their links.

        Args:
            surfaces: surfaces of the robot.
            poses: poses of the links in the configuration of the scene.
        """
        links = surfaces.links
        parts = tuple(part for part in self.parts if not is_covered(part, links))
        ground = () if self.skeleton.base in links else self.ground
        placed = tuple(surface.placed(poses) for surface in surfaces.surfaces)
        return replace(self, parts=parts, ground=ground, surfaces=placed)


def build_scene(
    description: RobotDescription,
    skeleton: Skeleton,
    projection: Projection,
    joint_radius: float | None = None,
    reference: Scene | None = None,
) -> Scene:
    """Build the scene of a skeleton.

    Args:
        description: description of the robot.
        skeleton: the robot in one configuration.
        projection: projection of the picture.
        joint_radius: radius of a joint [m]; None: in proportion to this picture.
        reference: the scene of the reference configuration; None if this is it.

    Returns:
        The scene.
    """
    if projection.planar:
        skeleton = skeleton.flattened(projection.toward)
    groups = group_joints(skeleton)
    attached = attach(skeleton, groups)
    cylinders = cylinders_of(attached)
    if joint_radius is None:
        joint_radius = _suitable_radius(skeleton, projection, joints_on_rails(groups, cylinders))
    marks = solid_marks(skeleton, groups, attached, projection, joint_radius)
    base = attached[skeleton.base]
    ground: tuple[Array, ...] = ()
    if projection.planar:
        ground = tuple(distinct(base.fixed, mechanism_size(skeleton)))
    else:
        marks += base_marks(skeleton, groups, base, joint_radius)
    parts = tuple(mark for mark in marks if isinstance(mark, Part))
    lines = [mark for mark in marks if isinstance(mark, LineMark)]
    lines += _drives(skeleton, cylinders, projection, joint_radius, parts)
    tip = skeleton.tip
    length = _TRIAD * joint_radius / _JOINT_RADIUS
    lines += triad(f"frame:{tip.name}", tip.point, tip.rotation, length)
    return Scene(
        skeleton=skeleton,
        projection=projection,
        groups=groups,
        parts=parts,
        lines=tuple(lines),
        colours=link_colours(skeleton, description.loops),
        joint_radius=joint_radius,
        ground=ground,
        reference=reference,
    )


def _suitable_radius(
    skeleton: Skeleton, projection: Projection, on_rails: Sequence[PlacedJoint]
) -> float:
    """Radius of a joint that suits the size of the picture [m]."""
    rails = [rail(joint) for joint in on_rails]
    points = np.vstack([skeleton.points, *rails])
    width, height = np.ptp(projection.project(points), axis=0)
    size = max(float(width), _UPRIGHT * float(height))
    return _JOINT_RADIUS * (size or _SMALLEST)


def _drives(
    skeleton: Skeleton,
    cylinders: Mapping[str, CylinderShape],
    projection: Projection,
    joint_radius: float,
    parts: Sequence[Part],
) -> list[LineMark]:
    """An arrow for every active joint; arrows around one place get increasing radii."""
    outlines = [Path(part.outline(projection)) for part in parts]
    arrows: list[LineMark] = []
    turned: list[Array] = []
    for joint in skeleton.joints:
        if not joint.active:
            continue
        if joint.type == "prismatic":
            cylinder = cylinders.get(joint.name)
            arrows.append(travel_arrow(joint, cylinder, projection, joint_radius, outlines))
        else:
            here = [place for place in turned if np.linalg.norm(joint.point - place) < joint_radius]
            turned.append(joint.point)
            arrows.append(turn_arrow(joint, projection, joint_radius, len(here)))
    return arrows
