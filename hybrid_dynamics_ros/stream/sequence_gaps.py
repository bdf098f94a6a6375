"""Messages that were lost on the way, by the numbers that their publishers gave them."""

from __future__ import annotations

from collections.abc import Callable, Hashable


class SequenceGaps:
    """Counts the numbers that never came.

    Numbers say nothing about who sent them. Each continues the nearest one below it: which of two
    publishers lost a message may then be mixed up, the sum is right.

    Attributes:
        lost: how many numbers are missing so far.
    """

    def __init__(self, publishers: Callable[[], frozenset[Hashable]]) -> None:
        """Nothing has come yet.

        Args:
            publishers: who publishes now. It is asked where a number does not continue the last.
        """
        self.lost = 0
        self._publishers = publishers
        self._present: frozenset[Hashable] = frozenset()
        # Number of each publisher's newest message, the last used last.
        self._newest: list[int] = []

    def note(self, number: int) -> None:
        """A message with this number has come."""
        newest = self._newest
        if newest and newest[-1] + 1 == number:
            newest[-1] = number
        else:
            self._note_jump(number)

    def _note_jump(self, number: int) -> None:
        present = self._publishers()
        if not self._present <= present:
            self._newest.clear()  # one has left, and nobody knows which number was its own
        self._present = present
        newest = self._newest
        before = max((other for other in newest if other < number), default=None)
        is_first = len(newest) < len(present)  # of one that has not been heard of
        if before is not None and (before + 1 == number or not is_first):
            self.lost += number - before - 1
            newest.remove(before)
        newest.append(number)
        del newest[: -max(len(present), 1)]
