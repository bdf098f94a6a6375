"""Recorded samples of a running simulation, in blocks of the same coordinates."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import NamedTuple

import numpy as np

from ..closed_state.state import ClosedState
from ..ground.arrays import Array
from .passing.anchors import Anchors
from .passing.coordinates import Coordinates, Recorded


class _Block(NamedTuple):
    """N samples: times [s], y = (u, u', work), efforts, and closed configurations near them."""

    coordinates: Coordinates
    t: Array
    y: Array
    tau: Array
    anchors: Anchors


class Samples:
    """All samples so far."""

    def __init__(self) -> None:
        self._blocks: list[_Block] = []

    def __bool__(self) -> bool:
        return bool(self._blocks)

    @property
    def last_time(self) -> float:
        """Time of the last sample [s]."""
        return float(self._blocks[-1].t[-1])

    def add(
        self, coordinates: Coordinates, t: float, y: Array, tau: Array, anchor: ClosedState
    ) -> None:
        """Record a sample.

        Args:
            coordinates: those of y.
            t: time [s].
            y: (u, u', work).
            tau: efforts (n,) of the simulated robot.
            anchor: closed state to follow it from.
        """
        self.add_rows(coordinates, np.array([t]), y[None], tau, Anchors.of([anchor]))

    def add_rows(
        self, coordinates: Coordinates, t: Array, y: Array, tau: Array, anchors: Anchors
    ) -> None:
        """Record N samples under the same efforts."""
        if len(t):
            efforts = np.broadcast_to(tau, (len(t), len(tau)))
            self._blocks.append(_Block(coordinates, t, y, efforts, anchors))

    def times(self) -> Array:
        """Times (N,) [s]."""
        return np.concatenate([block.t for block in self._blocks])

    def efforts(self) -> Array:
        """Efforts (N, n) of the simulated robot."""
        return np.concatenate([block.tau for block in self._blocks])

    def work(self) -> Array:
        """Work (N,) [J]."""
        return np.concatenate([block.y[:, -1] for block in self._blocks])

    def recorded(self) -> Iterator[Recorded]:
        """What is recorded of them, by the coordinates in which they were integrated."""
        for coordinates, blocks in groupby(self._blocks, key=lambda block: block.coordinates):
            yield _joined(coordinates, list(blocks))


def _joined(coordinates: Coordinates, blocks: Sequence[_Block]) -> Recorded:
    y = np.concatenate([block.y for block in blocks])
    tau = np.concatenate([block.tau for block in blocks])
    anchors = Anchors.joined([block.anchors for block in blocks])
    return coordinates.recorded(y, anchors, tau)
