"""Parameters: names of frames in messages."""

from __future__ import annotations

from typing import Any, Final

from .row import Parameter

FRAME_PREFIX: Final = Parameter[str](
    "frame_prefix",
    "",
    "Begins the names of all frames in messages and on /tf, such as left/ for one of two robots.",
    kind=str,
)
BASE_FRAME: Final = Parameter[str](
    "base_frame",
    "",
    "Name of the base frame in messages and on /tf, as it is. Empty: the base link of the robot"
    " file, with the prefix.",
    kind=str,
)
TF_TARGETS: Final = Parameter[bool](
    "tf_targets",
    False,
    "Whether targets of inverse kinematics and of paths may be in any frame of /tf. Needs tf2_ros.",
    kind=bool,
)

ROWS: Final[tuple[Parameter[Any], ...]] = (FRAME_PREFIX, BASE_FRAME, TF_TARGETS)
