"""The interface of output topics: name, rate, and encoding of messages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..messages.cdr import MessageTemplate
from ..parameters import TOPIC_RATES, Parameter
from .results import MotionResult

Rows = NDArray[np.intp]
Values = Sequence[NDArray[Any] | float]  # values of the slots of a template, in order
Message = tuple[MessageTemplate, Values]


class OutputTopic:
    """An output topic of a robot.

    Attributes:
        name: name below `~/`, or an absolute name.
        kind: message type.
        is_slow: whether a message takes so long that the node makes it in another thread.
    """

    name: ClassVar[str]
    kind: ClassVar[str]
    is_slow: ClassVar[bool] = False

    @property
    def rate(self) -> Parameter[float]:
        """The parameter with the largest rate of its messages."""
        return TOPIC_RATES[self.name]

    def message(self, result: MotionResult) -> Message | None:
        """Layout and values of the message of a sample, or of one message for each row.

        It is None if the result has no message on this topic.
        """
        raise NotImplementedError

    def groups(self, result: MotionResult) -> Sequence[Rows]:
        """Rows of a result whose messages have the same layout."""
        return [np.arange(len(result.position))]

    def fill(self, result: MotionResult) -> bytes | None:
        """The encoded message of one sample, or None."""
        message = self.message(result)
        if message is None:
            return None
        template, values = message
        return template.fill(result.stamp_ns, values)
