"""A floating base by odometry: base wrench and efforts at every orientation, as Pinocchio has."""

from __future__ import annotations

import importlib.util
import math
import os
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hybrid_dynamics_msgs.msg import JointMotion
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_core.export import to_yaml
from hybrid_dynamics_ros.messages.conversions import sample_of_motion
from hybrid_dynamics_ros.messages.joint_samples import JointSample, RejectedError, Rejection
from hybrid_dynamics_ros.messages.link_transforms import LinkTransforms
from hybrid_dynamics_ros.messages.odometry import OdometrySample
from hybrid_dynamics_ros.parameters import NodeSettings, ParameterError
from hybrid_dynamics_ros.stream.conditions import odometry_of, poses_of
from hybrid_dynamics_ros.stream.pipeline import Pipeline
from hybrid_dynamics_ros.stream.results import MotionResult
from tests.laws.test_multi_dof import (
    BALL,
    FREE,
    KNEE,
    ORIGIN,
    floating_robot,
    in_pinocchio,
    two_links,
)
from tests.sampling import examples

MS = 10**6
START = 10**12  # [ns]
# as far as a filter of doubles has the rate of a linear twist; of numbers of about 10
FILTER = 1e-7
QUARTER = math.sqrt(0.5)


def pipeline_of(robot: Robot, **settings: object) -> Pipeline:
    values = NodeSettings({"odometry.topic": "/odom", **settings})
    return Pipeline(robot, 10.0, 0.5, poses=poses_of(robot, values))


def odometry(stamp_ns: int, rng: np.random.Generator, twist: np.ndarray) -> OdometrySample:
    """Any orientation, every fourth one singular for three turns."""
    orientation = rng.normal(size=4)
    orientation /= np.linalg.norm(orientation)
    if rng.integers(4) == 0:
        orientation = np.array([0.0, QUARTER, 0.0, QUARTER])
    return OdometrySample(stamp_ns, "", rng.normal(size=3), orientation, twist)


def tumbled(pipeline: Pipeline, seed: int) -> tuple[list[OdometrySample], list[MotionResult]]:
    """Odometry and the results of joint states with its stamps; the twist changes evenly."""
    rng = np.random.default_rng(seed)
    twist, change = rng.normal(size=6), rng.normal(size=6)
    samples, results = [], []
    for k in range(8):
        stamp = START + 10 * MS * k
        samples.append(odometry(stamp, rng, twist + 0.01 * k * change))
        pipeline.odometry.take(samples[-1])
        joint = np.array([0.3 + 0.01 * k])
        sample = JointSample(stamp, [KNEE], joint, np.array([1.0]), np.array([-0.5]))
        result = pipeline.process(sample)
        assert isinstance(result, MotionResult)
        results.append(result)
    return samples, results


@given(seed=st.integers(0, 10_000))
@examples(40)
def test_wrench_and_efforts_are_pinocchios_through_any_tumbling(seed: int) -> None:
    robot = floating_robot()
    samples, results = tumbled(pipeline_of(robot), seed)
    change = (samples[1].twist - samples[0].twist) / 0.01
    model = in_pinocchio(robot, pin.JointModelFreeFlyer(), pin.SE3.Identity())
    known = [result for result in results if result.efforts is not None]
    assert len(known) >= 4
    for sample, result in list(zip(samples, results, strict=True))[-4:]:
        there = np.r_[sample.position, sample.orientation, result.state.u[0]]
        rates, accelerations = np.r_[sample.twist, 1.0], np.r_[change, -0.5]
        expected = pin.rnea(model, model.createData(), there, rates, accelerations)
        assert result.base_wrench == pytest.approx(expected[:6], abs=FILTER)
        assert result.efforts[0] == pytest.approx(expected[6], abs=FILTER)


@given(seed=st.integers(0, 10_000))
@examples(20)
def test_angles_on_topics_are_those_of_the_urdf_at_every_orientation(seed: int) -> None:
    """Links placed by the angles that go out stand where odometry has the base."""
    robot = two_links({"type": "free", "origin": ORIGIN}, active=[KNEE], idle=[BALL])
    pipeline = pipeline_of(robot)
    samples, results = tumbled(pipeline, seed)
    transforms = LinkTransforms(robot)
    for sample, result in zip(samples, results, strict=True):
        rotation, position = Rotation.identity(), np.zeros(3)
        slots = transforms.values(result.position)
        for name in robot.description.multi_dof[BALL].joints:
            k = robot.coordinates.index(name)
            position = position + rotation.apply(slots[2 * k])
            rotation = rotation * Rotation.from_quat(slots[2 * k + 1])
        assert position == pytest.approx(sample.position, abs=1e-9)
        expected = Rotation.from_quat(sample.orientation).as_matrix()
        assert rotation.as_matrix() == pytest.approx(expected, abs=1e-7)


@pytest.mark.parametrize("late", [-199, -20, 0, 20, 199])
def test_odometry_near_the_stamp_of_a_joint_state_is_taken(late: int) -> None:
    pipeline = pipeline_of(floating_robot())
    pipeline.odometry.take(odometry(START, np.random.default_rng(0), np.zeros(6)))
    assert pipeline.odometry.at(START + late * MS) is pipeline.odometry.newest
    with pytest.raises(RejectedError, match=r"within 0\.2 s"):
        pipeline.odometry.at(START + late * MS + int(math.copysign(201, late)) * MS)


def test_a_joint_state_needs_odometry_near_its_stamp() -> None:
    robot = floating_robot()
    pipeline = pipeline_of(robot)
    sample = JointSample(START, [KNEE], np.array([0.3]))
    early = pipeline.process(sample)
    assert isinstance(early, Rejection)
    assert early.text.startswith(f"{FREE}: no pose on /odom within 0.2 s: none has come yet")
    still = OdometrySample(START, "", np.zeros(3), np.array([0, 0, 0, 1.0]), np.zeros(6))
    pipeline.odometry.take(still)
    assert isinstance(pipeline.process(sample), MotionResult)
    late = pipeline.process(sample._replace(stamp_ns=START + 300 * MS))
    assert isinstance(late, Rejection)
    assert "the newest is 0.3 s older" in late.text


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"stamp_ns": -1}, "stamp is -1 ns"),
        ({"link": "wheel"}, r"odometry of 'wheel' \(child_frame_id\), expected that of 'l1'"),
        ({"position": np.array([0, np.nan, 0])}, "not finite"),
        ({"twist": np.full(6, 1e13)}, "not finite, or beyond 1e[+]12"),
        ({"orientation": np.zeros(4)}, "no unit quaternion: its length is 0"),
        ({"orientation": np.array([0, 0, 0, 1.1])}, "its length is 1.1"),
    ],
)
def test_odometry_that_cannot_be_used_is_refused(change: dict, words: str) -> None:
    pipeline = pipeline_of(floating_robot())
    good = OdometrySample(START, "l1", np.zeros(3), np.array([0, 0, 0, 1.0]), np.zeros(6))
    pipeline.odometry.take(good)
    before = pipeline.odometry.newest
    with pytest.raises(RejectedError, match=words):
        pipeline.odometry.take(good._replace(**change))
    assert pipeline.odometry.newest is before


def test_odometry_goes_with_a_floating_base_and_its_motors_alone() -> None:
    settings = NodeSettings({"odometry.topic": "/odom"})
    with pytest.raises(ParameterError, match="robot ankle has no floating base"):
        odometry_of(load("ankle"), settings)
    both = NodeSettings({"odometry.topic": "/odom", "measured": (f"{FREE}_x", KNEE)})
    with pytest.raises(ParameterError, match="with odometry the active joints are measured, knee"):
        odometry_of(floating_robot(), both)


needs_nav_msgs = pytest.mark.skipif(
    importlib.util.find_spec("nav_msgs") is None,
    reason="nav_msgs is not installed: pip install ros-jazzy-nav-msgs==5.3.6",
)


def message_of(sample: OdometrySample) -> object:
    """As nav_msgs/Odometry; its covariances are odd, and nobody reads them."""
    from nav_msgs.msg import Odometry

    message = Odometry(child_frame_id="l1")
    place, turn = message.pose.pose.position, message.pose.pose.orientation
    place.x, place.y, place.z = map(float, sample.position)
    turn.x, turn.y, turn.z, turn.w = map(float, sample.orientation)
    linear, angular = message.twist.twist.linear, message.twist.twist.angular
    linear.x, linear.y, linear.z = map(float, sample.twist[:3])
    angular.x, angular.y, angular.z = map(float, sample.twist[3:])
    message.pose.covariance = message.twist.covariance = np.full(36, -7.0)
    return message


def answered(client, motion: JointMotion, stamp_ns: int, place: float) -> int:
    """Stamp of the first motion that is answered with the newest odometry: its base is at x."""
    stamps = iter(range(stamp_ns, stamp_ns + 5 * MS, 1000))

    def ask():
        stamp = next(stamps)
        client.publish("active_joint_motions", motion, stamp)
        states = client.wait_for("joint_states", stamp)
        is_newest = states.position[states.name.index(f"{FREE}_x")] == place
        return stamp if is_newest else None

    return client.wait_until(ask, "an answer with the newest odometry")


@needs_nav_msgs
def test_a_running_node_answers_a_tumbling_base(start_node, connect, tmp_path: Path) -> None:
    """Real messages give the wrenches and efforts of the pipeline, to the last bit."""
    from nav_msgs.msg import Odometry

    file = tmp_path / "tumbler.yaml"
    file.write_text(to_yaml(floating_robot().description))
    parameters = ("-p", f"robot:={file}", "-p", "odometry.topic:=/fly/odom")
    start_node("-r", "__ns:=/fly", *parameters, "-p", "log_period:=0.0")
    client = connect("/fly/hybrid_dynamics", only=("describe_robot",))
    client.advertise(Odometry, "/fly/odom")
    pipeline = pipeline_of(load(file))
    motion = JointMotion(name=[KNEE], position=[0.3], velocity=[1.0], acceleration=[-0.5])
    rng = np.random.default_rng(5)
    twist, change = rng.normal(size=6), rng.normal(size=6)
    for k in range(10):
        first = client.new_stamp(0.01)
        sample = odometry(first, rng, twist + 0.01 * k * change)
        pipeline.odometry.take(sample)
        client.publish("/fly/odom", message_of(sample), first)
        stamp = answered(client, motion, first, sample.position[0])
        result = pipeline.process(sample_of_motion(motion)._replace(stamp_ns=stamp))
        assert isinstance(result, MotionResult)
        if result.base_wrench is None:
            assert k < 4
            continue
        sent = client.wait_for("base_wrench", stamp)
        assert sent.header.frame_id == "l1"
        force, torque = sent.wrench.force, sent.wrench.torque
        wrench = [force.x, force.y, force.z, torque.x, torque.y, torque.z]
        assert wrench == result.base_wrench.tolist()
        efforts = client.wait_for("required_efforts", stamp)
        assert list(efforts.name) == [KNEE]
        assert list(efforts.effort) == result.efforts[:1].tolist()


def test_without_nav_msgs_the_node_says_so(start_node, tmp_path: Path) -> None:
    file = tmp_path / "tumbler.yaml"
    file.write_text(to_yaml(floating_robot().description))
    (tmp_path / "nav_msgs").mkdir()  # shadows the real one
    (tmp_path / "nav_msgs" / "__init__.py").write_text("raise ImportError")
    path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    parameters = ("-p", f"robot:={file}", "-p", "odometry.topic:=/odom")
    node = start_node("-r", "__ns:=/bare", *parameters, environment={"PYTHONPATH": path})
    node.wait_for(r"parameter odometry\.topic: nav_msgs is not installed; install it with ROS")
