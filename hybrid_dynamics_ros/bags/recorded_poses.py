"""Poses of ball and free joints in a recording, in the order of log times."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..messages.interfaces import deserialize
from ..messages.joint_poses import JOINT_POSES, samples_of_joint_poses
from ..messages.joint_samples import RejectedError
from ..messages.odometry import ODOMETRY, sample_of_odometry
from ..stream.floating.base import PosedMotion, PoseInput, PoseInputs
from .batch_outputs import NODE
from .errors import BagError
from .storage.bag_reader import BagReader
from .storage.storage import Losses

Newest = tuple[PosedMotion | None, ...]


class RecordedPoses:
    """Motions of the joints of one topic at each time of a bag."""

    def __init__(
        self,
        inputs: list[PoseInput],
        take: Callable[[bytes], None],
        messages: list[tuple[int, bytes]],
    ) -> None:
        """Let the inputs take all messages once.

        Args:
            inputs: the inputs of the topic.
            take: gives them a message; raises RejectedError if it is unusable.
            messages: log times [ns] and messages, in order.
        """
        self._inputs = inputs
        self._newest: list[Newest] = [(None,) * len(inputs)]
        self.problems: list[str] = []
        for log, data in messages:
            problem = _problem(take, data)
            if problem:
                self.problems.append(f"message logged at {log} ns: {problem}")
            self._newest.append(tuple(source.newest for source in inputs))
        self._log_ns = np.array([log for log, _ in messages], dtype=np.int64)
        self._set(self._newest[0])

    def go_to(self, log_ns: int) -> None:
        """Set the newest motions to those at a log time [ns]."""
        place = int(np.searchsorted(self._log_ns, log_ns, side="right"))
        self._set(self._newest[place])

    def _set(self, newest: Newest) -> None:
        for source, motion in zip(self._inputs, newest, strict=True):
            source.newest = motion


def recorded_poses(poses: PoseInputs, source: BagReader, losses: Losses) -> list[RecordedPoses]:
    """Odometry and poses of joints in a bag, where the inputs take them.

    Args:
        poses: the inputs of the pipeline.
        source: the bag.
        losses: list to which unusable messages are added.

    Raises:
        BagError: the bag has no such messages on the topic.
    """
    odometry, joint_poses = poses.odometry, poses.joints
    recorded = []
    if odometry is not None:
        take = _taker(ODOMETRY, sample_of_odometry, odometry.take)
        messages = _messages(source, odometry.topic, ODOMETRY)
        recorded.append((odometry.topic, RecordedPoses([odometry], take, messages)))
    if joint_poses is not None:
        take = _taker(JOINT_POSES, samples_of_joint_poses, joint_poses.take)
        messages = _messages(source, joint_poses.topic, JOINT_POSES)
        inputs = list(joint_poses.inputs.values())
        recorded.append((joint_poses.topic, RecordedPoses(inputs, take, messages)))
    for topic, one in recorded:
        for problem in one.problems:
            losses.add(f"{resolved(topic)}: {problem}")
    return [one for _, one in recorded]


def _taker(
    kind: str, sample_of: Callable[[Any], Any], take: Callable[[Any], None]
) -> Callable[[bytes], None]:
    return lambda data: take(sample_of(deserialize(data, kind)))


def _problem(take: Callable[[bytes], None], data: bytes) -> str:
    """Take a message, or return the reason why it is unusable."""
    try:
        take(data)
    except RejectedError as error:
        return error.rejection.text
    except Exception as error:  # noqa: BLE001 - whatever rosbags meets in damaged bytes
        return str(error) or type(error).__name__
    return ""


def _messages(source: BagReader, name: str, kind: str) -> list[tuple[int, bytes]]:
    """Log times and messages of a topic, in order; raises BagError if there is none."""
    topic = resolved(name)
    listed = source.topics.get(topic)
    if listed is None or listed.kind != kind:
        has = [entry.name for entry in source.topics.values() if entry.kind == kind]
        others = f"; it has some on {', '.join(has)}" if has else ""
        raise BagError(f"{source.path}: there is no {kind} on {topic}{others}")
    messages: list[tuple[int, bytes]] = []
    for _, part in source.read(frozenset([topic])):
        messages += [(log, part.message(row)) for row, log in enumerate(part.log_ns.tolist())]
    messages.sort(key=lambda message: message[0])
    return messages


def resolved(topic: str) -> str:
    """The resolved name of a topic of the node."""
    if topic.startswith("~/"):
        return f"{NODE}/{topic[2:]}"
    return topic if topic.startswith("/") else f"/{topic}"
