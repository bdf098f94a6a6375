"""A bag through the pipeline into another bag."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import numpy as np

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_core.formats.urdf.writer import to_urdf
from hybrid_dynamics_core.ground.progress import Progress
from hybrid_dynamics_core.ground.suggestions import suggestion

from ..messages.cdr import MessageTemplate
from ..messages.interfaces import JOINT_MOTION, JOINT_STATE
from ..messages.joint_samples import RejectionCode
from ..parameters import BANDWIDTH, MAX_GAP, MEASURED, NodeSettings
from ..stream.conditions import Conditions, calibration_of, loads_of
from ..stream.pipeline import Counts, Pipeline
from .batch_outputs import NODE, BagOutput, outputs_of
from .batch_pipeline import BatchPipeline, BatchResult
from .decode import Decoder, Samples
from .errors import BagCallError, BagError
from .provenance import robot_notes
from .settings import require_known_sensors
from .smooth import estimates_of, joined, split
from .storage.bag_reader import BagReader
from .storage.bag_writer import BagWriter, new_bag
from .storage.mcap_chunk import RecordBlock
from .storage.qos import reliable_profile
from .storage.storage import Losses, Messages, Topic

INPUT: Final = f"{NODE}/active_joint_states"
KINDS: Final = (JOINT_STATE, JOINT_MOTION)  # that the node takes
DESCRIPTION: Final = "/robot_description"
SMOOTHINGS: Final = ("causal", "savgol", "spline")
_AT_ONCE: Final = 2048  # samples that go through the model together, and into one chunk
_OUTPUT_DEPTH: Final = 200  # messages that publishers of results keep
_STRING: Final = "std_msgs/msg/String"


@dataclass(frozen=True)
class Job:
    """What is to be done with one bag.

    Attributes:
        source, target: the bag in and the bag out.
        robot: name of a shipped robot or path of a description file.
        topic: where the joint states or motions are; None: the node's own topic of joint states, or
        the only one of
            their type, or where there are no joint states the only one of joint motions.
        smooth: one of `SMOOTHINGS`.
        keep: whether the original topics go into the new bag too.
        settings: parameters of the node.
    """

    source: Path
    target: Path
    robot: str
    topic: str | None = None
    smooth: str = "causal"
    keep: bool = False
    settings: NodeSettings = field(default_factory=NodeSettings)


@dataclass(eq=False)
class Outcome:
    """What came of a job.

    Attributes:
        job: the job.
        summary: one line about the samples.
        losses: what could not be read, a sentence each; after a thousand, how many more of each
        kind.
        rejections: the first text of each kind of rejection.
        outliers: samples that `smooth` made no accelerations of, as they do not fit the motion around
        them, a text each.
        bulk: share of the samples that were decoded in bulk.
        shares: [s] spent on reading, decoding, the model, what the messages hold (encoding), and
        waiting until they are
            written.
        beside: [s] that the thread took which fills, packs and writes chunks meanwhile.
        duration: [s] of the samples' stamps; samples: how many there were.
    """

    job: Job
    summary: str = ""
    losses: list[str] = field(default_factory=list)
    rejections: dict[str, str] = field(default_factory=dict)
    outliers: list[str] = field(default_factory=list)
    bulk: float = 0.0
    shares: Counter[str] = field(default_factory=Counter)
    beside: float = 0.0
    duration: float = 0.0
    samples: int = 0


class Stopwatch:
    """Adds up where the time goes."""

    def __init__(self, shares: Counter[str]) -> None:
        self._shares, self._last = shares, time.perf_counter()

    def lap(self, what: str) -> None:
        """All since the last lap was spent on this."""
        now = time.perf_counter()
        self._shares[what] += now - self._last  # type: ignore[assignment]
        self._last = now


def process(job: Job, shown: bool | None = None) -> Outcome:
    """Do a job; the new bag is there when this returns, and what was lost is in the outcome.

    Raises:
        BagError: the bag cannot be read at all, its topic is not clear, or none of its samples can
        be used.
        HybridDynamicsError: the robot cannot be loaded.
    """
    if job.target.resolve() in (job.source.resolve(), *job.source.resolve().parents):
        raise BagCallError(
            f"{job.target}: the new bag would replace the one it is made of; name another"
        )
    outcome = Outcome(job)
    watch = Stopwatch(outcome.shares)
    robot = load(job.robot)
    pipeline = make_pipeline(robot, job.settings)
    evaluator = pipeline.evaluator
    outputs = outputs_of(robot, job.settings)
    with BagReader(job.source) as source:
        topic = input_topic(source, job.topic, KINDS)
        kind = source.topics[topic].kind
        if kind == JOINT_MOTION and job.smooth != "causal":
            told = "accelerations, which are taken as they are"
            raise BagCallError(
                f"{source.path}: {topic} has {told}: nothing can be smoothed; leave out --smooth"
                f" {job.smooth}"
            )
        profile = reliable_profile(_OUTPUT_DEPTH)
        topics = [Topic(output.name, output.topic.kind, (profile,)) for output in outputs]
        topics.append(Topic(DESCRIPTION, _STRING, (reliable_profile(1, latched=True),)))
        kept = _kept(source, topics) if job.keep else []
        notes = {**robot_notes(job.robot, robot), "source": job.source.name, "smooth": job.smooth}
        watch.lap("start")
        with new_bag(job.target, [*topics, *kept], notes) as bag:
            worker = _Worker(
                job,
                BatchPipeline(pipeline),
                Decoder(evaluator.measured, kind),
                outputs,
                bag,
                outcome,
                watch,
            )
            worker.run(source, topic, {entry.name for entry in kept}, shown)
            _require_some(
                outcome,
                topic,
                pipeline.counts,
                [*worker.losses.describe(), *source.losses.describe()],
            )
            watch.lap("writing")
        watch.lap("writing")
        outcome.beside = bag.thread_time
        outcome.losses += [*worker.losses.describe(), *source.losses.describe()]
    outcome.summary = pipeline.counts.summary()
    return outcome


def _require_some(outcome: Outcome, topic: str, counts: Counts, losses: Sequence[str]) -> None:
    """Raise BagError where no sample could be used: a bag without one computed message would look like a result."""
    if counts.accepted:
        return
    job = outcome.job
    told = [f"{code}: {text}" for code, text in outcome.rejections.items()] + [
        f"lost: {loss}" for loss in losses[:3]
    ]
    if RejectionCode.MISSING_JOINT.value in outcome.rejections:
        told.append(f"is {job.robot} the robot of this bag?")
    why = "; ".join(["", *told])
    raise BagError(
        f"{job.source}: {topic}: none of {outcome.samples} samples can be used, nothing is"
        f" written{why}"
    )


def make_pipeline(robot: Robot, settings: NodeSettings) -> Pipeline:
    """The node's pipeline under the node's parameters."""
    pipeline = Pipeline(robot, settings[BANDWIDTH], settings[MAX_GAP], settings[MEASURED])
    conditions = Conditions().with_settings(settings, None, robot.end_effector)
    evaluator = pipeline.evaluator
    evaluator.loads = loads_of(robot, conditions)
    require_known_sensors(settings, evaluator.measured)
    evaluator.calibrate(calibration_of(settings, evaluator.measured))
    return pipeline


def input_topic(
    source: BagReader, wanted: str | None, kinds: Sequence[str] = (JOINT_STATE,)
) -> str:
    """The topic with the samples.

    Args:
        source: the bag.
        wanted: its name; None: the node's own topic of joint states, or the only topic of the first
        kind that is there.
        kinds: message types that are taken.

    Raises:
        BagError: there is none.
        BagCallError: there is none of the wanted name, or it is not clear which.
    """
    there = {
        kind: [topic.name for topic in source.topics.values() if topic.kind == kind]
        for kind in kinds
    }
    every = [name for names in there.values() for name in names]
    told = ", ".join(every)
    if not every:
        others = ", ".join(source.topics) or "none that can be read"
        raise BagError(
            f"{source.path}: holds no topic of type {' or '.join(kinds)}; its topics: {others}"
        )
    if wanted is not None:
        if wanted in every:
            return wanted
        raise BagCallError(
            f"{source.path}: no topic {wanted} of type"
            f" {' or '.join(kinds)}{suggestion(wanted, every)}; topics of this type: {told}"
        )
    if INPUT in every:
        return INPUT
    first = next((names for names in there.values() if names), [])
    if len(first) != 1:
        raise BagCallError(
            f"{source.path}: which topic holds the joint states? Name it with --topic; there are:"
            f" {told}"
        )
    return first[0]


class _Worker:
    """Carries messages through one job."""

    def __init__(  # noqa: PLR0913, PLR0917 - what the job made, each once
        self,
        job: Job,
        bulk: BatchPipeline,
        decoder: Decoder,
        outputs: list[BagOutput],
        bag: BagWriter,
        outcome: Outcome,
        watch: Stopwatch,
    ) -> None:
        self._job, self._bulk, self._decoder, self._outputs = job, bulk, decoder, outputs
        self._bag, self._outcome, self._watch = bag, outcome, watch
        self.losses = Losses()
        self._in_bulk = 0
        self._first, self._last = 2**63 - 1, -(2**63)
        self._described = False

    def run(self, source: BagReader, topic: str, kept: set[str], shown: bool | None) -> None:
        """All messages."""
        total = source.message_count if kept else source.topics[topic].message_count or 0
        wanted = None if kept else frozenset([topic])
        waiting: list[Samples] = []
        with Progress(f"{self._job.source.name}", total or 1, shown) as progress:
            done = 0
            for name, messages in source.read(wanted):
                self._watch.lap("reading")
                if name in kept:
                    self._bag.write(list(RecordBlock.copies(self._bag.channels[name], messages)))
                    self._watch.lap("writing")
                for part in _pieces(messages) if name == topic else ():
                    samples = self._decode(part)
                    if self._job.smooth == "causal":
                        self._emit(self._bulk.process(samples))
                    else:
                        waiting.append(samples)
                done += len(messages)
                progress.update(done)
            self._watch.lap("reading")
            if waiting:
                self._smoothed(joined(waiting))
        outcome = self._outcome
        outcome.bulk = self._in_bulk / max(outcome.samples, 1)
        outcome.rejections = self._bulk.first_rejections
        outcome.duration = max(self._last - self._first, 0) * 1e-9

    def _decode(self, messages: Messages) -> Samples:
        samples, done = self._decoder.decode(messages), self._outcome.samples
        self._in_bulk += samples.bulk
        self._outcome.samples += len(samples)
        for row, text in samples.broken.items():
            self.losses.add(f"message {done + row}, logged at {samples.log_ns[row]} ns: {text}")
        good = samples.stamp_ns[samples.stamp_ns >= 0]
        if len(good):
            self._first, self._last = (
                min(self._first, int(good.min())),
                max(self._last, int(good.max())),
            )
        self._watch.lap("decoding")
        return samples

    def _smoothed(self, samples: Samples) -> None:
        evaluator = self._bulk.pipeline.evaluator
        estimates = estimates_of(samples, self._job.smooth, evaluator)
        joints, first = (
            evaluator.measured,
            int(samples.stamp_ns[samples.usable][:1].sum()),
        )
        self._outcome.outliers = [outlier.describe(joints, first) for outlier in estimates.outliers]
        self._watch.lap("model")
        for rows in split(len(samples), _AT_ONCE):
            part, own = samples.part(rows), estimates.part(rows)
            try:
                self._emit(self._bulk.process(part, own))
            except HybridDynamicsError as error:
                self.losses.add(f"samples {rows.start} to {rows.stop}: {error}")

    def _emit(self, motion: BatchResult | None) -> None:
        self._watch.lap("model")
        if motion is None:
            return
        blocks = [
            block
            for output in self._outputs
            for block in output.blocks(self._bag.channels[output.name], motion)
        ]
        if not self._described:
            self._described = True
            text = MessageTemplate().string(
                to_urdf(self._bulk.pipeline.evaluator.robot.description)
            )
            blocks.append(
                RecordBlock.filled(self._bag.channels[DESCRIPTION], motion.log_ns[:1], text, {})
            )
        self._watch.lap("encoding")
        self._bag.write(blocks)
        self._watch.lap("writing")


def _pieces(messages: Messages) -> Iterator[Messages]:
    for rows in split(len(messages), _AT_ONCE):
        yield messages.part(np.arange(rows.start, rows.stop))


def _kept(source: BagReader, own: list[Topic]) -> list[Topic]:
    taken = {topic.name for topic in own}
    return [topic for topic in source.topics.values() if topic.name not in taken]
