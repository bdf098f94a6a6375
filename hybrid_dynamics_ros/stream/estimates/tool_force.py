"""The force at the tool over a stream: a momentum observer on forces from measured pressures.

The observer takes every result, since it remembers. The force itself is computed where a message
needs it. This module does not depend on ROS.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import ClosedState, Loads, Robot
from hybrid_dynamics_core.control import Residuals
from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_core.estimation import ToolForce, ToolForceModel, ToolForceObserver
from hybrid_dynamics_core.ground.wording import one_line

from ...messages.joint_samples import FloatArray

Drives = tuple[str, ...]
Stamps = NDArray[np.int64]
Mask = NDArray[np.bool_]
Rows = NDArray[np.intp]
STRONGEST: Final = 1e9  # [N m, N] beyond any drive


@dataclass(frozen=True, eq=False)
class Residue:
    """What an observer gives at one sample, or at N rows: a leading N then.

    Attributes:
        models: the model of each set of measured drives.
        drives: joints of the efforts.
        residuals: of the observer; always with N, which is 1 for one sample.
        efforts: (N, d) measured forces [N m, N]; NaN for drives without.
    """

    models: Mapping[Drives, ToolForceModel]
    drives: Drives
    residuals: Residuals
    efforts: FloatArray

    def rows(self, which: Rows) -> Residue:
        """Some of the rows."""
        return Residue(self.models, self.drives, _part(self.residuals, which), self.efforts[which])

    def groups(self) -> list[Rows]:
        """Rows with a force, by the drives that are measured."""
        ready = np.flatnonzero(self.residuals.is_ready)
        if not len(ready):
            return []
        kinds, numbers = np.unique(np.isfinite(self.efforts[ready]), axis=0, return_inverse=True)
        return [ready[numbers.reshape(-1) == k] for k in range(len(kinds))]

    def force(self, state: ClosedState) -> ToolForce | None:
        """The force at rows of the same drives, with closed states of N; None if it has none."""
        if not self.residuals.is_ready.all():
            return None
        is_measured = np.isfinite(self.efforts[0])
        model = self.models[_named(self.drives, is_measured)]
        try:
            return model.forces(self.residuals, state, self.efforts[:, is_measured])
        except np.linalg.LinAlgError:
            return None  # the drives are at a toggle point


class ToolForceInput:
    """Momentum observers of a robot, one for each set of measured drives, one after the other.

    Attributes:
        lost: number of samples that no observer could take.
        problem: why it could not take the newest of these; empty before the first.
    """

    def __init__(self, robot: Robot) -> None:
        """Start without samples."""
        self._robot = robot
        self._drives = tuple(robot.drives)
        self._loads: Loads | None = None
        self._models: dict[Drives, ToolForceModel] = {}
        self._observer: ToolForceObserver | None = None
        self._newest_ns = -1
        self.lost = 0
        self.problem = ""

    def reset(self) -> None:
        """Discard the samples so far."""
        self._observer = None

    def take(
        self, stamp_ns: Stamps, state: ClosedState, efforts: FloatArray, loads: Loads
    ) -> Residue:
        """Take N samples.

        Args:
            stamp_ns: their stamps (N,) [ns].
            state: closed states with rates, a batch of N.
            efforts: (N, d) measured forces of the drives [N m, N]; NaN for drives without.
            loads: loads that the model assumes.
        """
        if loads is not self._loads:
            self._loads, self._models, self._observer = loads, {}, None
        efforts = np.where(np.abs(efforts) < STRONGEST, efforts, np.nan)
        n = len(self._robot.active)
        count = len(stamp_ns)
        values, noise = np.zeros((count, n)), np.zeros((count, n, n))
        is_ready = np.zeros(count, dtype=bool)
        for rows in self._pieces(stamp_ns, efforts):
            part = self._run(stamp_ns[rows], state.rows(rows), efforts[rows])
            if part is not None:
                values[rows], noise[rows], is_ready[rows] = part
        residuals = Residuals(values, noise, is_ready)
        return Residue(self._models, self._drives, residuals, efforts)

    def _pieces(self, stamp_ns: Stamps, efforts: FloatArray) -> Iterator[slice]:
        """Consecutive rows of the same drives with stamps that rise."""
        is_measured = np.isfinite(efforts)
        changes = (is_measured[1:] != is_measured[:-1]).any(axis=1)
        back = np.diff(stamp_ns) <= 0
        inner = np.flatnonzero(changes | back) + 1
        edges = [0, *inner.tolist(), len(stamp_ns)]
        for start, end in pairwise(edges):
            yield slice(start, end)

    def _run(self, stamp_ns: Stamps, state: ClosedState, efforts: FloatArray) -> Residuals | None:
        """Residuals of rows of the same drives with stamps that rise; None if there are none."""
        is_measured = np.isfinite(efforts[0])
        observer = self._observer_of(_named(self._drives, is_measured))
        if observer is None:
            return None
        if stamp_ns[0] <= self._newest_ns:
            observer.observer.reset()
        self._newest_ns = int(stamp_ns[-1])
        try:
            return observer.residuals(stamp_ns * 1e-9, state, efforts[:, is_measured])
        except (HybridDynamicsError, np.linalg.LinAlgError) as error:
            self._observer = None
            self.lost += len(stamp_ns)
            self.problem = one_line(error)
            return None

    def _observer_of(self, drives: Drives) -> ToolForceObserver | None:
        """The observer of some drives: the present one, or a new one; None without drives."""
        if not drives:
            self._observer = None
            return None
        if self._observer is None or self._observer.model.drives != drives:
            if drives not in self._models:
                self._models[drives] = ToolForceModel(self._robot, drives, loads=self._loads)
            self._observer = ToolForceObserver(self._models[drives])
        return self._observer


def _named(drives: Drives, is_measured: Mask) -> Drives:
    """Names of the drives in a mask (d,)."""
    pairs = zip(drives, is_measured.tolist(), strict=True)
    return tuple(name for name, measured in pairs if measured)


def _part(residuals: Residuals, which: Rows) -> Residuals:
    """Some rows of residuals."""
    return Residuals(residuals.values[which], residuals.noise[which], residuals.is_ready[which])
