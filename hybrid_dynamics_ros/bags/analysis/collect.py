"""Evaluation of a recording by the model, with a part of the samples kept."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import ClosedState, load
from hybrid_dynamics_core.ground.progress import Progress

from ...messages.joint_samples import FloatArray
from ...parameters import MAX_GAP, PARTIAL_AGE, NodeSettings
from ...stream.pipeline import Pipeline
from ..batch_outputs import NODE
from ..batch_pipeline import BatchPipeline, BatchResult
from ..decode import Decoder
from ..errors import BagError
from ..input_topic import INPUT, input_topic
from ..job import CAUSAL, SMOOTHINGS
from ..provenance import robot_of, smoothing_of
from ..recorded_poses import RecordedPoses, recorded_poses
from ..sample_outliers import SampleOutlier
from ..samples import Samples, slices
from ..settings import make_pipeline
from ..smooth import estimates_of
from ..storage.bag_reader import BagReader
from ..storage.storage import Losses
from .error_statistics import ErrorStatistics
from .pressure_efforts import PressureEfforts, exchanged_chambers
from .recording import COMPUTED, EvaluatedRecording
from .stamp_intervals import StampIntervals

Span = tuple[float, float]  # (from, to) [s]
ALL_TIMES: Final[Span] = (0.0, math.inf)
_BATCH: Final = 4096  # samples evaluated at once
_MAX_LISTED: Final = 1000  # gaps and refused samples that are listed


def collect(  # noqa: PLR0913 - the command's options
    path: Path,
    robot: str | None = None,
    topic: str | None = None,
    smooth: str | None = CAUSAL,
    settings: NodeSettings | None = None,
    most: int = 20_000,
    *,
    span: Span = ALL_TIMES,
) -> EvaluatedRecording:
    """Evaluate a recording by the model, and keep about `most` evenly spaced samples.

    Args:
        path: the bag.
        robot: name or file of the robot; None: the robot named in the bag.
        topic: topic of joint states; None: see `input_topic`.
        smooth: one of `job.SMOOTHINGS`; None: that of a processed bag, otherwise the spline.
        settings: parameters of the node.
        most: approximate number of samples to keep.
        span: first and last time since the first stamp of the bag [s].

    Raises:
        BagError: the bag has no usable samples, or its robot is unknown.
    """
    settings = settings or NodeSettings()
    machine = robot_of(path) if robot is None else load(robot)
    pipeline = make_pipeline(machine, settings)
    with BagReader(path) as source:
        name = _topic_of(source, topic)
        count = source.topics[name].message_count or 1
        collector = _Collector(
            pipeline,
            topic=name,
            smooth=smooth or _smoothing(path),
            span=span,
            max_gap=settings[MAX_GAP],
            every=max(1, math.ceil(count / most)),
            pressures=PressureEfforts(machine, source, settings[PARTIAL_AGE]),
        )
        evaluator = pipeline.evaluator
        decoder = Decoder(
            evaluator.measured,
            resting=pipeline.resting,
            max_age=settings[PARTIAL_AGE],
        )
        lost = Losses()
        collector.move_by(recorded_poses(pipeline.poses, source, lost))
        for samples in _read(source, name, decoder):
            collector.add(samples)
        collector.smooth_waiting()
        losses = [*lost.describe(), *source.losses.describe()]
    if not collector.has_results:
        raise BagError(f"{path}: {name}: {collector.why_no_results()}")
    return collector.recording(losses)


def _smoothing(path: Path) -> str:
    """The smoothing of a processed bag; for a recording the spline, which has no lag."""
    smoothing = smoothing_of(path)
    return smoothing if smoothing in SMOOTHINGS else "spline"


def _topic_of(source: BagReader, topic: str | None) -> str:
    """The topic of joint states; in a bag without the node's input, the node's output."""
    output = source.topics.get(COMPUTED)
    if topic or output is None or INPUT in source.topics:
        return input_topic(source, topic or None)
    candidates = [other.name for other in source.topics.values() if other.kind == output.kind]
    recorded = [name for name in candidates if NODE not in name]
    if len(recorded) == 1:
        return input_topic(source, recorded[0])
    return input_topic(source, COMPUTED)


def _read(source: BagReader, name: str, decoder: Decoder) -> Iterator[Samples]:
    """The samples of a topic, in batches."""
    with Progress(source.path.name, source.topics[name].message_count or 1) as progress:
        done = 0
        for _, messages in source.read(frozenset([name])):
            for rows in slices(len(messages), _BATCH):
                yield decoder.decode(messages.part(np.arange(rows.start, rows.stop)))
            done += len(messages)
            progress.update(done)


@dataclass(eq=False)
class _Results:
    """Copies of some rows of a `BatchResult`, so that the rest can be freed."""

    stamp_ns: NDArray[np.int64]
    state: ClosedState
    acceleration: FloatArray
    efforts: FloatArray
    recorded: FloatArray


class _Collector:
    """Evaluates samples, and keeps some with their results."""

    def __init__(  # noqa: PLR0913 - as of `collect`
        self,
        pipeline: Pipeline,
        *,
        topic: str,
        smooth: str,
        span: Span,
        max_gap: float,
        every: int,
        pressures: PressureEfforts,
    ) -> None:
        """Start without samples.

        Args:
            pipeline: the node's pipeline.
            topic: topic of the samples.
            smooth: one of `job.SMOOTHINGS`.
            span: first and last time since the first stamp of the bag [s].
            max_gap: largest gap between stamps [s].
            every: every n-th sample is kept.
            pressures: pressures of the bag.
        """
        self._pipeline = pipeline
        self._evaluator = pipeline.evaluator
        self._robot = pipeline.evaluator.robot
        self._batches = BatchPipeline(pipeline)
        self._topic = topic
        self._smooth = smooth
        self._span = span
        self._max_gap = max_gap
        self._every = every
        self._pressures = pressures
        self._is_pressed = np.zeros(len(pipeline.evaluator.robot.active), dtype=bool)
        self._waiting: list[Samples] = []  # for smoothing as a whole
        self._results: list[_Results] = []
        self._errors = ErrorStatistics.empty(len(self._robot.active))
        self._outliers: list[SampleOutlier] = []
        self._gaps: list[tuple[int, int]] = []  # [ns]
        self._refused: list[tuple[int, str]] = []  # ([ns], reason)
        self._intervals: list[NDArray[np.int64]] = []  # [ns]
        self._start_ns: int | None = None  # first stamp of the bag
        self._first_ns: int | None = None  # first stamp of the span
        self._last_ns: int | None = None
        self._with_velocity = 0  # number of samples
        self._without_velocity = 0

    @property
    def has_results(self) -> bool:
        """Whether any sample was accepted."""
        return bool(self._results)

    def move_by(self, poses: Sequence[RecordedPoses]) -> None:
        """Set ball and free joints to the poses of a bag at each sample."""
        for recorded in poses:
            self._batches.movers.append(recorded.go_to)

    def add(self, samples: Samples) -> None:
        """Evaluate samples, or keep them until the end if smoothing needs all of them."""
        samples = self._within_span(samples)
        if not len(samples):
            return
        self._register_stamps(samples)
        if self._topic == COMPUTED or self._evaluator.measured != self._robot.active:
            samples.effort[:] = np.nan
        for joint in self._pipeline.poses.posed:
            # what pushes a floating base is not known, and angles have other charts
            samples.effort[:, list(joint.places)] = np.nan
        measured = samples.measured[samples.usable]
        self._with_velocity += int(measured.sum())
        self._without_velocity += int((~measured).sum())
        if self._smooth == CAUSAL:
            self._keep(samples, self._batches.process(samples))
        else:
            self._waiting.append(samples)

    def smooth_waiting(self) -> None:
        """Evaluate the kept samples with smoothed rates."""
        if not self._waiting:
            return
        samples = Samples.joined(self._waiting)
        estimates = estimates_of(samples, self._smooth, self._evaluator)
        self._outliers = estimates.outliers
        for rows in slices(len(samples), _BATCH):
            part = samples.part(rows)
            self._keep(part, self._batches.process(part, estimates.part(rows)))

    def why_no_results(self) -> str:
        """Text on why no sample was accepted."""
        where = ""
        if self._span != ALL_TIMES:
            where = f" from {self._span[0]:g} s {_end_text(self._span)} of the bag"
        rejections = self._batches.first_rejections.items()
        reasons = "".join(f"; {code}: {text}" for code, text in rejections)
        summary = self._pipeline.counts.summary()
        return f"no sample{where} can be used ({summary}){reasons}"

    def recording(self, losses: list[str]) -> EvaluatedRecording:
        """The evaluated recording; requires results.

        Args:
            losses: losses of the reader.
        """
        results = self._results
        stamps = np.concatenate([part.stamp_ns for part in results])
        start_ns = int(stamps[0]) if self._start_ns is None else self._start_ns
        first_ns = start_ns if self._first_ns is None else self._first_ns
        intervals = np.zeros(0)
        if self._intervals:
            intervals = np.concatenate(self._intervals).astype(np.float64) * 1e-9
        state = ClosedState.joined([part.state for part in results])
        efforts = np.concatenate([part.efforts for part in results])
        pressures = self._pressures.pressures(stamps)
        problem = exchanged_chambers(self._robot, state, efforts, pressures)
        mostly_measured = self._with_velocity >= self._without_velocity

        def since_start(stamp_ns: int) -> float:
            return (stamp_ns - start_ns) * 1e-9

        return EvaluatedRecording(
            robot=self._robot,
            loads=self._evaluator.loads,
            topic=self._topic,
            start_ns=start_ns,
            time=(stamps - start_ns) * 1e-9,
            state=state,
            acceleration=np.concatenate([part.acceleration for part in results]),
            efforts=efforts,
            recorded=np.concatenate([part.recorded for part in results]),
            every=self._every,
            counts=self._pipeline.counts,
            gaps=[(since_start(begin), since_start(end)) for begin, end in self._gaps],
            refused=[(since_start(stamp_ns), why) for stamp_ns, why in self._refused],
            outliers=self._outliers,
            measured=self._evaluator.measured,
            max_gap=self._max_gap,
            stamps=StampIntervals(since_start(first_ns), intervals),
            errors=self._errors,
            losses=[*losses, problem] if problem else losses,
            smooth=self._smooth,
            pressure_topic=self._pressures.topic,
            pressures=pressures,
            pressed=tuple(np.array(self._robot.active)[self._is_pressed].tolist()),
            causal_lag=self._evaluator.estimator.lag(measured=mostly_measured),
        )

    def _within_span(self, samples: Samples) -> Samples:
        """The samples of the span; all others are ignored."""
        usable = samples.usable
        if self._start_ns is None and usable.any():
            self._start_ns = int(samples.stamp_ns[usable][0])
        if self._span == ALL_TIMES or self._start_ns is None:
            return samples
        begin, end = self._span
        stamps = np.where(usable, samples.stamp_ns, samples.log_ns)
        time = (stamps - self._start_ns) * 1e-9
        return samples.only(np.flatnonzero((time >= begin) & (time <= end)))

    def _register_stamps(self, samples: Samples) -> None:
        """Register intervals, gaps and invalid samples."""
        for row, rejection in samples.rejected.items():
            self._refuse(int(samples.log_ns[row]), rejection.code.value)
        stamps = samples.stamp_ns[samples.usable]
        if not len(stamps):
            return
        if self._first_ns is None:
            self._first_ns = int(stamps[0])
        if self._last_ns is not None:
            stamps = np.concatenate([[self._last_ns], stamps])
        intervals = np.diff(stamps)
        is_gap = (intervals < 0) | (intervals * 1e-9 > self._max_gap)
        free = _MAX_LISTED - len(self._gaps)
        for k in np.flatnonzero(is_gap)[:free]:
            self._gaps.append((int(stamps[k]), int(stamps[k + 1])))
        self._intervals.append(intervals)
        self._last_ns = int(stamps[-1])

    def _keep(self, samples: Samples, result: BatchResult | None) -> None:
        """Keep some samples with their results, and add the errors of all to the statistics."""
        if result is None:
            return
        recorded = self._recorded(samples, result)
        self._errors.add(recorded, result.efforts, result.stamp_ns)
        rows = np.arange(0, len(result), self._every)
        self._results.append(
            _Results(
                stamp_ns=result.stamp_ns[rows],
                state=result.state.rows(rows),
                acceleration=result.acceleration[rows],
                efforts=result.efforts[rows],
                recorded=recorded[rows],
            )
        )
        missing = np.setdiff1d(np.arange(len(samples)), result.rows)
        free = _MAX_LISTED - len(self._refused)
        for row in missing[:free]:
            if row not in samples.rejected and row not in samples.broken:
                self._refuse(int(samples.stamp_ns[row]), "refused by the model")

    def _recorded(self, samples: Samples, result: BatchResult) -> FloatArray:
        """Efforts of the joint states, and in place of them those that pressures measure (m, n)."""
        efforts = samples.effort[result.rows]
        measured = self._pressures.efforts(result.stamp_ns, result.state)
        has_pressures = np.isfinite(measured)
        self._is_pressed |= has_pressures.any(axis=0)
        return np.where(has_pressures, measured, efforts)

    def _refuse(self, stamp_ns: int, why: str) -> None:
        if len(self._refused) < _MAX_LISTED:
            self._refused.append((stamp_ns, why))


def _end_text(span: Span) -> str:
    """`to 5 s`, or `to the end`."""
    return f"to {span[1]:g} s" if math.isfinite(span[1]) else "to the end"
