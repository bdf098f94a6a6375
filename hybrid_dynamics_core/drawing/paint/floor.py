"""The floor under a spatial mechanism: square tiles, shadows, and the axes of the base."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.patches import Polygon

from ...ground.arrays import Array
from ...scene.parts import convex_hull
from ...scene.scene import Scene
from ...scene.style import GRID, QUIET
from ...scene.symbols import LineMark, triad

_FLOOR = "#f7f8fa"
_SHADE = "#e2e7ec"
_BODIES = ("plate", "bar", "rod", "barrel", "base")


def tile_side(scene: Scene) -> float:
    """Side of a tile [m]: 1, 2 or 5 times a power of ten."""
    wanted = max(float(np.ptp(_points(scene.standing)[:, :2], axis=0).max()), 1e-6) / 6.0
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(power * min((1.0, 2.0, 5.0, 10.0), key=lambda k: abs(np.log(k * power / wanted))))


def floor_corners(scene: Scene) -> Array:
    """(4, 3) corners of the floor, whole tiles wide [m]: at the lowest point of the mechanism in its reference."""
    home, tile = _points(scene.standing), tile_side(scene)
    points = np.vstack([home, _points(scene)])
    low, high = points.min(axis=0), points.max(axis=0)
    (x0, y0), (x1, y1) = (
        tile * np.floor(low[:2] / tile - 0.3),
        tile * np.ceil(high[:2] / tile + 0.3),
    )
    level = float(home[:, 2].min()) - (
        0.0 if any(part.role == "base" for part in scene.parts) else scene.unit
    )
    return np.array([[x0, y0, level], [x1, y0, level], [x1, y1, level], [x0, y1, level]])


def base_axes(scene: Scene) -> list[LineMark]:
    """Arrows along the axes of the base, on the floor's corner that is farthest to the left."""
    corners = floor_corners(scene)
    left = corners[int(np.argmin(scene.projection.project(corners)[:, 0]))]
    inward = np.sign(corners.mean(axis=0) - left) * (1.0, 1.0, 0.0)
    place = left + 0.0 * inward
    return [
        LineMark(s.owner, "base axes", s.points)
        for s in triad("base axes", place, np.eye(3), 4.6 * scene.unit)
    ]


def draw_floor(axes: Axes, scene: Scene) -> None:
    """Tiles, shadows of the bodies, and what the side of a tile is."""
    corners, tile, flat = floor_corners(scene), tile_side(scene), scene.projection.project
    ground = Polygon(flat(corners), facecolor=_FLOOR, edgecolor=GRID, linewidth=0.8, zorder=1.0)
    ground.set_gid("floor")
    axes.add_patch(ground)
    level = corners[0, 2]
    for part in scene.parts:
        if part.role in _BODIES and part.points[:, 2].max() > level:
            fallen = part.points * (1.0, 1.0, 0.0) + (0.0, 0.0, level)
            shade = convex_hull(
                (flat(fallen)[:, None] + _disc(scene, part.radius)[None]).reshape(-1, 2)
            )
            axes.add_patch(Polygon(shade, facecolor=_SHADE, edgecolor="none", zorder=1.1))
    (x0, y0, _), (x1, y1, _) = corners[0], corners[2]
    lines = [flat([[x, y0, level], [x, y1, level]]) for x in np.arange(x0, x1 + 0.5 * tile, tile)]
    lines += [flat([[x0, y, level], [x1, y, level]]) for y in np.arange(y0, y1 + 0.5 * tile, tile)]
    axes.add_collection(LineCollection(lines, colors=GRID, linewidths=0.6, zorder=1.15))
    lowest = flat(corners)[int(np.argmin(flat(corners)[:, 1]))]
    axes.annotate(
        f"floor tiles {tile:g} m", lowest, xytext=(0, -4), textcoords="offset points", color=QUIET, fontsize=7.5,
        ha="center", va="top", zorder=1.2,
    )  # fmt: skip


def _points(scene: Scene) -> Array:
    return np.vstack([scene.skeleton.points, *(part.points for part in scene.parts)])


def _disc(scene: Scene, radius: float) -> Array:
    """(n, 2) a horizontal disc as it is seen."""
    angles = np.linspace(0.0, 2.0 * np.pi, 17)[:-1]
    return scene.projection.project(
        radius * np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    )
