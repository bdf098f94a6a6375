"""The shipped recording.

The paper's trajectory as a sensor would send it. Made by this module, the same every time.

python -m hybrid_dynamics_ros.demo.play.recording FOLDER
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Final

from ...bags.storage.bag_reader import read_raw
from ...bags.storage.bag_writer import new_bag
from ...bags.storage.storage import RawMessage
from ...messages.interfaces import typestore
from ..topics import INPUT, TYPES, bag_topics
from ..trajectory import JOINTS, ROBOT, SOURCE, paper_trajectory

SHIPPED: Final = Path(__file__).resolve().parents[2] / "recordings" / ROBOT
FREQUENCY: Final = 100  # [Hz]
START_NS: Final = (
    1_586_304_000 * 10**9
)  # 8 April 2020, the day of the paper: any fixed time would do


def recorded_messages() -> list[RawMessage]:
    """The messages of the recording.

    JointState with positions and velocities of the active joints.
    """
    types = typestore().types
    joint_state, header, time = (
        types[name]
        for name in (
            "sensor_msgs/msg/JointState",
            "std_msgs/msg/Header",
            "builtin_interfaces/msg/Time",
        )
    )
    trajectory = paper_trajectory(FREQUENCY)
    messages = []
    for k in range(trajectory.time.size):
        stamp_ns = START_NS + k * 10**9 // FREQUENCY
        message = joint_state(
            header=header(stamp=time(sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9), frame_id=""),
            name=list(JOINTS),
            position=trajectory.position[k],
            velocity=trajectory.velocity[k],
            effort=trajectory.velocity[k, :0],
        )
        messages.append(
            RawMessage(stamp_ns, bytes(typestore().serialize_cdr(message, TYPES[INPUT])))
        )
    return messages


def make_recording(path: Path) -> None:
    """Write the recording to the folder ``path``, in place of one there."""
    with new_bag(path, bag_topics([INPUT]), {"source": SOURCE, "robot": ROBOT}) as bag:
        for message in recorded_messages():
            bag.write_message(INPUT, message.log_ns, message.data)


def shipped_messages() -> list[RawMessage]:
    """The messages of the shipped recording."""
    return read_raw(SHIPPED, INPUT)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    make_recording(Path(sys.argv[1]))
