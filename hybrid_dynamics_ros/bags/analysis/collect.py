"""A recording and what the model says about it, as arrays: what reports and identification look at."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import ClosedState, Loads, Robot, load
from hybrid_dynamics_core.ground.progress import Progress

from ...messages.joint_samples import FloatArray
from ...parameters import MAX_GAP, NodeSettings
from ...stream.pipeline import Counts, Pipeline
from ...stream.stroke_margins import StrokeMargins
from ..batch_outputs import NODE
from ..batch_pipeline import BatchPipeline, BatchResult
from ..decode import Decoder, Samples
from ..errors import BagError
from ..process import SMOOTHINGS, input_topic, make_pipeline
from ..provenance import known_robot, smoothing_of
from ..sample_outliers import SampleOutlier
from ..smooth import estimates_of, joined, split
from ..storage.bag_reader import BagReader
from .stamp_intervals import Stamps

Span = tuple[float, float]  # from, to [s]
WHOLE: Final[Span] = (0.0, math.inf)
_AT_ONCE = 4096
_COMPUTED: Final = f"{NODE}/joint_states"  # the node's output: its efforts are the model's own
_LISTED = 1000  # gaps and bad samples that are kept for the page


@dataclass(eq=False)
class Track:
    """Some samples of a recording with what the model says, in order.

    Attributes:
        robot, loads: what it was computed with.
        topic: where the samples are from.
        start_ns: stamp of the first [ns].
        time: (N,) [s] since then.
        state: closed, a batch of N.
        acceleration, efforts: (N, n) of the active joints; NaN before they are known.
        recorded: (N, n) recorded efforts, NaN where there are none.
        every: each how manieth sample is here.
        gaps: (from, to) [s] where stamps are further apart than the largest gap.
        bad: (time [s], why) of samples that were refused.
        outliers: samples that do not fit the motion around them, and have no acceleration; none of
        the causal filter.
        measured: joints of the bag's samples, the active ones unless the node's parameter says
        otherwise.
        max_gap: the largest gap [s], a parameter of the node.
        intervals: (k,) [s] between all stamps, one after the other from `first` on.
        first: [s] the first stamp that was looked at.
        errors: recorded less computed efforts over all samples: count, sum, sum of squares,
        largest, (n,) each.
        losses: what could not be read.
        smooth: how accelerations were found, one of `process.SMOOTHINGS`.
        causal_lag: how late they are where they come from the node's filter [s].
    """

    robot: Robot
    loads: Loads
    topic: str
    start_ns: int
    time: FloatArray
    state: ClosedState
    acceleration: FloatArray
    efforts: FloatArray
    recorded: FloatArray
    every: int
    counts: Counts
    gaps: list[tuple[float, float]]
    bad: list[tuple[float, str]]
    outliers: list[SampleOutlier]
    measured: tuple[str, ...]
    max_gap: float
    intervals: FloatArray
    first: float
    errors: Errors
    losses: list[str]
    smooth: str
    causal_lag: float

    @cached_property
    def stamps(self) -> Stamps:
        """How regular the stamps are."""
        return Stamps(self.first, self.intervals)

    @property
    def smoother(self) -> str:
        """What accelerations without lag are from, in words."""
        return {"spline": "a spline", "savgol": "a Savitzky-Golay filter"}[self.smooth]

    @property
    def computed(self) -> bool:
        """Whether the samples are what a processed bag has in place of a recording: their efforts are the model's."""
        return self.topic == _COMPUTED

    @property
    def power(self) -> FloatArray:
        """What the actuators give (N,) [W]."""
        total: FloatArray = (self.efforts * self.state.du).sum(axis=1)
        return total

    @property
    def energy(self) -> tuple[FloatArray, FloatArray]:
        """Of motion, and of gravity and springs, (N,) [J]."""
        energy = self.robot.energy(self.state, self.loads)
        return np.asarray(energy.kinetic), np.asarray(energy.potential) + np.asarray(energy.springs)

    @property
    def margins(self) -> tuple[tuple[str, ...], FloatArray]:
        """Joints with a stroke that ends, and the least that is left to an end, (N, k) [rad or m]."""
        strokes = StrokeMargins(self.robot)
        return strokes.joints, np.minimum(*strokes.margins(self.state.s))


@dataclass(eq=False)
class Errors:
    """Sums over all samples that have both efforts: recorded less computed, (n,) each; the largest and its stamp."""

    count: NDArray[np.int64]
    total: FloatArray
    squares: FloatArray
    largest: FloatArray
    largest_ns: NDArray[np.int64]
    recorded_total: FloatArray
    recorded_squares: FloatArray

    @staticmethod
    def none(n: int) -> Errors:
        """Of no samples."""
        zeros = np.zeros(n)
        return Errors(
            np.zeros(n, dtype=np.int64),
            zeros,
            zeros,
            zeros,
            np.zeros(n, dtype=np.int64),
            zeros,
            zeros,
        )

    def add(self, recorded: FloatArray, computed: FloatArray, stamp_ns: NDArray[np.int64]) -> None:
        """More samples (N, n), with their stamps [ns]."""
        if not len(recorded):
            return
        good = np.isfinite(recorded) & np.isfinite(computed)
        error = np.where(good, recorded - computed, 0.0)
        told = np.where(good, recorded, 0.0)
        self.count = self.count + good.sum(axis=0)
        self.total = self.total + error.sum(axis=0)
        self.squares = self.squares + (error**2).sum(axis=0)
        size = np.abs(error)
        worst = size.argmax(axis=0)
        self.largest_ns = np.where(
            size.max(axis=0) > self.largest, stamp_ns[worst], self.largest_ns
        )
        self.largest = np.maximum(self.largest, size.max(axis=0))
        self.recorded_total = self.recorded_total + told.sum(axis=0)
        self.recorded_squares = self.recorded_squares + (told**2).sum(axis=0)

    @property
    def mean(self) -> FloatArray:
        """(n,) [N m or N]."""
        return self.total / np.maximum(self.count, 1)

    @property
    def rms(self) -> FloatArray:
        """(n,) [N m or N]."""
        return np.sqrt(self.squares / np.maximum(self.count, 1))

    @property
    def explained(self) -> FloatArray:
        """Share of the variance of the recorded efforts that the model explains, (n,); 1 at best."""
        count = np.maximum(self.count, 1)
        spread = self.recorded_squares / count - (self.recorded_total / count) ** 2
        left = self.squares / count - self.mean**2
        return np.where(spread > 0.0, 1.0 - left / np.where(spread > 0.0, spread, 1.0), np.nan)


@dataclass(eq=False)
class _Results:
    """Copies of some rows of a `BatchResult`, which itself can then be forgotten."""

    stamp_ns: NDArray[np.int64]
    state: ClosedState
    acceleration: FloatArray
    efforts: FloatArray


@dataclass(eq=False)
class _Kept:
    motions: list[_Results] = field(default_factory=list)
    recorded: list[FloatArray] = field(default_factory=list)
    gaps: list[tuple[int, int]] = field(default_factory=list)
    bad: list[tuple[int, str]] = field(default_factory=list)
    intervals: list[NDArray[np.int64]] = field(default_factory=list)
    outliers: list[SampleOutlier] = field(default_factory=list)
    origin: int | None = None  # the first stamp of the bag [ns]
    first: int | None = None  # and of what is looked at
    last: int | None = None
    with_velocity: int = 0  # samples
    without: int = 0


def collect(  # noqa: PLR0913 - the command's options
    path: Path,
    robot: str | None = None,
    topic: str | None = None,
    smooth: str | None = "causal",
    settings: NodeSettings | None = None,
    most: int = 20_000,
    *,
    span: Span = WHOLE,
) -> Track:
    """Run a recording through the pipeline and keep about `most` samples, evenly.

    `span`: from and to [s], after the first stamp of the bag, to which times refer too; nothing
    outside is looked at. `smooth`: one of `process.SMOOTHINGS`; None: that of a processed bag, or
    the spline, which has no lag.

    Raises:
        BagError: there is nothing in it that the model can take, or it is not told which robot it
        is of.
    """
    settings = settings or NodeSettings()
    smooth = smooth or _smoothing(path)
    machine = known_robot(path) if robot is None else load(robot)
    pipeline = make_pipeline(machine, settings)
    evaluator = pipeline.evaluator
    bulk, decoder = BatchPipeline(pipeline), Decoder(evaluator.measured)
    kept, errors = _Kept(), Errors.none(len(machine.active))
    with BagReader(path) as source:
        name = topic or _own_states(source) or input_topic(source, None)
        name = input_topic(source, name)
        every = max(1, math.ceil((source.topics[name].message_count or 1) / most))
        parts: list[Samples] = []
        for samples in _read(source, name, decoder, kept, span):
            _watch(kept, samples, settings[MAX_GAP])
            if name == _COMPUTED or evaluator.measured != machine.active:
                samples.effort[:] = np.nan
            measured = samples.measured[samples.usable]
            kept.with_velocity += int(measured.sum())
            kept.without += int((~measured).sum())
            if smooth == "causal":
                _keep(kept, errors, samples, bulk.process(samples), every)
            else:
                parts.append(samples)
        if parts:
            whole = joined(parts)
            estimates = estimates_of(whole, smooth, evaluator)
            kept.outliers = estimates.outliers
            for rows in split(len(whole), _AT_ONCE):
                samples = whole.part(rows)
                _keep(kept, errors, samples, bulk.process(samples, estimates.part(rows)), every)
        losses = source.losses.describe()
    if not kept.motions:
        told = "".join(f"; {code}: {text}" for code, text in bulk.first_rejections.items())
        where = "" if span == WHOLE else f" from {span[0]:g} s {end_text(span)} of the bag"
        raise BagError(
            f"{path}: {name}: no sample{where} can be used ({pipeline.counts.summary()}){told}"
        )
    lag = evaluator.estimator.lag(measured=kept.with_velocity >= kept.without)  # of most samples
    return _track(
        machine, pipeline, name, kept, errors, every, losses, smooth, lag, settings[MAX_GAP]
    )


def _smoothing(path: Path) -> str:
    """That which a bag was processed with; of a recording the one that has no lag."""
    told = smoothing_of(path)
    return told if told in SMOOTHINGS else "spline"


def _own_states(source: BagReader) -> str | None:
    """The node's output, in a bag without its input."""
    own, given = _COMPUTED, f"{NODE}/active_joint_states"
    if given in source.topics or own not in source.topics:
        return None
    others = [
        t.name
        for t in source.topics.values()
        if t.kind == source.topics[own].kind and NODE not in t.name
    ]
    return own if len(others) != 1 else others[0]


def _read(
    source: BagReader, name: str, decoder: Decoder, kept: _Kept, span: Span
) -> Iterator[Samples]:
    """The samples of a topic within the span, some at a time."""
    with Progress(source.path.name, source.topics[name].message_count or 1) as progress:
        done = 0
        for _, messages in source.read(frozenset([name])):
            for rows in split(len(messages), _AT_ONCE):
                samples = decoder.decode(messages.part(np.arange(rows.start, rows.stop)))
                samples = _within(kept, samples, span)
                if len(samples):
                    yield samples
            done += len(messages)
            progress.update(done)


def end_text(span: Span) -> str:
    """`to 5 s`, or `to the end`."""
    return f"to {span[1]:g} s" if math.isfinite(span[1]) else "to the end"


def _within(kept: _Kept, samples: Samples, span: Span) -> Samples:
    """The samples of a span; the others are as if they were not in the bag."""
    if kept.origin is None and samples.usable.any():
        kept.origin = int(samples.stamp_ns[samples.usable][0])
    if span == WHOLE or kept.origin is None:
        return samples
    stamps = np.where(samples.usable, samples.stamp_ns, samples.log_ns)
    time = (stamps - kept.origin) * 1e-9
    return samples.only(np.flatnonzero((time >= span[0]) & (time <= span[1])))


def _watch(kept: _Kept, samples: Samples, gap: float) -> None:
    stamps = samples.stamp_ns[samples.usable]
    for row, why in samples.rejected.items():
        if len(kept.bad) < _LISTED:
            kept.bad.append((int(samples.log_ns[row]), why.code.value))
    if not len(stamps):
        return
    whole = stamps if kept.last is None else np.concatenate([[kept.last], stamps])
    steps = np.diff(whole)
    for k in np.flatnonzero((steps < 0) | (steps * 1e-9 > gap)):
        if len(kept.gaps) < _LISTED:
            kept.gaps.append((int(whole[k]), int(whole[k + 1])))
    kept.first = int(stamps[0]) if kept.first is None else kept.first
    kept.intervals.append(steps)
    kept.last = int(stamps[-1])


def _keep(
    kept: _Kept, errors: Errors, samples: Samples, motion: BatchResult | None, every: int
) -> None:
    if motion is None:
        return
    recorded = samples.effort[motion.rows]
    if recorded.shape == motion.efforts.shape:
        errors.add(recorded, motion.efforts, motion.stamp_ns)
    rows = np.arange(0, len(motion), every)
    kept.recorded.append(recorded[rows])
    kept.motions.append(_thinned(motion, rows))
    lost = np.setdiff1d(np.arange(len(samples)), motion.rows)
    for row in lost[: _LISTED - len(kept.bad)]:
        if row not in samples.rejected and row not in samples.broken:
            kept.bad.append((int(samples.stamp_ns[row]), "refused by the model"))


def _thinned(motion: BatchResult, rows: NDArray[np.intp]) -> _Results:
    return _Results(
        stamp_ns=motion.stamp_ns[rows],
        state=motion.state.rows(rows),
        acceleration=motion.acceleration[rows],
        efforts=motion.efforts[rows],
    )


def _track(  # noqa: PLR0913, PLR0917 - a line for each attribute
    robot: Robot,
    pipeline: Pipeline,
    topic: str,
    kept: _Kept,
    errors: Errors,
    every: int,
    losses: list[str],
    smooth: str,
    causal_lag: float,
    max_gap: float,
) -> Track:
    stamps = np.concatenate([motion.stamp_ns for motion in kept.motions])
    start = int(stamps[0]) if kept.origin is None else kept.origin
    return Track(
        robot=robot,
        loads=pipeline.evaluator.loads,
        topic=topic,
        start_ns=start,
        time=(stamps - start) * 1e-9,
        state=ClosedState.joined([motion.state for motion in kept.motions]),
        acceleration=np.concatenate([motion.acceleration for motion in kept.motions]),
        efforts=np.concatenate([motion.efforts for motion in kept.motions]),
        recorded=np.concatenate(kept.recorded),
        every=every,
        counts=pipeline.counts,
        gaps=[((a - start) * 1e-9, (b - start) * 1e-9) for a, b in kept.gaps],
        bad=[((at - start) * 1e-9, why) for at, why in kept.bad],
        outliers=kept.outliers,
        measured=pipeline.evaluator.measured,
        max_gap=max_gap,
        first=0.0 if kept.first is None else (kept.first - start) * 1e-9,
        intervals=np.concatenate([np.zeros(0, dtype=np.int64), *kept.intervals]).astype(np.float64)
        * 1e-9,
        errors=errors,
        losses=losses,
        smooth=smooth,
        causal_lag=causal_lag,
    )
