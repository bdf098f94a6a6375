"""Odometry of a recording, in the order of log times."""

from __future__ import annotations

import numpy as np

from ..messages.interfaces import deserialize
from ..messages.joint_samples import RejectedError
from ..messages.odometry import ODOMETRY, sample_of_odometry
from ..stream.floating.base import BaseMotion, OdometryInput
from .batch_outputs import NODE
from .errors import BagError
from .storage.bag_reader import BagReader
from .storage.storage import Losses


class RecordedOdometry:
    """Motion of the base at each time of a bag."""

    def __init__(self, odometry: OdometryInput, source: BagReader, losses: Losses) -> None:
        """Read all odometry of a bag.

        Args:
            odometry: odometry input of the pipeline.
            source: the bag.
            losses: list to which unusable messages are added.

        Raises:
            BagError: the bag has no odometry on the topic.
        """
        self._odometry = odometry
        topic = resolved(odometry.topic)
        listed = source.topics.get(topic)
        if listed is None or listed.kind != ODOMETRY:
            has = [entry.name for entry in source.topics.values() if entry.kind == ODOMETRY]
            others = f"; it has odometry on {', '.join(has)}" if has else ""
            raise BagError(f"{source.path}: there is no {ODOMETRY} on {topic}{others}")
        messages: list[tuple[int, bytes]] = []
        for _, part in source.read(frozenset([topic])):
            messages += [(log, part.message(row)) for row, log in enumerate(part.log_ns.tolist())]
        messages.sort(key=lambda message: message[0])
        self._newest: list[BaseMotion | None] = [None]
        for log, data in messages:
            problem = self._take(data)
            if problem:
                losses.add(f"{topic}: message logged at {log} ns: {problem}")
            self._newest.append(odometry.newest)
        self._log_ns = np.array([log for log, _ in messages], dtype=np.int64)
        odometry.newest = None

    def _take(self, data: bytes) -> str:
        """Store a message, or return the reason why it is unusable."""
        try:
            self._odometry.take(sample_of_odometry(deserialize(data, ODOMETRY)))
        except RejectedError as error:
            return error.rejection.text
        except Exception as error:  # noqa: BLE001 - whatever rosbags meets in damaged bytes
            return str(error) or type(error).__name__
        return ""

    def go_to(self, log_ns: int) -> None:
        """Set the newest motion to that at a log time [ns]."""
        place = int(np.searchsorted(self._log_ns, log_ns, side="right"))
        self._odometry.newest = self._newest[place]


def resolved(topic: str) -> str:
    """The resolved name of a topic of the node."""
    if topic.startswith("~/"):
        return f"{NODE}/{topic[2:]}"
    return topic if topic.startswith("/") else f"/{topic}"
