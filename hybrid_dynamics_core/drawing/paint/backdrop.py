"""The background of a planar mechanism: the ground, and its loops as areas."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Polygon

from ...ground.arrays import Array
from ...scene.scene import Scene
from ...scene.skeleton import PlacedClosure, PlacedJoint
from ...scene.style import INK, STEEL

# Lengths in radii of a joint:
_PIVOT_DROP: Final = 3.0  # from a pivot to the ground below its stand
_HINGE_DROP: Final = 1.3  # from another hinge
_DROP: Final = 0.5  # from any other place
_THICKNESS: Final = 1.1  # of the ground
_HALF_WIDTH: Final = 3.6  # of the ground
_STAND: Final = 1.8  # half width of a pivot's stand


def ground_outlines(scene: Scene) -> list[Array]:
    """Outlines of the ground in a picture, one for each fixed place of the base.

    Returns:
        (5, 2) each [m], starting at the fixed place.
    """
    return [_ground_outline(scene, point) for point in scene.ground]


def _ground_outline(scene: Scene, point: Array) -> Array:
    unit = scene.joint_radius
    x, y = scene.projection.project(point)
    down = -1.0 if _rises(scene, point) else 1.0
    drop = _drop(scene, point) * unit
    upper = y + down * drop
    lower = y + down * (drop + _THICKNESS * unit)
    left = x - _HALF_WIDTH * unit
    right = x + _HALF_WIDTH * unit
    return np.array([[x, y], [left, upper], [left, lower], [right, lower], [right, upper]])


def _drop(scene: Scene, point: Array) -> float:
    """Height of a place of the base above the ground, in radii of a joint."""
    if _is_pivot(scene, point):
        return _PIVOT_DROP
    if _hinge_axes(scene, point):
        return _HINGE_DROP
    return _DROP


def draw_ground(axes: Axes, scene: Scene) -> None:
    """Draw hatched ground at every fixed place of a planar mechanism's base."""
    owner = f"link:{scene.skeleton.base}"
    for k, point in enumerate(scene.ground):
        gid = owner if k == 0 else f"{owner}.{k + 1}"
        outline = _ground_outline(scene, point)
        if _is_pivot(scene, point):
            axes.add_patch(_stand(scene, outline, f"{gid}.stand"))
        axes.add_collection(_hatch(scene, outline, gid))


def _stand(scene: Scene, outline: Array, gid: str) -> Polygon:
    """The stand of a pivot on the ground."""
    (x, y), (_, upper) = outline[:2]
    half = _STAND * scene.joint_radius
    stand = Polygon(
        [[x, y], [x - half, upper], [x + half, upper]],
        facecolor=STEEL,
        edgecolor=INK,
        linewidth=1.0,
        zorder=1.6,
        joinstyle="round",
    )
    stand.set_gid(gid)
    return stand


def _hatch(scene: Scene, outline: Array, gid: str) -> LineCollection:
    """The line of the ground, with ticks below it."""
    _, (left, upper), _, (right, lower), _ = outline
    unit = scene.joint_radius
    starts = np.linspace(left + 0.7 * unit, right, 8)
    ticks = [[[start, upper], [start - 0.9 * unit, lower]] for start in starts]
    surface = [[left, upper], [right, upper]]
    widths = [1.5] + [0.8] * len(ticks)
    hatch = LineCollection(
        [surface, *ticks],
        colors=INK,
        linewidths=widths,
        zorder=1.5,
    )
    hatch.set_gid(gid)
    return hatch


def _hinge_axes(scene: Scene, point: Array) -> list[Array]:
    """Axes of the hinges that stand at a place of the base."""
    hinges = [joint for joint in scene.skeleton.hinges if joint.parent == scene.skeleton.base]
    return [
        joint.axis for joint in hinges if np.linalg.norm(joint.start - point) < scene.joint_radius
    ]


def _is_pivot(scene: Scene, point: Array) -> bool:
    """Whether a hinge with its axis towards the viewer is at this place of the base."""
    toward = scene.projection.toward
    return any(abs(axis @ toward) > 0.5 for axis in _hinge_axes(scene, point))


def _rises(scene: Scene, point: Array) -> bool:
    """Whether the mechanism is above a place of its base, and not below it, at its reference."""
    skeleton = scene.standing.skeleton
    project = scene.projection.project
    height = project(point)[1]
    if _is_pivot(scene, point):
        middle = project(skeleton.points).mean(axis=0)[1]
        return bool(middle > height - 4.0 * scene.joint_radius)
    carried = {joint.child for joint in skeleton.joints if joint.parent == skeleton.base}
    points = [joint.point for joint in skeleton.joints if joint.parent in carried]
    middle = project(np.array(points or [skeleton.tip.point]))[:, 1].mean()
    return bool(middle > height - scene.joint_radius)


def draw_loops(axes: Axes, scene: Scene) -> None:
    """Fill the area of each loop of a planar mechanism with a pale tone of its colour."""
    for closure in scene.skeleton.closures:
        corners = _loop_corners(scene, closure)
        if len(corners) > 2:
            colour = scene.colours[f"closure:{closure.name}"]
            patch = Polygon(
                corners,
                facecolor=colour,
                edgecolor="none",
                alpha=0.10,
                zorder=1.2,
            )
            patch.set_gid(f"loop:{closure.name}")
            axes.add_patch(patch)


def _loop_corners(scene: Scene, closure: PlacedClosure) -> Array:
    """Corners (k, 2) of a loop: its hinges from one side of the cut to the other."""
    by_child = {joint.child: joint for joint in scene.skeleton.joints}
    first, second = (_hinges_down(by_child, closure, link) for link in closure.links)
    return scene.projection.project(np.array([closure.point, *first, *second[::-1]]))


def _hinges_down(
    by_child: dict[str, PlacedJoint], closure: PlacedClosure, link: str
) -> list[Array]:
    """Points of a loop's hinges from a link towards the base."""
    points = []
    while link in by_child and by_child[link].name in closure.joints:
        joint = by_child[link]
        if joint.type == "revolute":
            points.append(joint.point)
        link = joint.parent
    return points
