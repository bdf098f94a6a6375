"""Which of many waiting messages are answered, and how many were lost on the way."""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_ros.stream import input_queue
from hybrid_dynamics_ros.stream.input_queue import InputQueue
from hybrid_dynamics_ros.stream.sequence_gaps import SequenceGaps

DEPTH = 20


class Answers:
    """Takes messages of one byte in front of their number: 1 can be used."""

    def __init__(self):
        self.used, self.refused = [], []

    def __call__(self, message):
        number = int.from_bytes(message[1:], "big")
        (self.used if message[0] else self.refused).append(number)
        return bool(message[0])


def message(number, usable):
    return bytes([usable]) + number.to_bytes(4, "big")


bursts = st.lists(st.lists(st.booleans(), min_size=1, max_size=3 * DEPTH), min_size=1, max_size=5)


@given(bursts)
def test_the_newest_message_that_can_be_used_is_answered_and_each_is_counted_once(sizes):
    """In bursts of any length with bad messages anywhere, and with nothing behind them."""
    answers = Answers()
    queue = InputQueue(answers, DEPTH)
    numbers = itertools.count()
    newest = None
    for burst in sizes:
        came = [(next(numbers), usable) for usable in burst]
        for number, usable in came:
            queue.put(message(number, usable))
        while queue:
            queue.work()
        held = came[-DEPTH:]  # as many as the subscription itself holds
        newest = max((number for number, usable in held if usable), default=newest)
        if newest is not None and newest >= held[0][0]:
            assert answers.used[-1] == newest
        assert len(answers.used) + len(answers.refused) + queue.skipped == came[-1][0] + 1
    assert answers.used == sorted(answers.used)


def test_messages_that_are_few_are_all_answered_in_order():
    answers = Answers()
    queue = InputQueue(answers, DEPTH)
    for number in range(DEPTH // 2):
        queue.put(message(number, True))
    while queue:
        queue.work()
    assert answers.used == list(range(DEPTH // 2))
    assert queue.skipped == 0


def test_a_turn_ends_though_messages_wait(monkeypatch):
    """Each message takes longer than a turn: the other topic is asked after each."""
    clock = itertools.count()
    queue = InputQueue(lambda _: False, DEPTH)
    monkeypatch.setattr(input_queue, "time", SimpleNamespace(perf_counter=lambda: next(clock)))
    for number in range(DEPTH):
        queue.put(message(number, False))
    sizes = []
    while queue:
        queue.work()
        sizes.append(len(queue))
        assert len(sizes) < 100
    assert len(sizes) > 3


def lost_of(streams, order):
    """Numbers that are missing between the first and the last that came of each publisher."""
    return sum(
        streams[k][-1] - streams[k][0] + 1 - len(streams[k]) for k in streams if k in set(order)
    )


@given(st.integers(0, 2**32), st.integers(1, 3))
def test_lost_messages_of_publishers_are_counted_by_their_numbers(seed, count):
    """Publishers in any order, with numbers far apart, each losing some."""
    source = np.random.default_rng(seed)
    present = frozenset(range(count))
    gaps = SequenceGaps(lambda: present)
    streams = {}
    for k in range(count):
        start = 10_000 * k + int(source.integers(1, 100))
        came = [start + n for n in range(40) if n == 0 or source.random() < 0.8]
        streams[k] = came
    order = [k for k in streams for _ in streams[k][1:]]
    source.shuffle(order)
    order = [*source.permutation(count).tolist(), *order]  # each is heard of first
    iterators = {k: iter(streams[k]) for k in streams}
    for k in order:
        gaps.note(next(iterators[k]))
    assert gaps.lost == lost_of(streams, order)


@given(st.integers(0, 2**32))
def test_no_message_counts_as_lost_that_came(seed):
    """Numbers of two publishers that are near each other: no more than were lost since the first.

    Where a publisher began is then not certain; that both began with the least number is possible.
    """
    source = np.random.default_rng(seed)
    gaps = SequenceGaps(lambda: frozenset("ab"))
    streams = {k: [n for n in range(1, 60) if source.random() < 0.8] for k in "ab"}
    order = [k for k in streams for _ in streams[k]]
    source.shuffle(order)
    iterators = {k: iter(streams[k]) for k in streams}
    for k in order:
        gaps.note(next(iterators[k]))
    least = min(map(min, streams.values()))
    assert 0 <= gaps.lost <= lost_of({k: [least, *streams[k]] for k in "ab"}, order) + 2


@pytest.mark.parametrize("first", [1, 500, 2])
def test_a_publisher_that_takes_the_place_of_another_begins_anew(first):
    publishers = [frozenset("a")]
    gaps = SequenceGaps(lambda: publishers[0])
    for number in (3, 4, 7):
        gaps.note(number)
    assert gaps.lost == 2
    publishers[0] = frozenset("b")
    gaps.note(first)
    gaps.note(first + 1)
    assert gaps.lost == 2
    gaps.note(first + 3)
    assert gaps.lost == 3
