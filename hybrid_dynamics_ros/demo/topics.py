"""Names and types of the topics that the demo plays, records and shows."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from ..bags.storage.qos import reliable_profile
from ..bags.storage.storage import Topic

NODE: Final = "/hybrid_dynamics"
INPUT: Final = f"{NODE}/active_joint_states"
STATES: Final = f"{NODE}/joint_states"
EFFORTS: Final = f"{NODE}/required_efforts"
POSE: Final = f"{NODE}/end_effector_pose"

TYPES: Final = {
    INPUT: "sensor_msgs/msg/JointState",
    STATES: "sensor_msgs/msg/JointState",
    EFFORTS: "sensor_msgs/msg/JointState",
    POSE: "geometry_msgs/msg/PoseStamped",
}
OUTPUTS: Final = (STATES, EFFORTS, POSE)
_DEPTH: Final = 50  # history depth of publishers


def bag_topics(names: Iterable[str]) -> list[Topic]:
    """Topics of the demo, as topics of a bag."""
    return [Topic(name, TYPES[name], (reliable_profile(_DEPTH),)) for name in names]
