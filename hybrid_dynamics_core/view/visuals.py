"""Visuals of links in the scene, and a switch to the skeleton."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import viser

from ..ground.arrays import Array
from ..scene.skeleton import Pose, Skeleton
from ..scene.visuals.surfaces import Surfaces
from .bodies import RobotShape, SolidBody, Span
from .gui_events import Enqueue, in_order, is_from_browser
from .panel_html import note_html

Handles = Sequence[tuple[SolidBody | Span, viser.MeshHandle]]


class Visuals:
    """Visuals of a robot, which hide the parts of the skeleton that they replace.

    Args:
        scene: scene of viser.
        shape: shape of the robot.
        surfaces: surfaces of the robot's visuals.
        paths: by link: name of its node.
    """

    def __init__(
        self,
        scene: viser.SceneApi,
        shape: RobotShape,
        surfaces: Surfaces,
        paths: Mapping[str, str],
    ) -> None:
        self.shape = shape
        self.surfaces = surfaces
        self.handles: list[viser.MeshHandle] = []
        for k, surface in enumerate(surfaces.surfaces):
            *colour, opacity = surface.colour
            red, green, blue = (round(255.0 * level) for level in colour)
            handle = scene.add_mesh_simple(
                f"{paths[surface.link]}/visual {k}",
                surface.vertices,
                surface.faces,
                color=(red, green, blue),
                opacity=opacity if opacity < 1.0 else None,
                side="double",
            )
            self.handles.append(handle)

    def points(self, poses: Mapping[str, Pose]) -> Array:
        """Corners (k, 3) of the bounding boxes of the visuals [m].

        Args:
            poses: poses of the links.
        """
        corners = [np.zeros((0, 3))]
        for surface in self.surfaces.surfaces:
            rotation, origin = poses[surface.link]
            corners.append(surface.box() @ rotation.T + origin)
        return np.vstack(corners)

    def show(self, skeleton: bool, bodies: Handles) -> None:
        """Show the skeleton, or the visuals with the remaining parts of the skeleton.

        Args:
            skeleton: whether to show the skeleton.
            bodies: all bodies of the skeleton.
        """
        for handle in self.handles:
            handle.visible = not skeleton
        for body, handle in bodies:
            handle.visible = skeleton or not self.stand_for(body)

    def stand_for(self, body: SolidBody | Span) -> bool:
        """Whether all links of a body of the skeleton have visuals."""
        links = links_of(body, self.shape.skeleton)
        return bool(links) and links <= self.surfaces.links


def links_of(body: SolidBody | Span, skeleton: Skeleton) -> frozenset[str]:
    """Links of a body of the skeleton, except links inside a joint.

    Args:
        body: body of a link, joint or closure.
        skeleton: skeleton of the robot.
    """
    if body.kind == "link":
        return frozenset(body.names)
    links: set[str] = set()
    for closure in skeleton.closures:
        if body.kind == "closure" and closure.name in body.names:
            links.update(closure.links)
    for joint in skeleton.joints:
        if body.kind == "joint" and joint.name in body.names:
            links.update((joint.parent, joint.child))
    inside = set(skeleton.in_rows)
    return frozenset(links - inside or links)


def add_switch(gui: viser.GuiApi, visuals: Visuals, enqueue: Enqueue, show: Any) -> Any:
    """Add a checkbox for the skeleton, and the reasons why meshes are not shown.

    Args:
        gui: user interface of viser.
        visuals: visuals of the robot.
        enqueue: puts an event of the user into the queue.
        show: function with the new state of the checkbox as argument.

    Returns:
        The checkbox; None if there are no visuals.
    """
    if visuals.surfaces.problems:
        gui.add_html(note_html(". ".join(visuals.surfaces.problems)))
    if not visuals.handles:
        return None
    checkbox = gui.add_checkbox("Skeleton", False)

    @checkbox.on_update
    @in_order
    def _(event: viser.GuiEvent[Any]) -> None:
        if is_from_browser(event):
            wanted = bool(event.target.value)
            enqueue("skeleton", lambda: show(wanted))

    return checkbox
