"""Joints that are no joints of the robot: they pass through, in recordings as in the stream."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.rosbag2 import Reader

from hybrid_dynamics_ros.bags.batch_pipeline import BatchPipeline
from hybrid_dynamics_ros.bags.decode import Decoder, sample_of_state
from hybrid_dynamics_ros.bags.job import Job
from hybrid_dynamics_ros.bags.process import process
from hybrid_dynamics_ros.messages.interfaces import JOINT_STATE, typestore
from hybrid_dynamics_ros.parameters import PASS_THROUGH, NodeSettings
from hybrid_dynamics_ros.stream.joint_topics import JointStates
from hybrid_dynamics_ros.stream.pipeline import Pipeline
from hybrid_dynamics_ros.stream.results import MotionResult
from tests.bags.messages import START, bag, joint_state, messages_of
from tests.sampling import examples, swept

ACTIVE = ("q1", "q12", "q22", "q4")
AT = {"q1": 0.1, "q12": 0.1, "q22": 0.15, "q4": 0.2, "finger": 0.01, "thumb": np.nan, "q2": 9.0}
MS = 10**6
LISTS = [ACTIVE, ("finger", *ACTIVE), (*ACTIVE[::-1], "thumb", "finger"), ("thumb",), ("q2",)]
LISTS += [("finger",), ("q1", "q12", "finger"), ("q22", "q4")]


def pipeline_of(robot):
    pipeline = Pipeline(robot, 10.0, 0.5)
    pipeline.pass_through(0.2)
    return pipeline


@st.composite
def streams(draw):
    """Messages with some joints, among them those of grippers."""
    pairs, stamp = [], START
    for k in range(draw(st.integers(1, 30))):
        names = draw(st.sampled_from(LISTS))
        stamp += draw(st.sampled_from([MS, 10 * MS, 150 * MS]))
        position = [AT[name] + 0.001 * k for name in names]
        rates = draw(st.sampled_from([(), [0.01] * len(names)]))
        efforts = draw(st.sampled_from([(), [float(k)] * len(names)]))
        pairs.append((stamp, joint_state(stamp, names, position, rates, efforts)))
    return pairs, draw(st.integers(0, len(pairs)))


@examples(60)
@given(case=streams())
def test_recordings_have_the_extra_joints_of_the_stream(forging, case):
    pairs, cut = case
    pipeline, topic = pipeline_of(forging), JointStates(forging)
    expected = []
    for _, data in pairs:
        result = pipeline.process(sample_of_state(typestore().deserialize_cdr(data, JOINT_STATE)))
        if isinstance(result, MotionResult):
            expected.append(topic.fill(result))
    bulk = pipeline_of(forging)
    decoder = Decoder(ACTIVE, extras=bulk.extras)
    batches, sent = BatchPipeline(bulk), []
    for part in (pairs[:cut], pairs[cut:]):
        motion = batches.process(decoder.decode(messages_of(part))) if part else None
        for run in () if motion is None else motion.runs:
            filled = {}
            for rows in topic.groups(run):
                for row in rows.tolist():
                    filled[row] = topic.fill(single(run, row))
            sent += [filled[row] for row in sorted(filled)]
    assert sent == expected
    assert bulk.counts == pipeline.counts


def single(run, row):
    """One row as the result of one sample."""
    one = run.rows(np.array([row])) if len(run.position) > 1 else run
    extras = None if one.extras is None else one.extras[0]
    velocity = None if one.velocity is None else one.velocity[0]
    efforts = None if one.efforts is None else one.efforts[0]
    return MotionResult(
        one.robot,
        one.loads,
        int(one.stamp_ns[0]),
        one.active,
        one.position[0],
        velocity,
        efforts,
        one.residual,
        one.distances,
        one.branch,
        None,
        one.make_state,
        extras,
    )


@pytest.mark.parametrize("smooth", swept(["causal", "spline"], ("causal",)))
def test_a_gripper_is_in_the_processed_bag(tmp_path, smooth):
    pairs = []
    for k in range(40):
        stamp = START + 10 * MS * k
        arm = joint_state(stamp, ACTIVE, [0.1, 0.1, 0.15, 0.001 * k], [0.0, 0.0, 0.0, 0.1])
        pairs.append((stamp, arm))
        if k % 2 == 0:
            pairs.append((stamp, joint_state(stamp, ["finger"], [0.01 * k], [1.0], [5.0])))
    settings = NodeSettings({PASS_THROUGH.name: True})
    source = bag(tmp_path / "in", pairs)
    job = Job(source, tmp_path / "out", "forging_chu2020", smooth=smooth, settings=settings)
    outcome = process(job)
    assert "40 accepted" in outcome.summary
    assert "20 with some joints" in outcome.summary
    with Reader(job.target) as reader:
        topics = [c for c in reader.connections if c.topic.endswith("/joint_states")]
        messages = [
            typestore().deserialize_cdr(data, JOINT_STATE) for _, _, data in reader.messages(topics)
        ]
    assert len(messages) == 40
    assert "finger" not in messages[0].name  # it came after
    assert [m.name[-1] for m in messages[1:]] == ["finger"] * 39
    assert [m.position[-1] for m in messages[1:5]] == [0.0, 0.0, 0.02, 0.02]
    assert all(len(m.position) == 13 for m in messages[1:])
    assert messages[20].effort[-1] == 5.0
    assert messages[20].velocity[-1] == 1.0
