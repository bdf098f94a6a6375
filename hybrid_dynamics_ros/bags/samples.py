"""Joint samples of a recording as columns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..messages.extra_joints import ExtraJoints
from ..messages.joint_samples import Calibration, FloatArray, Rejection

T = TypeVar("T")


@dataclass(eq=False)
class Samples:
    """Samples of the measured joints: one row for each message, in order.

    Attributes:
        log_ns: log times (N,) [ns].
        stamp_ns: stamps of the headers (N,) [ns].
        position: (N, n) [rad or m].
        velocity: (N, n) [rad/s or m/s]; NaN if absent.
        effort: recorded efforts (N, n) [N m or N]; NaN if absent.
        acceleration: (N, n) accelerations of the messages [rad/s^2 or m/s^2]; None if they must be
            estimated.
        extras: further joints of each row, which the robot does not have; None if not requested.
        rejected: reasons of rows that are no valid samples; their numbers are meaningless.
        waiting: partial rows that were joined into a later row; their numbers are meaningless.
        broken: reasons of rows that cannot be decoded.
        bulk_count: number of rows decoded in bulk.
    """

    log_ns: NDArray[np.int64]
    stamp_ns: NDArray[np.int64]
    position: FloatArray
    velocity: FloatArray
    effort: FloatArray
    acceleration: FloatArray | None = None
    extras: list[ExtraJoints | None] | None = None
    rejected: dict[int, Rejection] = field(default_factory=dict)
    waiting: dict[int, None] = field(default_factory=dict)
    broken: dict[int, str] = field(default_factory=dict)
    bulk_count: int = 0

    def __len__(self) -> int:
        return len(self.stamp_ns)

    @staticmethod
    def blank(log_ns: NDArray[np.int64], joint_count: int, *, has_acceleration: bool) -> Samples:
        """Blank rows with log times (N,) [ns]."""
        shape = (len(log_ns), joint_count)
        samples = Samples(
            log_ns=log_ns,
            stamp_ns=np.full(len(log_ns), -1, dtype=np.int64),
            position=np.full(shape, np.nan),
            velocity=np.full(shape, np.nan),
            effort=np.full(shape, np.nan),
        )
        if has_acceleration:
            samples.acceleration = np.full(shape, np.nan)
        return samples

    @staticmethod
    def joined(parts: Sequence[Samples]) -> Samples:
        """Concatenate samples, without accelerations."""
        rejected: dict[int, Rejection] = {}
        broken: dict[int, str] = {}
        waiting: dict[int, None] = {}
        start = 0
        for part in parts:
            rejected |= {start + row: why for row, why in part.rejected.items()}
            waiting |= dict.fromkeys(start + row for row in part.waiting)
            broken |= {start + row: why for row, why in part.broken.items()}
            start += len(part)
        extras: list[ExtraJoints | None] | None = None
        if parts[0].extras is not None:
            extras = [extra for part in parts for extra in part.extras or ()]
        return Samples(
            log_ns=np.concatenate([part.log_ns for part in parts]),
            stamp_ns=np.concatenate([part.stamp_ns for part in parts]),
            position=np.concatenate([part.position for part in parts]),
            velocity=np.concatenate([part.velocity for part in parts]),
            effort=np.concatenate([part.effort for part in parts]),
            extras=extras,
            rejected=rejected,
            waiting=waiting,
            broken=broken,
        )

    @property
    def measured(self) -> NDArray[np.bool_]:
        """Mask (N,) of rows with the velocity of any joint."""
        return np.asarray(np.isfinite(self.velocity).any(axis=1))

    @property
    def usable(self) -> NDArray[np.bool_]:
        """Mask (N,) of rows that are valid samples."""
        usable = np.ones(len(self), dtype=bool)
        usable[[*self.rejected, *self.waiting, *self.broken]] = False
        return usable

    def calibrated(self, calibration: Calibration | None) -> Samples:
        """The samples of the joints, from readings of their sensors."""
        if calibration is None:
            return self
        factor = calibration.factor
        acceleration = self.acceleration
        if acceleration is not None:
            acceleration = factor * acceleration
        return replace(
            self,
            position=factor * (self.position - calibration.offset),
            velocity=factor * self.velocity,
            acceleration=acceleration,
        )

    def part(self, rows: slice) -> Samples:
        """Consecutive rows, as views."""
        return self._select(rows, range(rows.start, rows.stop))

    def only(self, rows: NDArray[np.intp]) -> Samples:
        """A copy of some rows."""
        if len(rows) == len(self):
            return self
        return self._select(rows, rows.tolist())

    def _select(self, rows: slice | NDArray[np.intp], numbers: Sequence[int]) -> Samples:
        """Some rows, selected by `rows`, with their indices."""
        places: dict[int, int] = {}
        if self.rejected or self.waiting or self.broken:
            places = {row: k for k, row in enumerate(numbers)}
        acceleration = self.acceleration
        if acceleration is not None:
            acceleration = acceleration[rows]
        return Samples(
            log_ns=self.log_ns[rows],
            stamp_ns=self.stamp_ns[rows],
            position=self.position[rows],
            velocity=self.velocity[rows],
            effort=self.effort[rows],
            acceleration=acceleration,
            extras=None if self.extras is None else [self.extras[row] for row in numbers],
            rejected=_renumbered(self.rejected, places),
            waiting=_renumbered(self.waiting, places),
            broken=_renumbered(self.broken, places),
        )


def _renumbered(table: Mapping[int, T], places: Mapping[int, int]) -> dict[int, T]:
    return {places[row]: why for row, why in table.items() if row in places}


def slices(count: int, size: int) -> Iterator[slice]:
    """All of `count` rows in slices of at most `size`."""
    for start in range(0, count, size):
        yield slice(start, min(start + size, count))
