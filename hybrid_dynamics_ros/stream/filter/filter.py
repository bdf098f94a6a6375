"""Causal filters that estimate derivatives from samples at arbitrary stamps.

This module classifies stamps and keeps the state; `Steps` has the formulas. Single samples and rows
run the same code. Operations on samples are elementwise, so that the bits of a joint do not depend
on the others.
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

Condition = Any  # a float or a bool, or an array with one entry for each row


class StampEvent(Enum):
    """Event of a sample's stamp."""

    NEXT = "next"  # continues the sample before
    FIRST = "first"  # no sample before
    REPEATED = "repeated"  # same stamp and values: ignored
    CONFLICT = "conflicting stamp"  # same stamp, other values: restarted
    BACKWARD = "backward stamp"  # earlier than the sample before: restarted
    GAP = "gap"  # later than the largest gap: restarted


def restart_between(before_ns: int, stamp_ns: int, max_gap: float) -> StampEvent | None:
    """The event that prevents continuation between two samples; None if there is none.

    Args:
        before_ns: stamp of the earlier sample [ns].
        stamp_ns: stamp of the later sample [ns].
        max_gap: largest gap [s].
    """
    if stamp_ns < before_ns:
        return StampEvent.BACKWARD
    if (stamp_ns - before_ns) * 1e-9 > max_gap:
        return StampEvent.GAP
    return None


class FilterState(NamedTuple):
    """The state of a filter.

    Attributes:
        stamp_ns: stamp of the newest sample [ns].
        start_ns: stamp of the first sample since the last restart [ns].
        memory: values common to all joints, see `Steps`.
        sample: newest sample, (channels, n).
        derivatives: (D, n) fitted value and its derivatives at `stamp_ns` [unit/s^k];
            undetermined ones are zero.
    """

    stamp_ns: int
    start_ns: int
    memory: FloatArray
    sample: FloatArray
    derivatives: FloatArray

    @property
    def quality(self) -> float:
        """Quality of the estimate, in the filter's own measure."""
        return float(self.memory[-1])


class FilterRows(NamedTuple):
    """Estimates of N samples.

    Attributes:
        derivatives: after each sample, (N, D, n).
        ready: mask (N,) of usable derivatives.
        events: number of stamps by event.
        state: state after the last sample.
    """

    derivatives: FloatArray
    ready: NDArray[np.bool_]
    events: Counter[StampEvent]
    state: FilterState


class RateFilter(ABC):
    """A filter with its settings.

    Attributes:
        max_gap: gaps longer than this restart the filter [s].
    """

    max_gap: float

    @property
    @abstractmethod
    def lag(self) -> float:
        """Delay of the highest derivative for slow signals and dense samples [s]."""

    @property
    @abstractmethod
    def steps(self) -> tuple[Steps, ...]:
        """The formulas by number of channels, from one on."""

    @property
    @abstractmethod
    def constants(self) -> tuple[float, ...]:
        """The constants of the steps."""

    @abstractmethod
    def first_memory(self, channels: int) -> tuple[float, ...]:
        """The memory after one sample with a number of channels."""

    @abstractmethod
    def is_good(self, elapsed: Condition, quality: Condition) -> Condition:
        """Whether derivatives are usable.

        Args:
            elapsed: time since the last restart [s].
            quality: last number of the memory.
        """

    def prepare(self) -> None:
        """Check the settings and compile the code, before the first sample.

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
        """Whether the derivatives of a state are usable."""
        elapsed = (state.stamp_ns - state.start_ns) * 1e-9
        return bool(self.is_good(elapsed, state.quality))

    def step(
        self, state: FilterState | None, stamp_ns: int, sample: FloatArray
    ) -> tuple[FilterState, StampEvent]:
        """The state after one more sample.

        Args:
            state: previous state, or None at the start; it is not changed.
            stamp_ns: stamp of the sample [ns].
            sample: (channels, n), finite.

        Returns:
            The new state, and the event of the stamp. Backward stamps, conflicting stamps and gaps
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
        """Advance by samples: fills `fitted` and `quality`, and returns the memory.

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
        """Results of `step` for N consecutive samples.

        Args:
            state: state before the first sample, or None; it is not changed.
            stamps: (N,) [ns].
            samples: (N, channels, n), finite; at least one.
        """
        count, _, n = samples.shape
        derivatives = np.empty((count, self.steps[0].derivatives, n))
        ready = np.empty(count, dtype=bool)
        events: Counter[StampEvent] = Counter()
        # Converts to a dtype object of this process.
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
        """Process the first samples, up to a gap.

        It fills `derivatives` and `ready`, and returns the number of samples and the state after
        them.
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
    """Check that a setting is a finite number above 0.

    Raises:
        ValueError: it is not.
    """
    if not (math.isfinite(value) and value > 0.0):
        raise ValueError(f"{name} is {value}, expected a finite number above 0")
