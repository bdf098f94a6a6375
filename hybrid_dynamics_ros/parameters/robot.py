"""Parameters: the robot and its loads."""

from __future__ import annotations

from typing import Any, Final

from .row import LARGE, ChangeTime, OptionalFloats, OptionalNames, Parameter

ROBOT: Final = Parameter[str](
    "robot",
    "forging_chu2020",
    "Robot of this node: name of a shipped robot, or path of a description file.",
    kind=str,
)
XACRO_ARGS: Final = Parameter[OptionalNames](
    "xacro_args",
    None,
    "Arguments of the robot's file where it is a xacro file, such as prefix:=left_.",
    kind=str,
    length=None,
)
AUTOSTART: Final = Parameter[bool](
    "autostart",
    True,
    "Whether the node configures and activates itself when it starts.",
    kind=bool,
    change=ChangeTime.NEVER,
)
MEASURED: Final = Parameter[OptionalNames](
    "measured",
    None,
    "Joints that the input measures: any independent set. Empty: the active joints of the robot.",
    kind=str,
    length=None,
)
MEASURED_POSES: Final = Parameter[OptionalNames](
    "measured_poses",
    None,
    "Ball and free joints whose poses and twists come on ~/active_joint_poses, so that they may"
    " turn through any orientation. Empty: their coordinates are measured as those of others.",
    kind=str,
    length=None,
)
GRAVITY: Final = Parameter[OptionalFloats](
    "gravity",
    None,
    "Gravity in the axes of the base frame. Empty: that of the robot file.",
    unit="m/s^2",
    bounds=(-1000.0, 1000.0),
    length=3,
    change=ChangeTime.ANY_TIME,
)
PAYLOAD_FRAME: Final = Parameter[str](
    "payload.frame",
    "",
    "Frame that carries the payload. Empty: the end effector.",
    kind=str,
    change=ChangeTime.ANY_TIME,
)
PAYLOAD_MASS: Final = Parameter[float](
    "payload.mass",
    0.0,
    "Mass of the payload.",
    unit="kg",
    bounds=(0.0, LARGE),
    change=ChangeTime.ANY_TIME,
)
PAYLOAD_COM: Final = Parameter[tuple[float, ...]](
    "payload.com",
    (0.0, 0.0, 0.0),
    "Centre of mass of the payload, in the axes of its frame.",
    unit="m",
    bounds=(-LARGE, LARGE),
    length=3,
    change=ChangeTime.ANY_TIME,
)
PAYLOAD_INERTIA: Final = Parameter[tuple[float, ...]](
    "payload.inertia",
    (0.0,) * 6,
    "Inertia of the payload about its centre of mass, in the axes of its frame: xx, xy, xz, yy,"
    " yz, zz.",
    unit="kg m^2",
    bounds=(-LARGE, LARGE),
    length=6,
    change=ChangeTime.ANY_TIME,
)
STILL: Final = Parameter[float](
    "assembly.still_below",
    1e-3,
    "Assembly modes are switched only while no measured joint is faster than this.",
    unit="rad/s or m/s",
    bounds=(0.0, 1000.0),
    change=ChangeTime.ANY_TIME,
)

ROWS: Final[tuple[Parameter[Any], ...]] = (
    ROBOT,
    XACRO_ARGS,
    AUTOSTART,
    MEASURED,
    MEASURED_POSES,
    GRAVITY,
    PAYLOAD_FRAME,
    PAYLOAD_MASS,
    PAYLOAD_COM,
    PAYLOAD_INERTIA,
    STILL,
)
