"""The pipeline over many samples at once: what `Pipeline.process` gives for each of them, bit for bit.

Whatever is out of the ordinary (a state that does not close in the middle of numbers that overflow,
joints that are given in place of the active ones) is left to the pipeline itself, sample by sample.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import ClosedState
from hybrid_dynamics_core.errors import HybridDynamicsError

from ..messages.joint_samples import FloatArray, JointSample, Rejection, rejection_of
from ..stream.filter.batch import run_filter
from ..stream.filter.filter import StampEvent
from ..stream.filter.rate_estimator import EstimatorState
from ..stream.pipeline import Pipeline
from ..stream.results import MotionResult
from .decode import Samples
from .sample_outliers import Stray

Mask = NDArray[np.bool_]
Rows = NDArray[np.intp]


@dataclass(eq=False)
class Motion:
    """Results of the samples that were accepted.

    Attributes:
        rows: which of the samples (m,).
        stamp_ns, log_ns: (m,) [ns].
        state: closed, a batch of m.
        moving: (m,) whether rates are known.
        driven: (m,) whether efforts are known.
        acceleration, efforts: (m, n) of the active joints; NaN where not known.
    """

    rows: Rows
    stamp_ns: NDArray[np.int64]
    log_ns: NDArray[np.int64]
    state: ClosedState
    moving: Mask
    driven: Mask
    acceleration: FloatArray
    efforts: FloatArray

    def __len__(self) -> int:
        return len(self.rows)


class _UnusualError(Exception):
    """The samples have to be taken one by one."""


@dataclass(eq=False)
class Estimates:
    """Rates of accepted samples: velocity (m, n), acceleration (m, n), which are known, and the filter after them.

    strays: samples that rates were not made of, as they do not fit the motion around them.
    """

    velocity: FloatArray
    moving: Mask
    acceleration: FloatArray
    driven: Mask
    events: Counter[StampEvent]
    after: EstimatorState | None
    strays: list[Stray] = field(default_factory=list)

    def part(self, rows: Rows | slice) -> Estimates:
        """Those of some rows."""
        return Estimates(
            self.velocity[rows],
            self.moving[rows],
            self.acceleration[rows],
            self.driven[rows],
            Counter(),
            None,
        )


class BulkPipeline:
    """A pipeline for batches of samples, one after the other."""

    def __init__(self, pipeline: Pipeline) -> None:
        """A pipeline whose counts and filter go on."""
        self.pipeline = pipeline
        self.first_rejections: dict[str, str] = {}  # the first text of each kind
        robot = pipeline.robot
        self._direct = pipeline.measured == robot.active and pipeline.mode is None

    def process(self, samples: Samples, given: Estimates | None = None) -> Motion | None:
        """Results of the samples; None where none was accepted.

        given: estimates that were made elsewhere, for all samples; those not known stay so. None:
        the node's filter.
        """
        if self._direct and not self._late(samples):
            try:
                with np.errstate(all="ignore"):
                    return self._process(samples, given)
            except (_UnusualError, HybridDynamicsError):
                pass  # nothing was changed yet
        if given is None:
            return self._one_by_one(samples)
        calibration = self.pipeline.calibration
        samples = samples.calibrated(calibration)
        self.pipeline.calibration = None  # estimates are of the joints, not of their sensors
        try:
            return self._one_by_one(samples, given)
        finally:
            self.pipeline.calibration = calibration

    @staticmethod
    def _late(samples: Samples) -> bool:
        return len(samples.rejected) + len(samples.broken) == len(samples)

    def _process(self, samples: Samples, given: Estimates | None) -> Motion | None:
        pipeline, robot = self.pipeline, self.pipeline.robot
        samples = samples.calibrated(pipeline.calibration)
        rows, refused = np.flatnonzero(samples.usable), list[Rejection]()
        found = self._closed(samples, rows, given)
        if found is not None and np.any(
            found[1].status
        ):  # those that cannot be closed must not reach the filter
            status = np.asarray(robot.close(samples.position[rows], check=False).status)
            refused = self._refusals(samples, rows[status != 0])
            rows = rows[status == 0]
            found = self._closed(samples, rows, given)
        if found is None:
            self._count(samples, refused, None, 0)
            return None
        motion = self._evaluate(samples, rows, *found)
        estimates = found[0]
        self._count(samples, refused, estimates, int(motion.driven.sum()))
        if given is None:
            pipeline._state = estimates.after  # noqa: SLF001 - this is the pipeline's own loop, unrolled
        return motion

    def _closed(
        self, samples: Samples, rows: Rows, given: Estimates | None
    ) -> tuple[Estimates, ClosedState, FloatArray | None] | None:
        """Rates of some rows, their states, closed or not, and efforts where they came along; None without rows."""
        if not len(rows):
            return None
        position, velocity = samples.position[rows], samples.velocity[rows]
        if given is not None:
            known = given.part(rows)
        elif samples.acceleration is not None:
            known = self._told(velocity, samples.acceleration[rows])
        else:
            known = self._estimate(
                samples.stamp_ns[rows], position, velocity, samples.measured[rows]
            )
        robot, fused = self.pipeline.robot, self.pipeline._fused  # noqa: SLF001
        if fused is not None and known.moving.all() and known.driven.all():
            tau, *parts = fused(position, known.velocity, known.acceleration, check=False)
            if np.isfinite(tau).all():
                return known, robot.closed_state(position, known.velocity, parts), tau
        rates = np.where(known.moving[:, None], known.velocity, 0.0)
        return known, robot.close(position, rates, check=False), None

    def _refusals(self, samples: Samples, rows: Rows) -> list[Rejection]:
        found = []
        for k in rows:
            try:
                self.pipeline.robot.close(
                    samples.position[k], samples.velocity[k] if samples.measured[k] else None
                )
            except HybridDynamicsError as error:
                found.append(rejection_of(error))
            else:
                raise _UnusualError
        return found

    def _told(self, velocity: FloatArray, acceleration: FloatArray) -> Estimates:
        """Rates that came with the samples: they are taken as they are, and the filter is left alone."""
        every = np.ones(len(velocity), dtype=bool)
        return Estimates(velocity, every, acceleration, every, Counter(), self.pipeline._state)  # noqa: SLF001

    def _estimate(
        self, stamps: NDArray[np.int64], position: FloatArray, velocity: FloatArray, measured: Mask
    ) -> Estimates:
        estimator, state = self.pipeline._estimator, self.pipeline._state  # noqa: SLF001
        count, n = position.shape
        out = Estimates(
            velocity.copy(),
            measured.copy(),
            np.full((count, n), np.nan),
            np.zeros(count, dtype=bool),
            Counter(),
            state,
        )
        edges = [0, *(np.flatnonzero(np.diff(measured.astype(np.int8))) + 1).tolist(), count]
        for start, end in itertools.pairwise(edges):
            own, kind = slice(start, end), bool(measured[start])
            filt = estimator._velocity_filter if kind else estimator._position_filter  # noqa: SLF001
            before = state.filter if state is not None and state.from_velocities == kind else None
            fitted, ready, events, after = run_filter(
                filt, before, stamps[own], (velocity if kind else position)[own]
            )
            if not np.isfinite(fitted).all():
                raise _UnusualError
            if not kind:
                out.velocity[own] = np.where(ready[:, None], fitted[:, 1], 0.0)
                out.moving[own] = ready
            out.acceleration[own] = np.where(ready[:, None], fitted[:, filt.degree], np.nan)
            out.driven[own] = ready
            out.events += events
            state = EstimatorState(kind, after)
        out.after = state
        return out

    def _evaluate(
        self,
        samples: Samples,
        rows: Rows,
        known: Estimates,
        state: ClosedState,
        efforts: FloatArray | None,
    ) -> Motion:
        robot, loads = self.pipeline.robot, self.pipeline.loads
        if np.any(state.status):
            raise _UnusualError
        tau = np.full_like(state.u, np.nan) if efforts is None else efforts
        which = np.flatnonzero(known.driven)
        if efforts is None and len(which):
            part = state if len(which) == len(rows) else state.rows(which)
            tau[which] = robot.inverse_dynamics(part, known.acceleration[which], loads)
        if not (
            np.isfinite(state.s).all()
            and np.isfinite(state.ds).all()
            and np.isfinite(tau[which]).all()
        ):
            raise _UnusualError
        stamps, logs = samples.stamp_ns[rows], samples.log_ns[rows]
        return Motion(
            rows, stamps, logs, state, known.moving, known.driven, known.acceleration, tau
        )

    def _count(
        self, samples: Samples, refused: list[Rejection], known: Estimates | None, efforts: int
    ) -> None:
        counts = self.pipeline.counts
        counts.received += len(samples) - len(samples.broken)
        counts.with_efforts += efforts
        for rejection in (*samples.rejected.values(), *refused):
            self._reject(rejection)
        if known is not None:
            counts.events.update(known.events)

    def _reject(self, rejection: Rejection) -> None:
        self.pipeline.reject(rejection)
        self._remember(rejection)

    def _remember(self, rejection: Rejection) -> None:
        self.first_rejections.setdefault(rejection.code.value, rejection.text)

    def _one_by_one(self, samples: Samples, given: Estimates | None = None) -> Motion | None:
        found: list[tuple[int, MotionResult]] = []
        for row in range(len(samples)):
            if row in samples.broken:
                continue
            if row in samples.rejected:
                self._remember(self.pipeline.reject_unread(samples.rejected[row]))
                continue
            result = self.pipeline.process(
                self._sample(samples, row, given), estimate=given is None
            )
            if isinstance(result, Rejection):
                self._remember(result)
            else:
                found.append((row, result))
        return _stacked(samples, found) if found else None

    def _sample(self, samples: Samples, row: int, given: Estimates | None) -> JointSample:
        if given is not None:
            velocity = given.velocity[row] if given.moving[row] else None
            acceleration = given.acceleration[row] if given.driven[row] else None
        else:
            velocity = samples.velocity[row] if samples.measured[row] else None
            acceleration = None if samples.acceleration is None else samples.acceleration[row]
        stamp = int(samples.stamp_ns[row])
        return JointSample(
            stamp, self.pipeline.measured, samples.position[row], velocity, acceleration
        )


def _stacked(samples: Samples, found: Sequence[tuple[int, MotionResult]]) -> Motion:
    rows = np.array([row for row, _ in found], dtype=np.intp)
    results = [result for _, result in found]
    state = ClosedState.joined([result.state for result in results])
    unknown = np.full(state.n, np.nan)
    return Motion(
        rows=rows,
        stamp_ns=samples.stamp_ns[rows],
        log_ns=samples.log_ns[rows],
        state=state,
        moving=np.array([r.moving for r in results]),
        driven=np.array([r.efforts is not None for r in results]),
        acceleration=np.array(
            [unknown if r.active.acceleration is None else r.active.acceleration for r in results]
        ),
        efforts=np.array([unknown if r.efforts is None else r.efforts for r in results]),
    )
