"""Parsing of input bytes to samples.

Streams repeat one layout, whose numbers are read in place.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

from ..messages.conversions import sample_of_state
from ..messages.joint_samples import JointSample
from ..messages.joint_state_layout import JointStateLayout, LayoutError, layout_of

Read = Callable[[bytes], JointSample]


class StateReader:
    """Reads JointStates; those of the last layout without a message object."""

    def __init__(self, *, has_efforts: bool = False) -> None:
        """Start without a layout; `has_efforts` says whether efforts are read."""
        self._has_efforts = has_efforts
        self._layout: JointStateLayout | None = None

    def __call__(self, data: bytes) -> JointSample:
        """The sample of a JointState's bytes."""
        layout = self._layout
        if layout is None or not layout.fits(data):
            sample = sample_of_state(deserialize_message(data, JointState))
            try:
                self._layout = layout_of(data)
            except LayoutError:
                self._layout = None
            return sample
        velocity = layout.numbers_of(data, 1) if layout.starts[1][1] else None
        position = layout.numbers_of(data, 0)
        sample = JointSample(layout.stamp(data), layout.names, position, velocity)
        if self._has_efforts and layout.starts[2][1]:
            return sample._replace(effort=layout.numbers_of(data, 2))
        return sample


def reader_of(kind: type, sample_of: Callable[[Any], JointSample]) -> Read:
    """A reader of messages of any type, by message objects."""
    return lambda data: sample_of(deserialize_message(data, kind))
