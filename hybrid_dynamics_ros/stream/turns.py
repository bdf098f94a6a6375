"""Unwrapping of encoder angles, which are in (-pi, pi] or [0, 2 pi).

A step of more than half a turn between samples counts as a wrap, unless a measured velocity
explains it. Then the nearest number of whole turns is subtracted from later angles.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from operator import sub
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..messages.joint_samples import FloatArray
from .filter.filter import restart_between

TURN: Final = 2.0 * math.pi  # [rad]
_HALF: Final = 0.5 * TURN


class TurnState(NamedTuple):
    """State after a sample.

    Attributes:
        stamp_ns: its stamp [ns].
        readings: readings of the sample [rad or m].
        turns: whole turns to add to each joint's readings.
        shift: these turns as angles (n,) [rad]; None if all are zero.
    """

    stamp_ns: int
    readings: list[float]
    turns: tuple[int, ...]
    shift: FloatArray | None


class TurnRows(NamedTuple):
    """N unwrapped samples.

    Attributes:
        state: state after the last sample; None without samples.
        position: (N, n), without jumps [rad or m].
        wraps: number of removed jumps, by joint.
    """

    state: TurnState | None
    position: FloatArray
    wraps: Counter[str]


class TurnCounter:
    """Unwraps the angles of some joints; it restarts after a gap or a backward stamp.

    `step` takes one sample, `run` a batch: both give the same bits.
    """

    def __init__(self, names: Sequence[str], is_angle: Sequence[bool], max_gap: float) -> None:
        """Set up the counter. It keeps no state: states are given and returned.

        Args:
            names: joints.
            is_angle: whether each joint is an angle; lengths are not changed.
            max_gap: largest gap between samples [s].
        """
        self._names = tuple(names)
        # a longer step is a jump; infinite for lengths
        self._longest_steps = [_HALF if turns else math.inf for turns in is_angle]
        self._max_gap = max_gap
        self._at_start = (0,) * len(self._names)

    def step(
        self,
        state: TurnState | None,
        stamp_ns: int,
        position: FloatArray,
        velocity: FloatArray | None,
    ) -> tuple[TurnState, FloatArray]:
        """State and unwrapped position (n,) after one more sample.

        Args:
            state: previous state, or None at the start; it is not changed.
            stamp_ns: stamp [ns].
            position: (n,) readings [rad or m].
            velocity: (n,) [rad/s or m/s], NaN where not measured; None for no joint.
        """
        readings = position.tolist()
        if state is None or not self._goes_on(state.stamp_ns, stamp_ns):
            return TurnState(stamp_ns, readings, self._at_start, None), position
        turns, shift = state.turns, state.shift
        # Plain floats are faster than NumPy for short arrays, and every message needs it.
        steps = map(sub, readings, state.readings)
        if max(map(abs, steps)) > _HALF:
            turns = self._continued(state, stamp_ns, readings, velocity)
            shift = TURN * np.array(turns) if any(turns) else None
        if shift is not None:
            position = position + shift
        return TurnState(stamp_ns, readings, turns, shift), position

    def run(
        self,
        state: TurnState | None,
        stamps: NDArray[np.int64],
        position: FloatArray,
        velocity: FloatArray,
    ) -> TurnRows:
        """Results of `step` for N consecutive samples.

        Args:
            state: previous state, or None at the start; it is not changed.
            stamps: (N,) [ns].
            position: (N, n) readings [rad or m].
            velocity: (N, n) [rad/s or m/s], NaN where not measured.
        """
        wraps: Counter[str] = Counter()
        continued = position
        edges = [*self._breaks(stamps, position), len(stamps)]
        first = 0  # first row with the turns of `state`
        for row in edges:
            if first < row and state is not None:
                last = int(stamps[row - 1])
                state = state._replace(stamp_ns=last, readings=position[row - 1].tolist())
                if state.shift is not None:
                    continued = _copied_once(continued, position)
                    continued[first:row] = position[first:row] + state.shift
            if row == len(stamps):
                break
            before = state
            state, continued_row = self.step(before, int(stamps[row]), position[row], velocity[row])
            if state.shift is not None:
                continued = _copied_once(continued, position)
                continued[row] = continued_row
            wraps.update(self.wraps(before, state))
            first = row + 1
        return TurnRows(state, continued, wraps)

    def wraps(self, before: TurnState | None, after: TurnState) -> Counter[str]:
        """Number of removed jumps between two samples, by joint."""
        if before is None or after.turns is before.turns or after.turns is self._at_start:
            return Counter()
        pairs = zip(self._names, before.turns, after.turns, strict=True)
        return Counter({name: abs(new - old) for name, old, new in pairs if new != old})

    def _goes_on(self, before_ns: int, stamp_ns: int) -> bool:
        return restart_between(before_ns, stamp_ns, self._max_gap) is None

    def _breaks(self, stamps: NDArray[np.int64], position: FloatArray) -> list[int]:
        """The first row, and each row after a jump, a gap or a backward stamp."""
        intervals = np.diff(stamps)
        steps = np.abs(np.diff(position, axis=0))
        is_break = (steps > self._longest_steps).any(axis=1)
        is_break |= (intervals < 0) | (intervals * 1e-9 > self._max_gap)
        rows: list[int] = (np.flatnonzero(is_break) + 1).tolist()
        return [0, *rows] if len(stamps) else []

    def _continued(
        self,
        state: TurnState,
        stamp_ns: int,
        readings: Sequence[float],
        velocity: FloatArray | None,
    ) -> tuple[int, ...]:
        """Turns of each joint after a sample with a jump."""
        interval = (stamp_ns - state.stamp_ns) * 1e-9
        turns = list(state.turns)
        for k, longest in enumerate(self._longest_steps):
            step = readings[k] - state.readings[k]
            if abs(step) > longest:
                motion = 0.0
                if velocity is not None and math.isfinite(velocity[k]):
                    motion = float(velocity[k]) * interval
                turns[k] -= round((step - motion) / TURN)
        return state.turns if turns == list(state.turns) else tuple(turns)


def _copied_once(continued: FloatArray, position: FloatArray) -> FloatArray:
    """A writable array, copied at the first jump only."""
    if continued is position:
        return position.copy()
    return continued
