"""What the viewer shows besides the robot, each with a folder of the panel."""

from __future__ import annotations

from typing import Protocol

import viser

from ..gui_events import Enqueue
from ..scene_view import SceneView
from ..session import ViewSession
from .lifting import LiftingOverlay
from .pins import PinsOverlay
from .pressures import PressuresOverlay
from .tool import ToolOverlay
from .vibration import VibrationOverlay

__all__ = ["Overlay", "overlays_of"]


class Overlay(Protocol):
    """An overlay."""

    def refresh(self) -> None:
        """Show the session's present state."""


def overlays_of(
    server: viser.ViserServer, session: ViewSession, view: SceneView, enqueue: Enqueue
) -> list[Overlay]:
    """The overlays that a robot has use for, in the order of the panel.

    Args:
        server: the server of viser.
        session: the session to show and control.
        view: the scene of the robot.
        enqueue: receives actions of users.
    """
    robot = session.robot
    overlays: list[Overlay] = [ToolOverlay(server, session, view.shape, enqueue)]
    if robot.cylinders:
        overlays.append(PressuresOverlay(server, session))
    if robot.description.closures:
        overlays.append(PinsOverlay(server, session, view.shape, view.camera, enqueue))
    if VibrationOverlay.has_use_for(robot):
        overlays.append(VibrationOverlay(server, session, view, enqueue))
    if LiftingOverlay.has_use_for(robot):
        overlays.append(LiftingOverlay(server, session, enqueue))
    return overlays
