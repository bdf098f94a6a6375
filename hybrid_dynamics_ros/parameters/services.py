"""Parameters: service calls and trajectories."""

from __future__ import annotations

from typing import Any, Final

from .row import ChangeTime, Parameter

TIMEOUT: Final = Parameter[float](
    "services.timeout",
    60.0,
    "A service call that takes longer than this is answered with TIMEOUT.",
    unit="s",
    bounds=(0.01, 86400.0),
    change=ChangeTime.ANY_TIME,
)
QUEUE: Final = Parameter[int](
    "services.queue",
    64,
    "Most calls that wait for each of the three processes; further ones are answered with BUSY.",
    bounds=(1, 100000),
    kind=int,
    change=ChangeTime.ANY_TIME,
)
LEAST_SINGULARITY: Final = Parameter[float](
    "trajectory.least_singularity",
    0.02,
    "A trajectory ends before a point nearer to a singularity than this: 0 singular, 1 best.",
    bounds=(0.0, 1.0),
    change=ChangeTime.ANY_TIME,
)
EFFORT_TOLERANCE: Final = Parameter[float](
    "trajectory.effort_tolerance",
    0.01,
    "Points of a converted trajectory are so close that efforts between them are linear within this"
    " share of the largest effort of each drive. 0: no points are added.",
    bounds=(0.0, 1.0),
    change=ChangeTime.ANY_TIME,
)
RETIME: Final = Parameter[float](
    "trajectory.retime",
    0.0,
    "Converted trajectories pass their path as fast as this share of all limits allows; their own"
    " times do not matter then. 0: times are kept.",
    bounds=(0.0, 1.0),
    change=ChangeTime.ANY_TIME,
)
FOLLOW_ACTION: Final = Parameter[str](
    "trajectory.follow_action",
    "",
    "Action of the controller that follows trajectories of the active joints, such as"
    " /joint_trajectory_controller/follow_joint_trajectory. ~/follow_joint_trajectory then takes"
    " those of any joints. Empty: it is not offered.",
    kind=str,
)

ROWS: Final[tuple[Parameter[Any], ...]] = (
    TIMEOUT,
    QUEUE,
    LEAST_SINGULARITY,
    EFFORT_TOLERANCE,
    RETIME,
    FOLLOW_ACTION,
)
