"""A mechanism on axes."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from ...closed_state.state import ClosedState
from ...ground.arrays import Array
from ...robot.robot import Robot
from ...scene.projection import choose_projection
from ...scene.scene import Scene, build_scene
from ...scene.skeleton import place_skeleton
from ..options import Names
from .backdrop import draw_ground, draw_loops, ground_outlines
from .floor import base_axes, draw_floor, floor_corners
from .labels import Labeller
from .names import name_labels
from .paint import Painter


def make_scene(robot: Robot, state: ClosedState | None, like: Scene | None = None) -> Scene:
    """What is painted of a robot in a state (the reference if None), in the view and the sizes of another scene."""
    description, reference = robot.description, place_skeleton(robot, robot.close(robot.reference))
    if state is None:
        return build_scene(description, reference, choose_projection(reference))
    skeleton = place_skeleton(robot, state)
    view, unit = (
        (choose_projection(skeleton), None) if like is None else (like.projection, like.unit)
    )
    home = build_scene(description, reference, view, unit) if like is None else like.standing
    return build_scene(description, skeleton, view, unit, home)


def paint_scene(axes: Axes, scene: Scene, names: Names, limits: Array) -> None:
    """Paint on axes with equal scales; limits [[left, bottom], [right, top]] [m] are widened to fill the axes' box."""
    painter = Painter(axes, scene)
    if scene.projection.planar:
        draw_loops(axes, scene)
        draw_ground(axes, scene)
        axes.set_xlabel(scene.projection.names[0])
        axes.set_ylabel(scene.projection.names[1])
    else:
        draw_floor(axes, scene)
        axes.set_axis_off()
    painter.paint()
    if not scene.projection.planar:
        for stroke in base_axes(scene):
            painter.arrow(stroke)
    _fill(axes, limits)
    covered = painter.covered + [(outline, 1.0) for outline in ground_outlines(scene)]
    Labeller(axes, covered).place(painter.letters + name_labels(scene, names))


def _fill(axes: Axes, limits: Array) -> None:
    """Equal scales, with the limits widened in one direction so that the axes keep their box."""
    width, height = np.ptp(limits, axis=0)
    scale = max(width / axes.bbox.width, height / axes.bbox.height)
    middle, half = limits.mean(axis=0), 0.5 * scale * np.array([axes.bbox.width, axes.bbox.height])
    axes.set_aspect("equal", adjustable="box")
    axes.set(
        xlim=(middle[0] - half[0], middle[0] + half[0]),
        ylim=(middle[1] - half[1], middle[1] + half[1]),
    )
    axes.apply_aspect()


def limits_of(scene: Scene) -> Array:
    """(2, 2) smallest and largest of everything painted, with a margin for names [m]."""
    corners = [part.outline(scene.projection) for part in scene.parts] + [
        scene.projection.project(s.points) for s in scene.lines
    ]
    corners += ground_outlines(scene)
    if not scene.projection.planar:
        corners += [
            scene.projection.project(floor_corners(scene)),
            *(scene.projection.project(s.points) for s in base_axes(scene)),
        ]
    points = np.vstack(corners)
    margin = scene.unit * (
        np.array([4.0, 3.0]) if scene.projection.planar else np.array([1.5, 3.0])
    )
    return np.array([points.min(axis=0) - margin, points.max(axis=0) + margin])
