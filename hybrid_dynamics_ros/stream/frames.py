"""Names of a robot's frames in messages."""

from __future__ import annotations

from dataclasses import dataclass

from hybrid_dynamics_core import Robot

from ..parameters import BASE_FRAME, FRAME_PREFIX, NodeSettings


@dataclass(frozen=True)
class FrameNames:
    """Map from names in the robot file to names in messages.

    Attributes:
        link: base link of the robot.
        base: its name in messages.
        prefix: prefix of the names of all other frames.
    """

    link: str
    base: str
    prefix: str = ""

    def of(self, frame: str) -> str:
        """The name of a frame or link in messages."""
        return self.base if frame == self.link else f"{self.prefix}{frame}"


def frame_names(robot: Robot, settings: NodeSettings) -> FrameNames:
    """The names for given parameters."""
    prefix, link = settings[FRAME_PREFIX], robot.base_frame
    return FrameNames(link, settings[BASE_FRAME] or f"{prefix}{link}", prefix)
