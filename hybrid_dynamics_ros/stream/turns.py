"""Continues angles across the wrap of encoders, which give (-pi, pi] or [0, 2 pi).

A step of more than half a turn from one sample to the next is no motion, unless a measured velocity
says that it is. The nearest number of whole turns is subtracted, from then on.
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
    """What is remembered of the sample before.

    Attributes:
        stamp_ns: its stamp [ns].
        readings: its angles and lengths, as they came [rad or m].
        turns: whole turns to add to the readings of each joint.
        shift: the same (n,) as angles [rad]; None where all are zero.
    """

    stamp_ns: int
    readings: list[float]
    turns: tuple[int, ...]
    shift: FloatArray | None


class TurnRows(NamedTuple):
    """N samples, continued.

    Attributes:
        state: state after the last sample; None if none has come yet.
        position: (N, n), without jumps [rad or m].
        wraps: number of jumps that were removed, by joint.
    """

    state: TurnState | None
    position: FloatArray
    wraps: Counter[str]


class TurnCounter:
    """Continues the angles of some joints. After a gap, or a stamp that goes back, it starts anew.

    `step` takes one sample, `run` a batch: both give the same bits.
    """

    def __init__(self, names: Sequence[str], is_angle: Sequence[bool], max_gap: float) -> None:
        """Set up the counter. It keeps no state: states are given and returned.

        Args:
            names: joints.
            is_angle: whether each joint turns; lengths stay as they are.
            max_gap: largest time between two samples that follow each other [s].
        """
        self._names = tuple(names)
        # a longer step is a jump; of lengths none is
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
        """State and continued position (n,) of one more sample.

        Args:
            state: state before, or None at the start; it is not changed.
            stamp_ns: stamp [ns].
            position: (n,) as it came [rad or m].
            velocity: (n,) [rad/s or m/s], NaN where it was not measured; None: of no joint.
        """
        readings = position.tolist()
        if state is None or not self._goes_on(state.stamp_ns, stamp_ns):
            return TurnState(stamp_ns, readings, self._at_start, None), position
        turns, shift = state.turns, state.shift
        # In plain floats: this is done for every message, and NumPy is slow for so short arrays.
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
        """What `step` gives for each of N samples, one after the other.

        Args:
            state: state before, or None at the start; it is not changed.
            stamps: (N,) [ns].
            position: (N, n) as they came [rad or m].
            velocity: (N, n) [rad/s or m/s], NaN where it was not measured.
        """
        wraps: Counter[str] = Counter()
        continued = position
        edges = [*self._breaks(stamps, position), len(stamps)]
        first = 0  # of the rows that have the turns of `state`
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
        """Number of jumps that were removed between a sample and the next, by joint."""
        if before is None or after.turns is before.turns or after.turns is self._at_start:
            return Counter()
        pairs = zip(self._names, before.turns, after.turns, strict=True)
        return Counter({name: abs(new - old) for name, old, new in pairs if new != old})

    def _goes_on(self, before_ns: int, stamp_ns: int) -> bool:
        return restart_between(before_ns, stamp_ns, self._max_gap) is None

    def _breaks(self, stamps: NDArray[np.int64], position: FloatArray) -> list[int]:
        """The first row, and each row with a jump, a gap or a stamp that goes back before it."""
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
        """Turns of each joint from a sample with a jump on."""
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
    """An array to write into: most recordings have no jumps, and need no copy."""
    if continued is position:
        return position.copy()
    return continued
