"""Idle joints that a stream or a recording does not name: they keep their reference."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hybrid_dynamics_core import DescriptionError, Robot
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_ros.bags.batch_pipeline import BatchPipeline
from hybrid_dynamics_ros.bags.decode import Decoder
from hybrid_dynamics_ros.bags.errors import BagError
from hybrid_dynamics_ros.bags.trajectory_file import read_trajectory
from hybrid_dynamics_ros.messages.joint_samples import (
    JointSample,
    Rejection,
    RejectionCode,
    resting_joints,
)
from hybrid_dynamics_ros.stream.joint_topics import JointStates, RequiredEfforts
from hybrid_dynamics_ros.stream.pipeline import Pipeline
from hybrid_dynamics_ros.stream.results import MotionResult
from tests.bags.messages import START, joint_state, messages_of
from tests.export.test_round_trip import CART
from tests.sampling import examples
from tests.spinning import Spinning, spinning

MS = 10**6


def answers(robot: Robot, samples: list[JointSample]) -> list[MotionResult]:
    """What a stream gives for all samples."""
    pipeline = Pipeline(robot, 10.0, 0.5)
    results = [pipeline.process(sample) for sample in samples]
    for result in results:
        assert isinstance(result, MotionResult), result
    return results


def motor_samples(robot: Robot, named: bool, rows: int = 8) -> list[JointSample]:
    """Samples of a slow motion of the motors, with and without the idle joints."""
    motors = list(robot.description.motors)
    names = motors + list(robot.idle) * named
    samples = []
    for k in range(rows):
        position = robot.reference.copy()
        position[: len(motors)] += 0.001 * k
        velocity = np.zeros(len(robot.active))
        velocity[: len(motors)] = 0.1
        stamp = START + 10 * MS * k
        size = len(names)
        samples.append(JointSample(stamp, names, position[:size], velocity[:size]))
    return samples


@examples(24)
@given(spinning(), st.lists(st.booleans(), min_size=8, max_size=8))
def test_what_is_not_named_keeps_its_reference(linkage: Spinning, named: list[bool]) -> None:
    """Some messages may name them, others not."""
    try:
        robot = linkage.robot()
    except DescriptionError:
        assume(False)
    assume(robot.close(robot.reference).singularity > 0.1)
    whole, short = motor_samples(robot, named=True), motor_samples(robot, named=False)
    mixed = [whole[k] if is_named else short[k] for k, is_named in enumerate(named)]
    expected = answers(robot, whole)
    for samples in (short, mixed):
        for result, other in zip(answers(robot, samples), expected, strict=True):
            assert np.array_equal(result.position, other.position)
            if other.efforts is not None:
                assert np.array_equal(result.efforts, other.efforts)
    assert expected[-1].efforts is not None


@pytest.mark.parametrize("bulk", [True, False])
def test_recordings_are_read_alike(bulk: bool) -> None:
    robot = Robot(parse_description(CART))
    rows = motor_samples(robot, named=False)
    pairs = [(row.stamp_ns, joint_state(*row[:4])) for row in rows]
    decoder = Decoder(robot.active, bulk=bulk, resting=resting_joints(robot))
    samples = decoder.decode(messages_of(pairs))
    assert samples.bulk_count == (len(rows) if bulk else 0)
    assert (samples.position[:, 1] == robot.reference[1]).all()
    result = BatchPipeline(Pipeline(robot, 10.0, 0.5)).process(samples)
    assert result is not None
    expected = answers(robot, rows)
    for k, one in enumerate(expected):
        assert np.array_equal(result.state.s[k], one.position)


def test_efforts_are_those_of_drives() -> None:
    robot = Robot(parse_description(CART))
    result = answers(robot, motor_samples(robot, named=False))[-1]
    _, (_, _, efforts) = RequiredEfforts(robot).message(result)
    assert efforts.shape == (1,)
    _, (*_, along_all) = JointStates(robot).message(result)
    assert along_all[robot.coordinates.index("th")] == 0.0
    assert along_all[robot.coordinates.index("x")] == efforts[0]


def test_a_motor_has_to_be_named() -> None:
    robot = Robot(parse_description(CART))
    sample = JointSample(START, ["th"], np.zeros(1), np.zeros(1))
    result = Pipeline(robot, 10.0, 0.5).process(sample)
    assert isinstance(result, Rejection)
    assert result.code is RejectionCode.MISSING_JOINT
    assert "x not named" in result.text


def test_a_trajectory_need_not_name_them(tmp_path: Path) -> None:
    robot = Robot(parse_description(CART))
    path = tmp_path / "motion.csv"
    path.write_text("time,x,x.velocity\n0,0,0.1\n1,0.1,0.1\n", encoding="utf-8")
    trajectory = read_trajectory(path, robot)
    assert trajectory.names == ("x", "th")
    assert np.array_equal(trajectory.position, [[0.0, 0.0], [0.1, 0.0]])
    assert np.array_equal(trajectory.velocity, [[0.1, 0.0], [0.1, 0.0]])
    path.write_text("time,th\n0,0\n1,0.1\n", encoding="utf-8")
    with pytest.raises(BagError, match="no column x"):
        read_trajectory(path, robot)
