"""What stands behind a planar mechanism: the ground that holds it, and its loops as areas."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Polygon

from ...ground.arrays import Array
from ...scene.scene import Scene
from ...scene.skeleton import PlacedClosure
from ...scene.style import INK, STEEL


def ground_outlines(scene: Scene) -> list[Array]:
    """(5, 2) each: what the ground at one place of the base takes, from the place that it holds round."""
    unit = scene.unit
    outlines = []
    for point in scene.ground:
        x, y = scene.projection.project(point)
        down = -1.0 if _rises(scene, point) else 1.0
        drop = (3.0 if _is_pivot(scene, point) else 1.3 if _hinges(scene, point) else 0.5) * unit
        foot, low = y + down * drop, y + down * (drop + 1.1 * unit)
        left, right = x - 3.6 * unit, x + 3.6 * unit
        outlines.append(np.array([[x, y], [left, foot], [left, low], [right, low], [right, foot]]))
    return outlines


def draw_ground(axes: Axes, scene: Scene) -> None:
    """Hatched ground at every place where the base of a planar mechanism is held."""
    unit, owner = scene.unit, f"link:{scene.skeleton.base}"
    for k, (point, outline) in enumerate(zip(scene.ground, ground_outlines(scene), strict=True)):
        (x, y), (left, foot), _, (right, low), _ = outline
        gid = owner if k == 0 else f"{owner}.{k + 1}"
        if _is_pivot(scene, point):
            corners = [[x, y], [x - 1.8 * unit, foot], [x + 1.8 * unit, foot]]
            stand = Polygon(
                corners,
                facecolor=STEEL,
                edgecolor=INK,
                linewidth=1.0,
                zorder=1.6,
                joinstyle="round",
            )
            stand.set_gid(f"{gid}.stand")
            axes.add_patch(stand)
        ticks = [
            [[t, foot], [t - 0.9 * unit, low]] for t in np.linspace(left + 0.7 * unit, right, 8)
        ]
        lines = [[[left, foot], [right, foot]], *ticks]
        hatch = LineCollection(lines, colors=INK, linewidths=[1.5] + [0.8] * len(ticks), zorder=1.5)
        hatch.set_gid(gid)
        axes.add_collection(hatch)


def _hinges(scene: Scene, point: Array) -> list[Array]:
    """Axes of the hinges that stand at a place of the base."""
    own = [
        j for j in scene.skeleton.joints if j.parent == scene.skeleton.base and j.type == "revolute"
    ]
    return [j.axis for j in own if np.linalg.norm(j.start - point) < scene.unit]


def _is_pivot(scene: Scene, point: Array) -> bool:
    """Whether a hinge with its axis towards the viewer stands here."""
    return any(abs(axis @ scene.projection.toward) > 0.5 for axis in _hinges(scene, point))


def _rises(scene: Scene, point: Array) -> bool:
    """Whether the mechanism stands on a place of its base, and does not hang from it, in its reference."""
    skeleton, at = scene.standing.skeleton, scene.projection.project(point)
    if _is_pivot(scene, point):
        return bool(
            scene.projection.project(skeleton.points).mean(axis=0)[1] > at[1] - 4.0 * scene.unit
        )
    on_it = {j.child for j in skeleton.joints if j.parent == skeleton.base}
    marks = [j.point for j in skeleton.joints if j.parent in on_it] or [skeleton.tip.point]
    return bool(scene.projection.project(np.array(marks))[:, 1].mean() > at[1] - scene.unit)


def draw_loops(axes: Axes, scene: Scene) -> None:
    """The area inside each loop of a planar mechanism in the loop's colour, very pale."""
    for closure in scene.skeleton.closures:
        corners = _around(scene, closure)
        if len(corners) > 2:
            colour = scene.colours[f"closure:{closure.name}"]
            patch = Polygon(corners, facecolor=colour, edgecolor="none", alpha=0.10, zorder=1.2)
            patch.set_gid(f"loop:{closure.name}")
            axes.add_patch(patch)


def _around(scene: Scene, closure: PlacedClosure) -> Array:
    """Corners (k, 2) of a loop: its hinges from one side of the cut round to the other."""
    by_child = {joint.child: joint for joint in scene.skeleton.joints}
    ways: list[list[Array]] = []
    for end in closure.links:
        way, link = [], end
        while link in by_child and by_child[link].name in closure.joints:
            if by_child[link].type == "revolute":
                way.append(by_child[link].point)
            link = by_child[link].parent
        ways.append(way)
    return scene.projection.project(np.array([closure.point, *ways[0], *ways[1][::-1]]))
