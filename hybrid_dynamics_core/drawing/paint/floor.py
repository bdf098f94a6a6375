"""The floor under a spatial mechanism: square tiles, shadows, and the axes of the base."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Polygon

from ...ground.arrays import Array
from ...scene.parts import Part, convex_hull
from ...scene.scene import Scene
from ...scene.style import GRID, QUIET
from ...scene.symbols import LineMark, triad
from ...scene.visuals.surfaces import outline

_FLOOR = "#f7f8fa"
_SHADE = "#e2e7ec"
_BODIES = ("plate", "bar", "rod", "barrel", "base")
_TILES = 6.0  # number of tiles along the longer side of the mechanism
_ROOM = 0.3  # least margin around the mechanism, in tiles
_AXES = 4.6  # length of the base axes, in radii of a joint


def tile_side(scene: Scene) -> float:
    """Side of a tile [m]: 1, 2 or 5 times a power of ten."""
    extent = np.ptp(_points(scene.standing)[:, :2], axis=0).max()
    wanted = max(float(extent), 1e-6) / _TILES
    power = 10.0 ** np.floor(np.log10(wanted))
    factor = min((1.0, 2.0, 5.0, 10.0), key=lambda k: abs(np.log(k * power / wanted)))
    return float(power * factor)


def floor_corners(scene: Scene) -> Array:
    """(4, 3) corners of the floor [m], an integer number of tiles apart.

    The floor is at the lowest point of the mechanism at its reference.
    """
    standing = _points(scene.standing)
    tile = tile_side(scene)
    points = np.vstack([standing, _points(scene)])
    low, high = points.min(axis=0), points.max(axis=0)
    x0, y0 = tile * np.floor(low[:2] / tile - _ROOM)
    x1, y1 = tile * np.ceil(high[:2] / tile + _ROOM)
    below = 0.0 if _has_base(scene) else scene.joint_radius
    z = float(standing[:, 2].min()) - below
    return np.array([[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]])


def _has_base(scene: Scene) -> bool:
    """Whether the base has a body."""
    base = scene.skeleton.base
    has_surface = any(surface.link == base for surface in scene.surfaces)
    return has_surface or any(part.role == "base" for part in scene.parts)


def base_axes(scene: Scene) -> list[LineMark]:
    """Arrows along the base axes, at the leftmost corner of the floor."""
    corners = floor_corners(scene)
    across = scene.projection.project(corners)[:, 0]
    place = corners[int(np.argmin(across))]
    arrows = triad("base axes", place, np.eye(3), _AXES * scene.joint_radius)
    return [LineMark(arrow.owner, "base axes", arrow.points) for arrow in arrows]


def draw_floor(axes: Axes, scene: Scene) -> None:
    """Draw tiles, shadows of the bodies, and the side length of a tile."""
    project = scene.projection.project
    corners = floor_corners(scene)
    flat = project(corners)
    ground = Polygon(
        flat,
        facecolor=_FLOOR,
        edgecolor=GRID,
        linewidth=0.8,
        zorder=1.0,
    )
    ground.set_gid("floor")
    axes.add_patch(ground)
    level = corners[0, 2]
    for part in scene.parts:
        if part.role in _BODIES and part.points[:, 2].max() > level:
            shadow = _shadow(scene, part, level)
            axes.add_patch(
                Polygon(
                    shadow,
                    facecolor=_SHADE,
                    edgecolor="none",
                    zorder=1.1,
                )
            )
    for surface in scene.surfaces:
        fallen = surface.vertices * (1.0, 1.0, 0.0) + (0.0, 0.0, level)
        corners_of_shadow = outline(project(fallen))
        patch = Polygon(corners_of_shadow, facecolor=_SHADE, edgecolor="none", zorder=1.1)
        axes.add_patch(patch)
    lines = [project(ends) for ends in _grid(corners, tile_side(scene))]
    axes.add_collection(
        LineCollection(
            lines,
            colors=GRID,
            linewidths=0.6,
            zorder=1.15,
        )
    )
    axes.annotate(
        f"floor tiles {tile_side(scene):g} m",
        flat[int(np.argmin(flat[:, 1]))],
        xytext=(0, -4),
        textcoords="offset points",
        color=QUIET,
        fontsize=7.5,
        ha="center",
        va="top",
        zorder=1.2,
    )


def _grid(corners: Array, tile: float) -> list[list[list[float]]]:
    """Ends of the lines between tiles [m]."""
    (x0, y0, z), (x1, y1, _) = corners[0], corners[2]
    lines = [[[x, y0, z], [x, y1, z]] for x in np.arange(x0, x1 + 0.5 * tile, tile)]
    lines += [[[x0, y, z], [x1, y, z]] for y in np.arange(y0, y1 + 0.5 * tile, tile)]
    return lines


def _shadow(scene: Scene, part: Part, level: float) -> Array:
    """(k, 2) outline of a part's shadow on the floor in the picture [m]."""
    fallen = part.points * (1.0, 1.0, 0.0) + (0.0, 0.0, level)
    centres = scene.projection.project(fallen)
    rims = centres[:, None] + _disc(scene, part.radius)[None]
    return convex_hull(rims.reshape(-1, 2))


def _points(scene: Scene) -> Array:
    points = [scene.skeleton.points, *(part.points for part in scene.parts)]
    points += [surface.box() for surface in scene.surfaces]
    return np.vstack(points)


def _disc(scene: Scene, radius: float) -> Array:
    """(n, 2) a horizontal disc as it appears in the picture [m]."""
    angles = np.linspace(0.0, 2.0 * np.pi, 17)[:-1]
    circle = np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    return scene.projection.project(radius * circle)
