"""Counting of lost messages by sequence numbers."""

from __future__ import annotations

from collections.abc import Callable, Hashable


class SequenceGaps:
    """Counts missing sequence numbers.

    Sequence numbers do not identify the publisher. Each continues the nearest one below it. With
    several publishers the losses may be assigned to a wrong one, but their sum is right.

    Attributes:
        lost: number of missing messages so far.
    """

    def __init__(self, publishers: Callable[[], frozenset[Hashable]]) -> None:
        """Start without messages.

        Args:
            publishers: returns the present publishers; called if a number does not continue the
                last.
        """
        self.lost = 0
        self._publishers = publishers
        self._present: frozenset[Hashable] = frozenset()
        # Newest number of each publisher, the most recent last.
        self._newest: list[int] = []

    def note(self, number: int) -> None:
        """Register the number of a message."""
        newest = self._newest
        if newest and newest[-1] + 1 == number:
            newest[-1] = number
        else:
            self._note_jump(number)

    def _note_jump(self, number: int) -> None:
        present = self._publishers()
        if not self._present <= present:
            self._newest.clear()  # a publisher has left, and its number is unknown
        self._present = present
        newest = self._newest
        before = max((other for other in newest if other < number), default=None)
        is_first = len(newest) < len(present)  # from a new publisher
        if before is not None and (before + 1 == number or not is_first):
            self.lost += number - before - 1
            newest.remove(before)
        newest.append(number)
        del newest[: -max(len(present), 1)]
