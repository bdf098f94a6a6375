"""The node's filter over many samples: the same steps in the same order, without an object for each of them.

Compiled where there is a compiler, else in plain floats: every bit is the same as that of
`PolynomialFilter.step`.
"""

from __future__ import annotations

from collections import Counter

import numpy as np
from numpy.typing import NDArray

from .compiled import advance_of
from .filter import FilterState, FloatArray, PolynomialFilter, StampEvent, _aged, _gains, _shares

Steps = list[
    tuple[float, float, float, float]
]  # dt [s], gains of value, first and second derivative
Moments = tuple[float, float, float, float, float]
Run = tuple[FloatArray, NDArray[np.bool_], Counter[StampEvent], FilterState]


def run_filter(
    filt: PolynomialFilter,
    state: FilterState | None,
    stamps: NDArray[np.int64],
    samples: FloatArray,
) -> Run:
    """All samples (N, n) through the filter.

    Returns:
        Derivatives (N, D + 1, n), whether each was ready (N,), what the stamps meant, the state
        after the last.
    """
    count, n = samples.shape
    derivatives, ready = np.empty((count, filt.degree + 1, n)), np.empty(count, dtype=bool)
    events: Counter[StampEvent] = Counter()
    at, times = 0, stamps.tolist()
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
    """The samples at the front that follow each other without a gap, as many as keep the full degree."""
    intervals = np.diff(stamps, prepend=state.stamp_ns)
    seconds = intervals * 1e-9
    bad = np.flatnonzero((intervals <= 0) | (seconds > filt.max_gap))
    usable = int(bad[0]) if len(bad) else len(stamps)
    compiled = advance_of(filt.degree)
    if compiled is None:
        done, moments = _in_python(filt, state, intervals[:usable].tolist(), samples, out)
        last = out[done - 1].copy()
    else:
        past, last = np.array(state.moments), np.array(state.derivatives)
        own = np.ascontiguousarray(samples[:usable]).view(
            np.float64
        )  # of a type object of another process, too
        done = compiled(seconds[:usable], own, np.array([filt.rate]), past, last, out[:usable])
        if done < 0:
            raise ValueError("expected float64 arrays in C order")
        moments = tuple(past.tolist())
    if not done:
        return 0, state
    return done, state._replace(
        stamp_ns=int(stamps[done - 1]),
        moments=moments,
        sample=samples[done - 1].copy(),
        derivatives=last,
    )


def _in_python(
    filt: PolynomialFilter,
    state: FilterState,
    intervals: list[int],
    samples: FloatArray,
    out: FloatArray,
) -> tuple[int, Moments]:
    """The same without a compiler: rows done, and the moments after them."""
    steps, moments = _steps(filt, state, intervals)
    done = len(steps)
    for k in range(samples.shape[1]):
        track = _second if filt.degree == 2 else _first
        if done:
            out[:done, :, k] = track(
                samples[:done, k].tolist(), steps, state.derivatives[:, k].tolist()
            )
    return done, moments


def _steps(
    filt: PolynomialFilter, state: FilterState, intervals: list[int]
) -> tuple[Steps, Moments]:
    rate, degree = filt.rate, filt.degree
    moments, steps = state.moments, []
    settled: tuple[int, tuple[float, float, float, float]] | None = (
        None  # interval at which the moments stay
    )
    for interval in intervals:
        if settled is not None and settled[0] == interval:
            steps.append(settled[1])
            continue
        dt = interval * 1e-9
        step = rate * dt
        decay, weight = _shares(step)
        after = _aged(moments, step, decay, weight)
        found, gains = _gains(after, weight, degree, rate)
        if found != degree:
            break
        settled = (interval, (dt, *gains)) if after == moments else None
        moments = after
        steps.append((dt, *gains))
    return steps, moments


def _first(samples: list[float], steps: Steps, start: list[float]) -> list[tuple[float, float]]:
    d0, d1 = start
    out = []
    for x, (dt, g0, g1, _) in zip(samples, steps, strict=True):
        d0 += dt * d1
        e = x - d0
        d0 += g0 * e
        d1 += g1 * e
        out.append((d0, d1))
    return out


def _second(
    samples: list[float], steps: Steps, start: list[float]
) -> list[tuple[float, float, float]]:
    d0, d1, d2 = start
    out = []
    for x, (dt, g0, g1, g2) in zip(samples, steps, strict=True):
        d0 += dt * d1
        d0 += 0.5 * dt * dt * d2
        d1 += dt * d2
        e = x - d0
        d0 += g0 * e
        d1 += g1 * e
        d2 += g2 * e
        out.append((d0, d1, d2))
    return out
