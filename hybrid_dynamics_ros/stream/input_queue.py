"""The queue of pending messages of a topic; under overload only the newest is processed."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import Final

_CALM: Final = 0.05  # [s] without a skipped message, after which the overload is over
_TURN: Final = 0.02  # [s] after which other topics are served
_SHORT: Final = 8  # [messages] length of the queue under overload, and of the shortest queue


class InputQueue:
    """Pending messages of one topic, which do not block other topics.

    As long as few messages are pending, each is processed, in the order of arrival. If more than
    half of the subscription's depth is pending, only the newest usable message is processed, and
    older ones are skipped. Then only a few may be pending, until none was skipped for a while.

    Attributes:
        skipped: number of skipped messages so far.
    """

    def __init__(self, answer: Callable[[bytes], bool], depth: int) -> None:
        """Make an empty queue.

        Args:
            answer: processes a message; returns False if it is unusable.
            depth: depth of the subscription.
        """
        self.skipped = 0
        self._answer = answer
        self._waiting: deque[bytes] = deque()
        self._depth = max(depth, 1)
        self._limit = max(depth // 2, _SHORT)
        self._overload_end = -1.0  # [s] until then only the newest state is processed

    def __len__(self) -> int:
        return len(self._waiting)

    @property
    def is_overloaded(self) -> bool:
        """Whether messages are skipped."""
        return time.perf_counter() < self._overload_end

    def put(self, message: bytes) -> None:
        """Add a message."""
        self._waiting.append(message)
        if len(self._waiting) > self._depth:
            self._waiting.popleft()
            self._skip(1)

    def clear(self) -> int:
        """Discard pending messages; returns their number."""
        count = len(self._waiting)
        self._waiting.clear()
        return count

    def work(self) -> None:
        """Process pending messages, for at most one turn; the rest stays pending."""
        end = time.perf_counter() + _TURN
        limit = self._limit
        if self.is_overloaded:
            limit = _SHORT
        answer = self._answer_oldest
        if len(self._waiting) > limit:
            self._overload_end = end + _CALM
            answer = self._answer_newest
        while self._waiting:
            answer()
            if time.perf_counter() > end:
                break

    def _answer_oldest(self) -> None:
        self._answer(self._waiting.popleft())

    def _answer_newest(self) -> None:
        if self._answer(self._waiting.pop()):
            self._skip(len(self._waiting))
            self._waiting.clear()

    def _skip(self, count: int) -> None:
        self.skipped += count
        if count:
            self._overload_end = time.perf_counter() + _CALM
