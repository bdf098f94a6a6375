"""A mechanism on axes."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes

from ...closed_state.state import ClosedState
from ...ground.arrays import Array
from ...mechanism.tree import build_tree
from ...robot.robot import Robot
from ...scene.projection import choose_projection
from ...scene.scene import Scene, build_scene
from ...scene.skeleton import link_poses, place_skeleton
from ...scene.visuals.surfaces import outline, surfaces_of
from ..options import Names
from .backdrop import draw_ground, draw_loops, ground_outlines
from .floor import base_axes, draw_floor, floor_corners
from .labels import Labeller
from .names import name_labels
from .paint import Painter
from .surfaces import add_surfaces

# Horizontal and vertical margins for names, in radii of a joint.
_PLANAR_MARGIN = np.array([4.0, 3.0])
_SPATIAL_MARGIN = np.array([1.5, 3.0])
_BROAD = 0.02  # weight of a surface under names


def make_scene(robot: Robot, state: ClosedState | None, like: Scene | None = None) -> Scene:
    """The scene of a robot in a state.

    Args:
        robot: to be painted.
        state: one closed state; None: the reference configuration.
        like: a scene whose projection and sizes are used, if given.

    Returns:
        The scene.
    """
    description = robot.description
    reference = place_skeleton(robot, robot.close(robot.reference))
    if state is None:
        return build_scene(description, reference, choose_projection(reference))
    skeleton = place_skeleton(robot, state)
    if like is not None:
        return build_scene(description, skeleton, like.projection, like.joint_radius, like.standing)
    projection = choose_projection(skeleton)
    standing = build_scene(description, reference, projection)
    return build_scene(description, skeleton, projection, None, standing)


def with_visuals(scene: Scene, robot: Robot, state: ClosedState | None) -> Scene:
    """The scene with the visuals of a robot, if it has any.

    A warning names each mesh that is not shown, with the reason.

    Args:
        scene: scene of the robot.
        robot: to be painted.
        state: one closed state; None: the reference configuration.
    """
    surfaces = surfaces_of(robot.description)
    for problem in surfaces.problems:
        warnings.warn(f"{robot.name}: {problem}", stacklevel=4)
    if not surfaces.surfaces:
        return scene
    tree = build_tree(robot.description)
    reference = robot.close(robot.reference)
    dressed = scene.with_surfaces(surfaces, link_poses(tree, state or reference))
    if scene.reference is None:
        return dressed
    standing = scene.reference.with_surfaces(surfaces, link_poses(tree, reference))
    return replace(dressed, reference=standing)


def paint_scene(
    axes: Axes,
    scene: Scene,
    names: Names,
    limits: Array,
) -> None:
    """Paint on axes with equal scales.

    Args:
        axes: to be painted on.
        scene: to be painted.
        names: which names to show.
        limits: (2, 2) [[left, bottom], [right, top]] [m]; widened to fill the axes' box.
    """
    painter = Painter(axes, scene)
    if scene.projection.planar:
        draw_loops(axes, scene)
        draw_ground(axes, scene)
        axes.set_xlabel(scene.projection.names[0])
        axes.set_ylabel(scene.projection.names[1])
        painter.paint()
    else:
        draw_floor(axes, scene)
        axes.set_axis_off()
        painter.paint()
        for arrow in base_axes(scene):
            painter.arrow(arrow)
    scale = _fill(axes, limits)
    covered = painter.covered + [(outline, 1.0) for outline in ground_outlines(scene)]
    if scene.surfaces:
        add_surfaces(axes, scene.surfaces, scene.projection, scale)
        covered += [(outline, _BROAD) for outline in _outlines(scene)]
    Labeller(axes, covered).place(painter.letters + name_labels(scene, names))


def _outlines(scene: Scene) -> list[Array]:
    """(n, 2) each: outlines of the surfaces [m]."""
    project = scene.projection.project
    return [outline(project(surface.vertices)) for surface in scene.surfaces]


def _fill(axes: Axes, limits: Array) -> float:
    """Set equal scales; the limits are widened in one direction to fill the axes' box.

    Returns:
        What an inch stands for [m].
    """
    box = np.array([axes.bbox.width, axes.bbox.height])
    width, height = np.ptp(limits, axis=0)
    scale = max(width / box[0], height / box[1])
    middle = limits.mean(axis=0)
    half = 0.5 * scale * box
    low, high = middle - half, middle + half
    axes.set_aspect("equal", adjustable="box")
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.apply_aspect()
    return float(scale * axes.figure.dpi)


def limits_of(scene: Scene) -> Array:
    """(2, 2) bounding box of the scene with a margin for names [m]."""
    projection = scene.projection
    outlines = [part.outline(projection) for part in scene.parts]
    outlines += [projection.project(line.points) for line in scene.lines]
    outlines += _outlines(scene)
    if projection.planar:
        outlines += ground_outlines(scene)
        margin = scene.joint_radius * _PLANAR_MARGIN
    else:
        outlines.append(projection.project(floor_corners(scene)))
        outlines += [projection.project(arrow.points) for arrow in base_axes(scene)]
        margin = scene.joint_radius * _SPATIAL_MARGIN
    points = np.vstack(outlines)
    return np.array([points.min(axis=0) - margin, points.max(axis=0) + margin])
