"""Ball joints that are driven and measured by poses: Pinocchio's numbers at every orientation."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from geometry_msgs.msg import Quaternion, Transform, Twist, Vector3
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import JointState, MultiDOFJointState

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_core.export import to_yaml
from hybrid_dynamics_ros.bags.errors import BagError
from hybrid_dynamics_ros.bags.input_topic import INPUT
from hybrid_dynamics_ros.bags.job import Job
from hybrid_dynamics_ros.bags.process import process
from hybrid_dynamics_ros.messages.interfaces import JOINT_STATE
from hybrid_dynamics_ros.messages.joint_poses import JOINT_POSES, samples_of_joint_poses
from hybrid_dynamics_ros.messages.joint_samples import JointSample, RejectedError, Rejection
from hybrid_dynamics_ros.messages.link_transforms import LinkTransforms
from hybrid_dynamics_ros.parameters import NodeSettings, ParameterError
from hybrid_dynamics_ros.stream.conditions import poses_of
from hybrid_dynamics_ros.stream.pipeline import Pipeline
from hybrid_dynamics_ros.stream.results import MotionResult
from hybrid_dynamics_ros.stream.topics import topics_of
from tests.bags.messages import START, joint_state
from tests.bags.test_odometry import sent_by, write
from tests.laws.test_multi_dof import (
    BALL,
    FREE,
    KNEE,
    ORIGIN,
    ball_robot,
    floating_robot,
    in_pinocchio,
    two_links,
)
from tests.sampling import examples

MS = 10**6
SETTINGS = NodeSettings({"measured_poses": (BALL,)})
TOPIC = "/hybrid_dynamics/active_joint_poses"
TURNS = tuple(f"{BALL}_{turn}" for turn in ("rx", "ry", "rz"))
# as far as a filter of doubles has the rate of a linear twist; of numbers of about 10
FILTER = 1e-7
QUARTER = Rotation.from_euler("y", 90, degrees=True)


def pipeline_of(robot: Robot, **more: object) -> Pipeline:
    settings = NodeSettings({"measured_poses": (BALL,), **more})
    return Pipeline(robot, 10.0, 0.5, poses=poses_of(robot, settings))


def poses(stamp_ns: int, turn: Rotation, spin: np.ndarray, *others: str) -> MultiDOFJointState:
    """A message of the ball joint, after others that nobody asked for."""
    message = MultiDOFJointState(joint_names=[*others, BALL])
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, 10**9)
    x, y, z, w = turn.as_quat().tolist()
    for _ in message.joint_names:
        rotation = Quaternion(x=x, y=y, z=z, w=w)
        message.transforms.append(Transform(translation=Vector3(x=9.0), rotation=rotation))
        angular = Vector3(**dict(zip("xyz", map(float, spin), strict=True)))
        message.twist.append(Twist(linear=Vector3(x=9.0), angular=angular))
    return message


def tumbling(seed: int) -> list[MultiDOFJointState]:
    """Any orientations, some at a quarter turn of the second turn; spins that change evenly."""
    rng = np.random.default_rng(seed)
    spin, change = rng.normal(size=3), rng.normal(size=3)
    messages = []
    for k in range(8):
        turn = QUARTER if rng.integers(4) == 0 else Rotation.random(random_state=rng)
        messages.append(poses(START + 10 * MS * k, turn, spin + 0.01 * k * change, "arm"))
    return messages


def tumbled(pipeline: Pipeline, messages: list[MultiDOFJointState]) -> list[MotionResult]:
    """Results of joint states with the stamps of the poses."""
    results = []
    for k, message in enumerate(messages):
        assert pipeline.poses.joints is not None
        pipeline.poses.joints.take(samples_of_joint_poses(message))
        joint = np.array([0.3 + 0.01 * k])
        sample = JointSample(START + 10 * MS * k, [KNEE], joint, np.ones(1), np.array([-0.5]))
        result = pipeline.process(sample)
        assert isinstance(result, MotionResult), result
        results.append(result)
    return results


def sent(robot: Robot, result: MotionResult, name: str, kind: type) -> object:
    """What goes out on a topic."""
    topic = next(one for one in topics_of(robot, SETTINGS) if one.name == name)
    data = topic.fill(result)
    assert data is not None
    return deserialize_message(data, kind)


def vector(entry: Vector3) -> list[float]:
    return [entry.x, entry.y, entry.z]


@given(seed=st.integers(0, 10_000))
@examples(30)
def test_torques_of_a_driven_ball_joint_are_pinocchios_through_any_tumbling(seed: int) -> None:
    robot, messages = ball_robot(), tumbling(seed)
    results = tumbled(pipeline_of(robot), messages)
    change = np.subtract(vector(messages[1].twist[1].angular), vector(messages[0].twist[1].angular))
    placement = pin.SE3(pin.rpy.rpyToMatrix(np.array(ORIGIN["rpy"])), np.array(ORIGIN["xyz"]))
    model = in_pinocchio(robot, pin.JointModelSpherical(), placement)
    known = [k for k, result in enumerate(results) if result.efforts is not None]
    assert known[-4:] == [4, 5, 6, 7]
    for k in known[-4:]:
        given_, result = messages[k], results[k]
        turn, spin = given_.transforms[1].rotation, vector(given_.twist[1].angular)
        there = np.array([turn.x, turn.y, turn.z, turn.w, 0.3 + 0.01 * k])
        rates, accelerations = np.r_[spin, 1.0], np.r_[change / 0.01, -0.5]
        expected = pin.rnea(model, model.createData(), there, rates, accelerations)
        out = sent(robot, result, "joint_poses", MultiDOFJointState)
        assert list(out.joint_names) == [BALL]
        assert vector(out.wrench[0].torque) == pytest.approx(expected[:3], abs=FILTER)
        assert vector(out.twist[0].angular) == pytest.approx(spin, abs=1e-12)
        found = out.transforms[0].rotation
        alike = abs(np.dot([found.x, found.y, found.z, found.w], there[:4]))
        assert alike == pytest.approx(1.0, abs=1e-12)
        efforts = sent(robot, result, "required_efforts", JointState)
        by_name = dict(zip(efforts.name, efforts.effort, strict=True))
        assert by_name[KNEE] == pytest.approx(expected[3], abs=FILTER)
        rates_by_name = dict(zip(efforts.name, efforts.velocity, strict=True))
        power = sum(by_name[name] * rates_by_name[name] for name in TURNS)
        if np.isfinite(power):  # angles have no rates at the quarter turn
            sizes = [abs(by_name[name] * rates_by_name[name]) for name in TURNS]
            expected_power = np.dot(expected[:3], spin)
            assert power == pytest.approx(expected_power, abs=1e-6 * (1.0 + max(sizes)))
        states = sent(robot, result, "joint_states", JointState)
        assert np.isfinite(states.position).all()
        assert list(states.effort)[: len(by_name)] == list(efforts.effort)


@given(seed=st.integers(0, 10_000))
@examples(20)
def test_angles_on_topics_are_those_of_the_urdf_at_every_orientation(seed: int) -> None:
    robot, messages = ball_robot(), tumbling(seed)
    transforms = LinkTransforms(robot)
    for message, result in zip(messages, tumbled(pipeline_of(robot), messages), strict=True):
        slots = transforms.values(result.position)
        rotation = Rotation.identity()
        for name in TURNS:
            rotation = rotation * Rotation.from_quat(slots[2 * robot.coordinates.index(name) + 1])
        turn = message.transforms[1].rotation
        placed = Rotation.from_euler("xyz", ORIGIN["rpy"])
        given_ = placed * Rotation.from_quat([turn.x, turn.y, turn.z, turn.w])
        assert rotation.as_matrix() == pytest.approx(given_.as_matrix(), abs=1e-7)


def test_a_reference_without_good_angles_is_taken() -> None:
    quarter = [0.0, 0.5**0.5, 0.0, 0.5**0.5]
    robot = two_links({"type": "ball"}, active=[BALL, KNEE], reference={BALL: {"quat": quarter}})
    assert len(tumbled(pipeline_of(robot), tumbling(3))) == 8


def test_a_joint_state_needs_a_pose_near_its_stamp() -> None:
    pipeline = pipeline_of(ball_robot())
    early = pipeline.process(JointSample(START, [KNEE], np.array([0.3])))
    assert isinstance(early, Rejection)
    words = f"{BALL}: no pose on ~/active_joint_poses within 0.2 s: none has come yet"
    assert early.text.startswith(words)


def bad_messages() -> dict[str, MultiDOFJointState]:
    """Messages that cannot be used, by the words of their refusal."""
    still = np.zeros(3)
    good = poses(START, QUARTER, still)
    short, twice = poses(START, QUARTER, still), poses(START, QUARTER, still, BALL)
    short.twist = []
    other = MultiDOFJointState(joint_names=["arm"], transforms=good.transforms, twist=good.twist)
    long = poses(START, QUARTER, still)
    long.transforms[0].rotation.w = 2.0
    endless = poses(START, QUARTER, np.array([0.0, np.inf, 0.0]))
    return {
        "twist has 0 values for 1 joint name": short,
        "a joint is named twice": twice,
        "hip not named; named are arm": other,
        "no unit quaternion": long,
        "not finite": endless,
    }


@pytest.mark.parametrize("words", bad_messages())
def test_poses_that_cannot_be_used_are_refused(words: str) -> None:
    source = pipeline_of(ball_robot()).poses.joints
    assert source is not None
    source.take(samples_of_joint_poses(poses(START, QUARTER, np.zeros(3))))
    before = source.inputs[BALL].newest
    with pytest.raises(RejectedError, match=words):
        source.take(samples_of_joint_poses(bad_messages()[words]))
    assert source.inputs[BALL].newest is before


@pytest.mark.parametrize(
    ("robot", "values", "words"),
    [
        (ball_robot, {"measured_poses": (KNEE,)}, "'knee' is no ball or free joint that is active"),
        (ball_robot, {"measured_poses": (BALL, BALL)}, "'hip' is named twice"),
        (
            floating_robot,
            {"measured_poses": (FREE,), "odometry.topic": "/odom"},
            "measured by odometry.topic already",
        ),
        (
            ball_robot,
            {"measured_poses": (BALL,), "measured": (*TURNS, KNEE)[::-1]},
            "leave measured empty",
        ),
    ],
)
def test_parameters_that_do_not_fit_are_told(robot, values: dict, words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        poses_of(robot(), NodeSettings(values))


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("robot") / "ball.yaml"
    path.write_text(to_yaml(ball_robot().description))
    return path


@given(order=st.lists(st.sampled_from("pps"), min_size=12, max_size=30), seed=st.integers(0, 999))
@examples(12)
def test_recordings_have_the_poses_of_the_stream(
    file: Path, tmp_path_factory: pytest.TempPathFactory, order: list[str], seed: int
) -> None:
    robot, rng = load(file), np.random.default_rng(seed)
    pipeline = pipeline_of(robot)
    topics = [topic for topic in topics_of(robot, SETTINGS) if SETTINGS[topic.rate] == 0.0]
    every: dict[str, list[bytes]] = {topic.name: [] for topic in topics}
    written = []
    for k, what in enumerate(["p", *order, "p", "s"]):
        stamp = START + 10 * k * MS
        if what == "p":
            names = ["arm"] if rng.integers(2) else []
            message = poses(stamp, Rotation.random(random_state=rng), rng.normal(size=3), *names)
            with suppress(RejectedError):
                pipeline.poses.joints.take(samples_of_joint_poses(message))
            written.append((TOPIC, JOINT_POSES, stamp, bytes(serialize_message(message))))
            continue
        u, du = np.array([0.3 + 1e-3 * k]), np.array([0.01])
        written.append((INPUT, JOINT_STATE, stamp, joint_state(stamp, [KNEE], u, du)))
        result = pipeline.process(JointSample(stamp, [KNEE], u, du))
        if isinstance(result, MotionResult):
            for topic in topics:
                data = topic.fill(result)
                if data is not None:
                    every[topic.name].append(bytes(data))
    folder = tmp_path_factory.mktemp("poses")
    process(Job(write(folder / "in", written), folder / "out", str(file), settings=SETTINGS))
    there = sent_by(folder / "out")
    for name, expected in every.items():
        assert there.get(f"/hybrid_dynamics/{name}", []) == expected
    assert every["joint_poses"]


def test_a_bag_without_the_poses_is_refused(file: Path, tmp_path: Path) -> None:
    entries = [(INPUT, JOINT_STATE, START, joint_state(START, [KNEE], np.array([0.3])))]
    job = Job(write(tmp_path / "in", entries), tmp_path / "out", str(file), settings=SETTINGS)
    with pytest.raises(BagError, match=f"no {JOINT_POSES} on {TOPIC}"):
        process(job)


def is_turned(message: MultiDOFJointState, turn: Quaternion) -> bool:
    """Whether the ball joint is at an orientation."""
    found = message.transforms[0].rotation
    product = found.x * turn.x + found.y * turn.y + found.z * turn.z + found.w * turn.w
    return bool(abs(abs(product) - 1.0) < 1e-9)


@pytest.mark.sweep(sample="test_recordings_have_the_poses_of_the_stream")
def test_a_running_node_answers_a_tumbling_ball(start_node, connect, file: Path) -> None:
    """A process of its own gives the poses and twists of the pipeline, bit by bit."""
    robot = load(file)
    start_node("-r", "__ns:=/hip", "-p", f"robot:={file}", "-p", f"measured_poses:=[{BALL}]")
    client = connect("/hip/hybrid_dynamics", only=("describe_robot",))
    topic = "/hip/hybrid_dynamics/active_joint_poses"
    client.advertise(MultiDOFJointState, topic)
    pipeline = pipeline_of(robot)
    reader = next(one for one in topics_of(robot, SETTINGS) if one.name == "joint_poses")
    state = JointState(name=[KNEE], position=[0.3], velocity=[0.1])
    has_wrench = False
    for message in tumbling(5):
        first = client.new_stamp(0.01)
        client.publish(topic, message, first)
        turn = message.transforms[1].rotation
        asked = []

        def answered(first=first, turn=turn, asked=asked):
            asked.append(first + 500 * len(asked))
            client.publish("active_joint_states", state, asked[-1])
            for stamp in asked:
                answer = client.received("joint_poses", stamp)
                if answer is not None and is_turned(answer, turn):
                    return stamp
            return None

        stamp = client.wait_until(answered, "an answer with the newest pose")
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(first, 10**9)
        pipeline.poses.joints.take(samples_of_joint_poses(message))
        sample = JointSample(stamp, [KNEE], np.array([0.3]), np.array([0.1]))
        result = pipeline.process(sample)
        expected = deserialize_message(reader.fill(result), MultiDOFJointState)
        answer = client.received("joint_poses", stamp)
        assert answer.transforms == expected.transforms
        assert answer.twist == expected.twist
        has_wrench = has_wrench or bool(answer.wrench)
    assert has_wrench
