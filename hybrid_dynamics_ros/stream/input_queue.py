"""Messages of one topic that wait for their answer. Of too many the newest state wins."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from typing import Final

_CALM: Final = 0.05  # [s] without a message left out: the overload is over
_TURN: Final = 0.02  # [s] after which the other topics have their turn
_SHORT: Final = 8  # messages that may wait under overload, and in the shortest queue


class InputQueue:
    """Waiting messages of one topic, none of which is in the way of another topic.

    As long as few wait, each is answered, in the order of arrival. When more than half of what the
    subscription holds waits, the newest message that can be answered is, and older ones are left
    out. From then on a handful may wait, until none had to be left out for a while.

    Attributes:
        skipped: messages that were left out so far.
    """

    def __init__(self, answer: Callable[[bytes], bool], depth: int) -> None:
        """An empty queue.

        Args:
            answer: answers a message; False where it cannot be used.
            depth: messages that the subscription holds.
        """
        self.skipped = 0
        self._answer = answer
        self._waiting: deque[bytes] = deque()
        self._depth = max(depth, 1)
        self._limit = max(depth // 2, _SHORT)
        self._overload_end = -1.0  # until then the newest state alone is answered [s]

    def __len__(self) -> int:
        return len(self._waiting)

    @property
    def is_overloaded(self) -> bool:
        """Whether messages are left out."""
        return time.perf_counter() < self._overload_end

    def put(self, message: bytes) -> None:
        """A message has come."""
        self._waiting.append(message)
        if len(self._waiting) > self._depth:
            self._waiting.popleft()
            self._skip(1)

    def clear(self) -> int:
        """Leave what waits unanswered; how many messages that are."""
        count = len(self._waiting)
        self._waiting.clear()
        return count

    def work(self) -> None:
        """Answer what waits, for one turn at most; what is left waits for the next turn."""
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
