"""Processing of a bag into a new bag."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from hybrid_dynamics_core import load
from hybrid_dynamics_core.errors import HybridDynamicsError
from hybrid_dynamics_core.formats.urdf.writer import to_urdf
from hybrid_dynamics_core.ground.progress import Progress

from ..messages.cdr import MessageTemplate
from ..messages.interfaces import JOINT_MOTION, JOINT_STATE
from ..messages.joint_samples import RejectionCode
from ..parameters import PARTIAL_AGE
from ..stream.pipeline import Pipeline
from ..stream.results import MotionResult
from .batch_outputs import BagOutput, outputs_of
from .batch_pipeline import BatchPipeline, BatchResult
from .decode import Decoder
from .errors import BagCallError, BagError
from .input_topic import input_topic
from .job import CAUSAL, Job, Outcome
from .provenance import process_notes, robot_notes
from .recorded_poses import recorded_poses
from .recorded_pressures import RecordedPressures
from .samples import Samples, slices
from .settings import make_pipeline
from .smooth import estimates_of
from .storage.bag_reader import BagReader
from .storage.bag_writer import BagWriter, new_bag
from .storage.mcap_chunk import RecordBlock
from .storage.qos import reliable_profile
from .storage.storage import Losses, Messages, Topic

KINDS: Final = (JOINT_STATE, JOINT_MOTION)  # message types that the node accepts
DESCRIPTION: Final = "/robot_description"
_BATCH: Final = 2048  # samples per evaluation, and per chunk
_OUTPUT_DEPTH: Final = 200  # history depth of output topics
_STRING: Final = "std_msgs/msg/String"
_MAX_LOSSES_IN_ERROR: Final = 3
_NO_STAMP: Final = 2**63 - 1  # [ns] beyond every stamp


class Stopwatch:
    """Measures the time of each kind of work."""

    def __init__(self, shares: Counter[str]) -> None:
        """Start it.

        Args:
            shares: time by kind of work [s]; updated in place.
        """
        self._shares = shares
        self._last = time.perf_counter()

    def lap(self, what: str) -> None:
        """Add the time since the last lap to a kind of work."""
        now = time.perf_counter()
        self._shares[what] += now - self._last  # type: ignore[assignment]
        self._last = now


def process(job: Job, shown: bool | None = None) -> Outcome:
    """Run a job; the new bag is complete on return.

    Args:
        job: the job.
        shown: whether to show progress; None: on terminals.

    Raises:
        BagError: the bag cannot be read, its topic is ambiguous, or it has no usable sample.
        HybridDynamicsError: the robot cannot be loaded.
    """
    source_path = job.source.resolve()
    if job.target.resolve() in (source_path, *source_path.parents):
        raise BagCallError(
            f"{job.target}: the new bag would replace the one it is made of; name another"
        )
    outcome = Outcome(job)
    watch = Stopwatch(outcome.shares)
    robot = load(job.robot)
    pipeline = make_pipeline(robot, job.settings)
    outputs = outputs_of(robot, job.settings)
    notes = robot_notes(job.robot, robot)
    notes |= process_notes(job.source, job.smooth)
    with BagReader(job.source) as source:
        topic = source.topics[input_topic(source, job.topic, KINDS)]
        _require_smoothable(job, topic)
        topics = _output_topics(outputs)
        copied = _copied_topics(source, topics) if job.keep else []
        watch.lap("start")
        with new_bag(job.target, [*topics, *copied], notes) as bag:
            measured = pipeline.evaluator.measured
            decoder = Decoder(
                measured,
                topic.kind,
                resting=pipeline.resting,
                max_age=job.settings[PARTIAL_AGE],
                extras=pipeline.extras,
            )
            transfer = _Transfer(pipeline, decoder, outputs, bag, outcome, watch)
            transfer.pressures = RecordedPressures(pipeline.pressures, source, transfer.losses)
            transfer.take_poses(source)
            transfer.run(source, topic, [entry.name for entry in copied], shown)
            outcome.losses = [*transfer.losses.describe(), *source.losses.describe()]
            _require_results(outcome, topic, pipeline)
            watch.lap("writing")
        watch.lap("writing")  # includes waiting for the last chunks
        outcome.beside = bag.thread_time
    outcome.summary = pipeline.counts.summary()
    return outcome


def _require_smoothable(job: Job, topic: Topic) -> None:
    """Raise BagCallError for smoothing of a topic that has accelerations."""
    if topic.kind == JOINT_MOTION and job.smooth != CAUSAL:
        raise BagCallError(
            f"{job.source}: {topic.name} has accelerations, which are taken as they are: nothing"
            f" can be smoothed; leave out --smooth {job.smooth}"
        )


def _output_topics(outputs: Sequence[BagOutput]) -> list[Topic]:
    """The node's output topics."""
    profile = reliable_profile(_OUTPUT_DEPTH)
    description_profile = reliable_profile(1, transient_local=True)
    topics = [Topic(output.name, output.topic.kind, (profile,)) for output in outputs]
    return [*topics, Topic(DESCRIPTION, _STRING, (description_profile,))]


def _copied_topics(source: BagReader, topics: Sequence[Topic]) -> list[Topic]:
    """The topics of a bag, without those that are replaced."""
    replaced = {topic.name for topic in topics}
    return [topic for topic in source.topics.values() if topic.name not in replaced]


def _require_results(outcome: Outcome, topic: Topic, pipeline: Pipeline) -> None:
    """Raise BagError if no sample was usable."""
    if pipeline.counts.accepted:
        return
    job = outcome.job
    reasons = [f"; {code}: {text}" for code, text in outcome.rejections.items()]
    reasons += [f"; lost: {loss}" for loss in outcome.losses[:_MAX_LOSSES_IN_ERROR]]
    if RejectionCode.MISSING_JOINT.value in outcome.rejections:
        reasons.append(f"; is {job.robot} the robot of this bag?")
    raise BagError(
        f"{job.source}: {topic.name}: none of {outcome.samples} samples can be used, nothing is"
        f" written{''.join(reasons)}"
    )


class _Transfer:
    """The data flow of one job.

    Attributes:
        losses: texts on messages that could not be decoded or evaluated.
        pressures: pressures of the bag; None until they are read.
    """

    def __init__(
        self,
        pipeline: Pipeline,
        decoder: Decoder,
        outputs: Sequence[BagOutput],
        bag: BagWriter,
        outcome: Outcome,
        watch: Stopwatch,
    ) -> None:
        self.losses = Losses()
        self.pressures: RecordedPressures | None = None
        self._batches = BatchPipeline(pipeline)
        self._evaluator = pipeline.evaluator
        self._decoder = decoder
        self._outputs = outputs
        self._bag = bag
        self._outcome = outcome
        self._job = outcome.job
        self._watch = watch
        self._bulk_count = 0  # samples decoded in bulk
        self._first_ns = _NO_STAMP
        self._last_ns = -_NO_STAMP
        self._has_description = False
        self._waiting: list[Samples] = []  # for smoothing as a whole

    def take_poses(self, source: BagReader) -> None:
        """Set motions of ball and free joints from the poses of a bag."""
        for recorded in recorded_poses(self._batches.pipeline.poses, source, self.losses):
            self._batches.movers.append(recorded.go_to)

    def run(
        self, source: BagReader, topic: Topic, copied: Sequence[str], shown: bool | None
    ) -> None:
        """Process all messages.

        Args:
            source: the bag to read.
            topic: topic of the samples.
            copied: names of topics to copy.
            shown: whether to show progress; None: on terminals.
        """
        wanted: frozenset[str] | None = frozenset([topic.name])
        total = topic.message_count or 0
        if copied:
            wanted = None
            total = source.message_count
        with Progress(self._job.source.name, total or 1, shown) as progress:
            done = 0
            for name, messages in source.read(wanted):
                self._watch.lap("reading")
                if name in copied:
                    self._copy(name, messages)
                if name == topic.name:
                    self._process(messages)
                done += len(messages)
                progress.update(done)
            self._watch.lap("reading")
            if self._waiting:
                self._smooth(Samples.joined(self._waiting))
        tool = self._batches.pipeline.tool
        if tool.lost:
            self.losses.add(f"{tool.lost} samples give no force at the tool: {tool.problem}")
        if self._batches.pipeline.chambers.problem:
            self.losses.add(self._batches.pipeline.chambers.problem)
        outcome = self._outcome
        outcome.bulk = self._bulk_count / max(outcome.samples, 1)
        outcome.rejections = self._batches.first_rejections
        outcome.duration = max(self._last_ns - self._first_ns, 0) * 1e-9

    def _copy(self, name: str, messages: Messages) -> None:
        """Copy messages."""
        self._bag.write(list(RecordBlock.copies(self._bag.channels[name], messages)))
        self._watch.lap("writing")

    def _process(self, messages: Messages) -> None:
        """Decode messages, and evaluate them unless smoothing needs the whole topic."""
        for rows in slices(len(messages), _BATCH):
            samples = self._decode(messages.part(np.arange(rows.start, rows.stop)))
            if self._job.smooth == CAUSAL:
                self._write(self._batches.process(samples))
            else:
                self._waiting.append(samples)

    def _decode(self, messages: Messages) -> Samples:
        samples = self._decoder.decode(messages)
        for row, text in samples.broken.items():
            number = self._outcome.samples + row
            self.losses.add(f"message {number}, logged at {samples.log_ns[row]} ns: {text}")
        self._bulk_count += samples.bulk_count
        self._outcome.samples += len(samples)
        stamps = samples.stamp_ns[samples.stamp_ns >= 0]
        if len(stamps):
            self._first_ns = min(self._first_ns, int(stamps.min()))
            self._last_ns = max(self._last_ns, int(stamps.max()))
        self._watch.lap("decoding")
        return samples

    def _smooth(self, samples: Samples) -> None:
        """Evaluate all samples with smoothed rates."""
        estimates = estimates_of(samples, self._job.smooth, self._evaluator)
        joints = self._evaluator.measured
        usable_ns = samples.stamp_ns[samples.usable]
        start_ns = 0
        if len(usable_ns):
            start_ns = int(usable_ns[0])
        self._outcome.outliers = [
            outlier.describe(joints, start_ns) for outlier in estimates.outliers
        ]
        self._watch.lap("model")
        for rows in slices(len(samples), _BATCH):
            try:
                self._write(self._batches.process(samples.part(rows), estimates.part(rows)))
            except HybridDynamicsError as error:
                self.losses.add(f"samples {rows.start} to {rows.stop}: {error}")

    def _write(self, result: BatchResult | None) -> None:
        """Write the messages of a result, mostly in the thread of the bag."""
        self._watch.lap("model")
        if result is None:
            return
        if self.pressures is not None:
            self.pressures.add_to(result)
            start = 0
            for run in result.runs:
                end = start + len(run.position)
                self._compare(run, result.log_ns[start:end], self.pressures)
                self._batches.pipeline.observe(run)
                start = end
        blocks: list[RecordBlock] = []
        for output in self._outputs:
            blocks += output.blocks(self._bag.channels[output.name], result)
        if not self._has_description:
            self._has_description = True
            blocks.append(self._description(result))
        self._watch.lap("encoding")
        self._bag.write(blocks)
        self._watch.lap("writing")

    def _compare(
        self, run: MotionResult, log_ns: NDArray[np.int64], pressures: RecordedPressures
    ) -> None:
        """Compare measured forces with required ones, for rows that count."""
        pipeline = self._batches.pipeline
        if run.measured_forces is None or run.efforts is None:
            return
        for row, log in enumerate(log_ns.tolist()):
            if pipeline.chambers.is_due(int(run.stamp_ns[row])):
                pipeline.compare(run.rows(np.array([row])), pressures.newest_at(log))

    def _description(self, result: BatchResult) -> RecordBlock:
        """The robot's URDF, logged with the first result."""
        template = MessageTemplate().string(to_urdf(self._evaluator.robot.description))
        channel = self._bag.channels[DESCRIPTION]
        return RecordBlock.filled(channel, result.log_ns[:1], template, {})
