"""The pipeline for batches of samples, equal to `Pipeline.process` bit by bit.

Rows that depend on the previous one, and batches with an error, are processed sample by sample.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import ClosedState
from hybrid_dynamics_core.errors import HybridDynamicsError

from ..messages.joint_samples import (
    FloatArray,
    JointSample,
    OrderedMotion,
    RejectedError,
    Rejection,
    RejectionCode,
    rejection_of,
)
from ..stream.filter.rate_estimator import RateRows
from ..stream.pipeline import Pipeline
from ..stream.results import MotionResult
from ..stream.turns import TurnRows
from .samples import Samples

Rows = NDArray[np.intp]


@dataclass(eq=False)
class BatchResult:
    """Results of the accepted samples, in order.

    Attributes:
        rows: indices of the samples (m,).
        log_ns: log times (m,) [ns].
        runs: results of consecutive rows for which the same quantities are known.
    """

    rows: Rows
    log_ns: NDArray[np.int64]
    runs: Sequence[MotionResult]

    def __len__(self) -> int:
        return len(self.rows)

    def at(self, which: Rows) -> Iterator[tuple[MotionResult, NDArray[np.int64]]]:
        """Runs of some of the m results, and their log times [ns]; `which` is ascending."""
        start = 0
        for run in self.runs:
            end = start + len(run.position)
            first, last = np.searchsorted(which, (start, end)).tolist()
            if first < last:
                inside = which[first:last]
                yield run.rows(inside - start), self.log_ns[inside]
            start = end

    @cached_property
    def stamp_ns(self) -> NDArray[np.int64]:
        """Stamps (m,) [ns]."""
        return np.concatenate([np.asarray(run.stamp_ns) for run in self.runs])

    @cached_property
    def state(self) -> ClosedState:
        """Closed states, a batch of m."""
        if len(self.runs) == 1:
            return self.runs[0].state
        return ClosedState.joined([run.state for run in self.runs])

    @cached_property
    def acceleration(self) -> FloatArray:
        """Accelerations (m, n) of the active joints; NaN if unknown."""
        return self._active(lambda run: run.active.acceleration)

    @cached_property
    def efforts(self) -> FloatArray:
        """Efforts (m, n) of the active joints; NaN if unknown."""
        return self._active(lambda run: run.efforts)

    def _active(self, part: Callable[[MotionResult], FloatArray | None]) -> FloatArray:
        columns = []
        for run in self.runs:
            values = part(run)
            columns.append(np.full_like(run.active.position, np.nan) if values is None else values)
        return columns[0] if len(columns) == 1 else np.concatenate(columns)


class BatchPipeline:
    """A pipeline for batches of samples, one after the other."""

    def __init__(self, pipeline: Pipeline) -> None:
        """Wrap a pipeline, whose counts and filter are continued."""
        self.pipeline = pipeline
        self.first_rejections: dict[str, str] = {}  # the first text of each kind
        # Each sets motions of ball and free joints to those recorded at a log time [ns].
        self.movers: list[Callable[[int], None]] = []

    def process(self, samples: Samples, given: RateRows | None = None) -> BatchResult | None:
        """Results of the samples; None if none was accepted.

        Args:
            samples: readings of the sensors.
            given: rates of all samples from another estimator, NaN where unknown; None: the node's
                filter estimates them.
        """
        if self.pipeline.evaluator.is_plain and samples.usable.any():
            try:
                with np.errstate(all="ignore"):
                    return self._process(samples, given)
            except (RejectedError, HybridDynamicsError):
                pass  # nothing was changed yet; single samples show the error
        if given is None:
            return self._one_by_one(samples, None)
        return self._one_by_one(samples.calibrated(self.pipeline.evaluator.calibration), given)

    def _process(self, samples: Samples, given: RateRows | None) -> BatchResult | None:
        evaluator = self.pipeline.evaluator
        samples = samples.calibrated(evaluator.calibration)
        rows = np.flatnonzero(samples.usable)
        refused: list[Rejection] = []
        turned = self._continued(samples, rows, given)
        try:
            rates, runs = self._evaluate(samples, rows, turned, given)
        except HybridDynamicsError:  # samples that do not close must not reach the filter
            status = evaluator.robot.close(turned.position, check=False).status
            closes = np.asarray(status) == 0
            if closes.all():
                raise
            refused = self._refusals(samples, rows[~closes], turned.position[~closes])
            rows = rows[closes]
            turned = self._continued(samples, rows, given)
            rates, runs = self._evaluate(samples, rows, turned, given)
        self._count(samples, refused, rates, runs)
        if samples.extras is not None:
            for run, places in zip(runs, rates.runs(), strict=True):
                run.extras = [samples.extras[row] for row in rows[places].tolist()]
        if not runs:
            return None
        evaluator.taken(turned, None if _is_given(samples, given) else rates)
        return BatchResult(rows, samples.log_ns[rows], runs)

    def _continued(self, samples: Samples, rows: Rows, given: RateRows | None) -> TurnRows:
        """Positions of some rows, continued without jumps of whole turns."""
        velocity = samples.velocity[rows]
        if given is not None:
            has_rates = given.has_velocity[rows, None]
            velocity = np.where(has_rates, given.velocity[rows], np.nan)
        return self.pipeline.evaluator.continued(
            samples.stamp_ns[rows],
            samples.position[rows],
            velocity,
            is_given=_is_given(samples, given),
        )

    def _evaluate(
        self, samples: Samples, rows: Rows, turned: TurnRows, given: RateRows | None
    ) -> tuple[RateRows, list[MotionResult]]:
        """Rates of some rows with continued positions, and results of their runs."""
        evaluator = self.pipeline.evaluator
        stamps, position = samples.stamp_ns[rows], turned.position
        velocity = samples.velocity[rows]
        if given is not None:
            rates = given.part(rows)
        elif samples.acceleration is not None:
            rates = RateRows.given(velocity, samples.acceleration[rows])
        else:
            rates = evaluator.rates(stamps, position, velocity)
        results = []
        last = evaluator.last
        try:
            for run in rates.runs():
                motion = OrderedMotion(position[run], *rates.at(run))
                results.append(evaluator.evaluate(stamps[run], motion))
        except (RejectedError, HybridDynamicsError):
            evaluator.last = last
            raise
        return rates, results

    def _refusals(self, samples: Samples, rows: Rows, position: FloatArray) -> list[Rejection]:
        """The rejections of some rows that do not close.

        Args:
            samples: all samples.
            rows: the rows.
            position: continued positions of the rows (k, n) [rad or m].

        Raises:
            RejectedError: a row closes by itself.
        """
        rejections = []
        for row, u in zip(rows.tolist(), position, strict=True):
            velocity = samples.velocity[row]
            if np.isnan(velocity).any():
                velocity = None
            try:
                self.pipeline.evaluator.robot.close(u, velocity)
            except HybridDynamicsError as error:
                rejections.append(rejection_of(error))
        if len(rejections) < len(rows):
            raise RejectedError(RejectionCode.INTERNAL, "a row of the batch closes alone")
        return rejections

    def _count(
        self,
        samples: Samples,
        refused: list[Rejection],
        rates: RateRows,
        runs: Sequence[MotionResult],
    ) -> None:
        counts = self.pipeline.counts
        counts.received += len(samples) - len(samples.broken)
        counts.events.update(rates.events)
        for run in runs:
            if run.efforts is not None:
                counts.with_efforts += len(run.efforts)
        counts.waiting += len(samples.waiting)
        for rejection in (*samples.rejected.values(), *refused):
            self._remember(self.pipeline.reject(rejection))

    def _remember(self, rejection: Rejection) -> None:
        self.first_rejections.setdefault(rejection.code.value, rejection.text)

    def _one_by_one(self, samples: Samples, given: RateRows | None) -> BatchResult | None:
        rows: list[int] = []
        results: list[MotionResult] = []
        for row in range(len(samples)):
            if row in samples.broken:
                continue
            if row in samples.waiting:
                self.pipeline.wait_unread()
                continue
            if row in samples.rejected:
                self._remember(self.pipeline.reject_unread(samples.rejected[row]))
                continue
            sample = self._sample(samples, row, given)
            result = self.pipeline.process(sample, is_estimated=given is not None)
            if isinstance(result, Rejection):
                self._remember(result)
            elif result is not None:
                result.extras = None if samples.extras is None else samples.extras[row]
                rows.append(row)
                results.append(result)
        if not rows:
            return None
        accepted = np.array(rows, dtype=np.intp)
        return BatchResult(accepted, samples.log_ns[accepted], _runs_of(results))

    def _sample(self, samples: Samples, row: int, given: RateRows | None) -> JointSample:
        for move in self.movers:
            move(int(samples.log_ns[row]))
        velocity = samples.velocity[row]
        if np.isnan(velocity).all():
            velocity = None
        acceleration = None if samples.acceleration is None else samples.acceleration[row]
        if given is not None:
            velocity, acceleration = given.at(row)
        return JointSample(
            int(samples.stamp_ns[row]),
            self.pipeline.evaluator.measured,
            samples.position[row],
            velocity,
            acceleration,
        )


def _is_given(samples: Samples, given: RateRows | None) -> bool:
    """Whether rates come from another estimator than the filter."""
    return given is not None or samples.acceleration is not None


def _runs_of(results: Sequence[MotionResult]) -> list[MotionResult]:
    """Results of single samples, merged into runs of consecutive rows with the same fields."""
    runs: list[list[MotionResult]] = [[results[0]]]
    for result in results[1:]:
        if result.goes_with(runs[-1][-1]):
            runs[-1].append(result)
        else:
            runs.append([result])
    return [MotionResult.joined(run) for run in runs]
