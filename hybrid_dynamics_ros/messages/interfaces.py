"""Message definitions, from the msg files of the ROS packages."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any, Final

from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

JOINT_STATE: Final = "sensor_msgs/msg/JointState"
JOINT_MOTION: Final = "hybrid_dynamics_msgs/msg/JointMotion"
_PACKAGE: Final = Path(__file__).resolve().parents[1]
_INSTALLED: Final = _PACKAGE / "interfaces"
_IN_REPOSITORY: Final = _PACKAGE.parent / "msg_defs" / "msg"


@cache
def typestore() -> Typestore:
    """The message types of ROS 2 Jazzy and of this project."""
    store = get_typestore(Stores.ROS2_JAZZY)
    folder = _INSTALLED if _INSTALLED.is_dir() else _IN_REPOSITORY
    for path in sorted(folder.glob("*.msg")):
        name = f"hybrid_dynamics_msgs/msg/{path.stem}"
        store.register(get_types_from_msg(path.read_text(encoding="utf-8"), name))
    return store


def deserialize(data: bytes, kind: str) -> Any:
    """A rosbags message from CDR bytes and type."""
    return typestore().deserialize_cdr(data, kind)
