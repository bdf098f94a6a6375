"""The shipped recording: the paper's trajectory as messages of a sensor.

This module makes it reproducibly.

python -m hybrid_dynamics_ros.demo.play.recording FOLDER
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, Final

from ...bags.storage.bag_reader import read_raw
from ...bags.storage.bag_writer import new_bag
from ...bags.storage.storage import RawMessage
from ...messages.cdr import NS
from ...messages.interfaces import typestore
from ..topics import INPUT, TYPES, bag_topics
from ..trajectory import JOINTS, ROBOT, SOURCE, Trajectory, paper_trajectory

SHIPPED: Final = Path(__file__).resolve().parents[2] / "recordings" / ROBOT
FREQUENCY: Final = 100  # [Hz]
# 8 April 2020, the date of the paper; any fixed time would do.
START_NS: Final = 1_586_304_000 * NS


def recorded_messages() -> list[RawMessage]:
    """The recording: JointStates with positions and velocities of the active joints."""
    trajectory = paper_trajectory(FREQUENCY)
    messages = []
    for k in range(trajectory.time.size):
        stamp_ns = START_NS + k * NS // FREQUENCY
        message = _joint_state(stamp_ns, trajectory, k)
        data = bytes(typestore().serialize_cdr(message, TYPES[INPUT]))
        messages.append(RawMessage(stamp_ns, data))
    return messages


def _joint_state(stamp_ns: int, trajectory: Trajectory, row: int) -> Any:
    """A JointState of rosbags with a row of a trajectory."""
    types = typestore().types
    time = types["builtin_interfaces/msg/Time"]
    header = types["std_msgs/msg/Header"]
    stamp = time(sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
    return types[TYPES[INPUT]](
        header=header(stamp=stamp, frame_id=""),
        name=list(JOINTS),
        position=trajectory.position[row],
        velocity=trajectory.velocity[row],
        effort=trajectory.velocity[row, :0],
    )


def make_recording(path: Path) -> None:
    """Write the recording to a folder; an existing one is replaced.

    Raises:
        BagCallError: `path` exists and is no bag.
    """
    notes = {"source": SOURCE, "robot": ROBOT}
    with new_bag(path, bag_topics([INPUT]), notes) as bag:
        for message in recorded_messages():
            bag.write_message(INPUT, message.log_ns, message.data)


def shipped_messages() -> list[RawMessage]:
    """The messages of the shipped recording."""
    return read_raw(SHIPPED, INPUT)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    make_recording(Path(sys.argv[1]))
