"""Reading of recordings in pieces, in the order of log times."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import Final, Protocol

from .message_records import split_by_time
from .storage import Messages, Topic

_LATEST: Final = 2**63 - 1  # [ns]
_MAX_WAITING: Final = 8  # largest number of pending parts of a topic


@dataclass(frozen=True)
class Piece:
    """A part of a recording that is read as a whole: a chunk or a file.

    Attributes:
        span: first and last log time [ns].
        read: reads its messages by topic, each topic in the order of log times.
    """

    span: tuple[int, int]
    read: Callable[[], Iterator[tuple[str, Messages]]]


class Storage(Protocol):
    """One file of a bag."""

    def topics(self) -> list[Topic]:
        """The topics of the file."""

    def pieces(self, wanted: frozenset[str] | None) -> Sequence[Piece]:
        """Pieces of the file, in the order of their first log times.

        Args:
            wanted: names of topics; None for all.
        """

    def close(self) -> None:
        """Close the file."""


def in_time_order(pieces: Sequence[Piece]) -> Iterator[tuple[str, Messages]]:
    """Messages of all pieces in the order of log times, also if pieces overlap."""
    ordered = sorted(pieces, key=lambda piece: piece.span[0])
    borders = [min(piece.span[0], _LATEST) for piece in ordered[1:]]
    waiting: dict[str, list[Messages]] = {}
    for piece, border in zip_longest(ordered, borders):
        for topic, messages in piece.read():
            if not len(messages):
                continue
            parts = waiting.setdefault(topic, [])
            parts.append(messages)
            last = int(messages.log_ns[-1])
            # up to here the topic is complete, while its piece has further messages
            until = last + 1 if border is None else min(last + 1, border)
            is_alone = len(parts) == 1 and last < until
            if is_alone or len(parts) > _MAX_WAITING:
                yield from _ready(waiting, topic, until)
        for topic in list(waiting):
            yield from _ready(waiting, topic, border)


def _ready(
    waiting: dict[str, list[Messages]], topic: str, border: int | None
) -> Iterator[tuple[str, Messages]]:
    """The pending messages of a topic up to `border`; later ones stay pending."""
    ready, later = split_by_time(waiting.pop(topic), border)
    if later is not None:
        waiting[topic] = [later]
    if len(ready):
        yield topic, ready
