"""A filter that estimates derivatives from samples, at any stamps: what stamps mean, and its state.

It is causal. The arithmetic is that of its `Steps`; one sample and rows of samples go through the
same code. All work on samples is elementwise, so joints go through together, and the bits of one do
not depend on the others.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import Counter
from enum import Enum
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .recursion import Advance, FloatArray, advance_of
from .steps import Steps

Condition = Any  # a float or a bool, or an array of them with one entry a row


class StampEvent(Enum):
    """What the stamp of a sample meant to the filter."""

    NEXT = "next"  # went on from the sample before
    FIRST = "first"  # no sample before
    REPEATED = "repeated"  # same stamp and same values: nothing new
    CONFLICT = "conflicting stamp"  # same stamp, other values: restarted
    BACKWARD = "backward stamp"  # earlier than the sample before: restarted
    GAP = "gap"  # later than the largest gap: restarted


def restart_between(before_ns: int, stamp_ns: int, max_gap: float) -> StampEvent | None:
    """Why what is remembered of a sample says nothing of the next; None where it does.

    Args:
        before_ns: stamp of the sample [ns].
        stamp_ns: stamp of the next [ns].
        max_gap: largest time between two samples that follow each other [s].
    """
    if stamp_ns < before_ns:
        return StampEvent.BACKWARD
    if (stamp_ns - before_ns) * 1e-9 > max_gap:
        return StampEvent.GAP
    return None


class FilterState(NamedTuple):
    """All that the filter remembers.

    Attributes:
        stamp_ns: stamp of the newest sample [ns].
        start_ns: stamp of the first sample since the last restart [ns].
        memory: what the joints share, see `Steps`.
        sample: newest sample, (channels, n).
        derivatives: (D, n), the fitted value and its derivatives at ``stamp_ns`` [unit/s^k]; those
            that the samples never determined are zero.
    """

    stamp_ns: int
    start_ns: int
    memory: FloatArray
    sample: FloatArray
    derivatives: FloatArray

    @property
    def quality(self) -> float:
        """How good the estimate is, by the measure of the filter."""
        return float(self.memory[-1])


class FilterRows(NamedTuple):
    """What the filter makes of N samples.

    Attributes:
        derivatives: after each sample, (N, D, n).
        ready: whether they can be used, (N,).
        events: how often a stamp was which event.
        state: after the last sample.
    """

    derivatives: FloatArray
    ready: NDArray[np.bool_]
    events: Counter[StampEvent]
    state: FilterState


class RateFilter(ABC):
    """A filter with its settings.

    Attributes:
        max_gap: stamps further apart than this restart the filter [s].
    """

    max_gap: float

    @property
    @abstractmethod
    def lag(self) -> float:
        """Delay of the highest derivative for slow signals and dense samples [s]."""

    @property
    @abstractmethod
    def steps(self) -> tuple[Steps, ...]:
        """The formulas for one channel, for two, and so on, as far as the filter takes them."""

    @property
    @abstractmethod
    def constants(self) -> tuple[float, ...]:
        """The constants of the steps."""

    @abstractmethod
    def first_memory(self, channels: int) -> tuple[float, ...]:
        """The memory after one sample of so many values a joint."""

    @abstractmethod
    def is_good(self, elapsed: Condition, quality: Condition) -> Condition:
        """Whether derivatives can be used.

        Args:
            elapsed: time since the last restart [s].
            quality: last number of the memory.
        """

    def prepare(self) -> None:
        """Check the settings and make the code now, not while the first sample waits.

        Raises:
            ValueError: a setting is not a positive number.
        """
        require_positive("max_gap", self.max_gap)
        _ = self._advances, self._constants

    @cached_property
    def _advances(self) -> tuple[Advance, ...]:
        return tuple(advance_of(steps) for steps in self.steps)

    @cached_property
    def _constants(self) -> FloatArray:
        return np.array(self.constants)

    def ready(self, state: FilterState) -> bool:
        """Whether the derivatives of a state can be used."""
        elapsed = (state.stamp_ns - state.start_ns) * 1e-9
        return bool(self.is_good(elapsed, state.quality))

    def step(
        self, state: FilterState | None, stamp_ns: int, sample: FloatArray
    ) -> tuple[FilterState, StampEvent]:
        """The state after one more sample.

        Args:
            state: state before, or None at the start. It is not changed.
            stamp_ns: stamp of the sample [ns].
            sample: (channels, n), finite.

        Returns:
            The new state, and what the stamp meant. Backward stamps, conflicting stamps and gaps
            restart the filter from this sample.
        """
        event = self._event(state, stamp_ns, sample)
        if state is None or event not in (StampEvent.NEXT, StampEvent.REPEATED):
            return self._start(stamp_ns, sample), event
        if event is StampEvent.REPEATED:
            return state, event
        interval, samples = np.array([(stamp_ns - state.stamp_ns) * 1e-9]), np.array([sample])
        fitted = np.empty((1, *state.derivatives.shape))
        memory = self._advance(state, interval, samples, fitted, np.empty(1))
        return FilterState(stamp_ns, state.start_ns, memory, samples[0], fitted[0]), event

    def _event(self, state: FilterState | None, stamp_ns: int, sample: FloatArray) -> StampEvent:
        if state is None:
            return StampEvent.FIRST
        if stamp_ns == state.stamp_ns:
            is_same = np.array_equal(sample, state.sample)
            return StampEvent.REPEATED if is_same else StampEvent.CONFLICT
        return restart_between(state.stamp_ns, stamp_ns, self.max_gap) or StampEvent.NEXT

    def _start(self, stamp_ns: int, sample: FloatArray) -> FilterState:
        channels, n = sample.shape
        derivatives = np.zeros((self.steps[0].derivatives, n))
        derivatives[:channels] = sample
        memory = np.array(self.first_memory(channels))
        return FilterState(stamp_ns, stamp_ns, memory, sample.copy(), derivatives)

    def _advance(
        self,
        state: FilterState,
        intervals: FloatArray,
        samples: FloatArray,
        fitted: FloatArray,
        quality: FloatArray,
    ) -> FloatArray:
        """Samples that go on from a state: `fitted` and `quality` are filled; the memory after.

        Arguments are those of `recursion.Advance`.
        """
        advance, memory = self._advances[samples.shape[1] - 1], state.memory.copy()
        before = state.derivatives
        if advance(intervals, samples, self._constants, memory, before, fitted, quality):
            raise ValueError("expected float64 arrays in C order")
        return memory

    def run(
        self, state: FilterState | None, stamps: NDArray[np.int64], samples: FloatArray
    ) -> FilterRows:
        """What `step` gives for each of N samples, one after the other.

        Args:
            state: before the first sample, or None at the start; it is not changed.
            stamps: (N,) [ns].
            samples: (N, channels, n), finite; at least one.
        """
        count, _, n = samples.shape
        derivatives = np.empty((count, self.steps[0].derivatives, n))
        ready = np.empty(count, dtype=bool)
        events: Counter[StampEvent] = Counter()
        # Of a type object of this process, where another one sent the samples.
        samples = np.ascontiguousarray(samples).view(np.float64)
        at = 0
        while at < count:
            if state is not None:
                done, state = self._run_front(
                    state, stamps[at:], samples[at:], derivatives[at:], ready[at:]
                )
                events[StampEvent.NEXT] += done
                at += done
                if at == count:
                    break
            state, event = self.step(state, int(stamps[at]), samples[at])
            derivatives[at], ready[at] = state.derivatives, self.ready(state)
            events[event] += 1
            at += 1
        if state is None:
            raise ValueError("no samples")
        return FilterRows(derivatives, ready, events, state)

    def _run_front(
        self,
        state: FilterState,
        stamps: NDArray[np.int64],
        samples: FloatArray,
        derivatives: FloatArray,
        ready: NDArray[np.bool_],
    ) -> tuple[int, FilterState]:
        """The samples at the front that follow each other without a gap.

        `derivatives` and `ready` are filled as far as that. Returns their number and the state
        after them.
        """
        intervals = np.diff(stamps, prepend=state.stamp_ns)
        seconds = intervals * 1e-9
        restarts = np.flatnonzero((intervals <= 0) | (seconds > self.max_gap))
        done = int(restarts[0]) if len(restarts) else len(stamps)
        if not done:
            return 0, state
        quality = np.empty(done)
        memory = self._advance(state, seconds[:done], samples[:done], derivatives[:done], quality)
        ready[:done] = self.is_good((stamps[:done] - state.start_ns) * 1e-9, quality)
        last = done - 1
        return done, FilterState(
            stamp_ns=int(stamps[last]),
            start_ns=state.start_ns,
            memory=memory,
            sample=samples[last].copy(),
            derivatives=derivatives[last].copy(),
        )


def require_positive(name: str, value: float) -> None:
    """Refuse a setting that is not a finite number above 0.

    Raises:
        ValueError: it is none.
    """
    if not (math.isfinite(value) and value > 0.0):
        raise ValueError(f"{name} is {value}, expected a finite number above 0")
