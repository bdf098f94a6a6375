"""The node's output topics for a bag, encoded in bulk."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

from hybrid_dynamics_core import Robot

from ..parameters import NodeSettings
from ..stream.output_topic import OutputTopic
from ..stream.rate_limit import RateLimit
from ..stream.topics import topics_of
from .batch_pipeline import BatchResult
from .storage.mcap_chunk import RecordBlock

NODE: Final = "/hybrid_dynamics"


@dataclass(frozen=True)
class BagOutput:
    """One output topic of a bag: its name, the encoder of its messages, and its rate limit."""

    name: str
    topic: OutputTopic
    rate: float
    limit: RateLimit = field(default_factory=RateLimit)

    def blocks(self, channel: int, result: BatchResult) -> Iterator[RecordBlock]:
        """The messages for a result."""
        due = self.limit.due_rows(result.stamp_ns, self.rate)
        for run, log_ns in result.at(due):
            for rows in self.topic.groups(run):
                part = run.rows(rows)
                message = self.topic.message(part) if len(rows) else None
                if message is not None:
                    template, values = message
                    slots = template.named(part.stamp_ns, values)
                    yield RecordBlock.filled(channel, log_ns[rows], template, slots)


def outputs_of(robot: Robot, settings: NodeSettings) -> list[BagOutput]:
    """All topics of the node for one robot."""
    outputs = []
    for topic in topics_of(robot, settings):
        name = topic.name if topic.name.startswith("/") else f"{NODE}/{topic.name}"
        outputs.append(BagOutput(name, topic, settings[topic.rate]))
    return outputs
