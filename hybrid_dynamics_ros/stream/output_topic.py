"""One topic that goes out: its name, its rate, and what fills its messages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..messages.cdr import MessageTemplate
from ..parameters import TOPIC_RATES, Parameter
from .results import MotionResult

Rows = NDArray[np.intp]
Values = Sequence[NDArray[Any] | float]  # of the slots of a template, in their order
Message = tuple[MessageTemplate, Values]


class OutputTopic:
    """One topic of a robot.

    Attributes:
        name: below ``~/``, or the whole name where it begins with a slash.
        kind: its type.
    """

    name: ClassVar[str]
    kind: ClassVar[str]

    @property
    def rate(self) -> Parameter[float]:
        """Parameter with the largest rate of its messages."""
        return TOPIC_RATES[self.name]

    def message(self, result: MotionResult) -> Message | None:
        """Layout and values of the message of one sample, or of one message a row.

        None where the result has no message on this topic.
        """
        raise NotImplementedError

    def groups(self, result: MotionResult) -> Sequence[Rows]:
        """Rows of a result whose messages have the same layout."""
        return [np.arange(len(result.position))]

    def fill(self, result: MotionResult) -> bytes | None:
        """The message of one sample."""
        message = self.message(result)
        if message is None:
            return None
        template, values = message
        return template.fill(result.stamp_ns, values)
