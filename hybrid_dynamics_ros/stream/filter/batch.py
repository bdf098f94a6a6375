"""The node's filter over rows of samples: the same steps in the same order.

Compiled where there is a compiler, else in Python: every bit is that of `PolynomialFilter.step`.
"""

from __future__ import annotations

from collections import Counter

import numpy as np
from numpy.typing import NDArray

from . import formula
from .compiled import advance_of
from .filter import FilterState, FloatArray, Moments, PolynomialFilter, StampEvent

Run = tuple[FloatArray, NDArray[np.bool_], Counter[StampEvent], FilterState]


def run_filter(
    filt: PolynomialFilter,
    state: FilterState | None,
    stamps: NDArray[np.int64],
    samples: FloatArray,
) -> Run:
    """All samples through the filter.

    Args:
        filt: the filter.
        state: before the first sample, or None at the start; it is not changed.
        stamps: (N,) [ns].
        samples: (N, n), finite; at least one.

    Returns:
        Derivatives (N, D + 1, n), whether each was ready (N,), what the stamps meant, and the state
        after the last.
    """
    count, n = samples.shape
    derivatives, ready = np.empty((count, filt.degree + 1, n)), np.empty(count, dtype=bool)
    events: Counter[StampEvent] = Counter()
    times = stamps.tolist()
    at = 0
    while at < count:
        if state is not None and state.degree == filt.degree:
            done, state = _advance(filt, state, stamps[at:], samples[at:], derivatives[at:])
            ready[at : at + done] = (stamps[at : at + done] - state.start_ns) * 1e-9 >= filt.lag
            events[StampEvent.NEXT] += done
            at += done
            if at == count:
                break
        state, event = filt.step(state, times[at], samples[at])
        derivatives[at], ready[at] = state.derivatives, filt.ready(state)
        events[event] += 1
        at += 1
    if state is None:
        raise ValueError("no samples")
    return derivatives, ready, events, state


def _advance(
    filt: PolynomialFilter,
    state: FilterState,
    stamps: NDArray[np.int64],
    samples: FloatArray,
    out: FloatArray,
) -> tuple[int, FilterState]:
    """The samples at the front that follow each other without a gap and keep the full degree.

    `out` (N, D + 1, n) is filled as far as that. Returns their number and the state after them.
    """
    intervals = np.diff(stamps, prepend=state.stamp_ns)
    seconds = intervals * 1e-9
    bad = np.flatnonzero((intervals <= 0) | (seconds > filt.max_gap))
    usable = int(bad[0]) if len(bad) else len(stamps)
    advance = advance_of(filt.degree)
    if advance is None:
        done, moments = _in_python(filt, state, seconds[:usable].tolist(), samples, out)
    else:
        past, last = np.array(state.moments), np.array(state.derivatives)
        # Of a type object of this process, where another one sent the samples.
        front = np.ascontiguousarray(samples[:usable]).view(np.float64)
        done = advance(seconds[:usable], front, np.array([filt.rate]), past, last, out[:usable])
        if done < 0:
            raise ValueError("expected float64 arrays in C order")
        moments = tuple(past.tolist())
    if not done:
        return 0, state
    return done, state._replace(
        stamp_ns=int(stamps[done - 1]),
        moments=moments,
        sample=samples[done - 1].copy(),
        derivatives=out[done - 1].copy(),
    )


def _in_python(
    filt: PolynomialFilter,
    state: FilterState,
    intervals: list[float],
    samples: FloatArray,
    out: FloatArray,
) -> tuple[int, Moments]:
    """The same without a compiler: rows done, and the moments after them."""
    moments, derivatives = state.moments, tuple(state.derivatives)
    settled = 0.0  # interval at which the moments, and so the gains, stay as they are [s]
    gains: tuple[float, ...] = ()
    with np.errstate(all="ignore"):
        for row, dt in enumerate(intervals):
            if dt != settled:
                after, gains = filt.update(moments, dt, filt.degree)
                if len(gains) <= filt.degree:
                    return row, moments
                settled = dt if after == moments else 0.0
                moments = after
            derivatives = formula.corrected(derivatives, dt, gains, samples[row])
            out[row] = derivatives
    return len(intervals), moments
