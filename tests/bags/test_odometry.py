"""Odometry in recordings: a processed bag has what the node would have sent, to the last bit."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from scipy.spatial.transform import Rotation

from hybrid_dynamics_core import Pose, load
from hybrid_dynamics_core.export import to_yaml
from hybrid_dynamics_ros.bags.analysis.collect import collect
from hybrid_dynamics_ros.bags.analysis.identify import identify_recording, requested_parameters
from hybrid_dynamics_ros.bags.analysis.report import report
from hybrid_dynamics_ros.bags.errors import BagError
from hybrid_dynamics_ros.bags.input_topic import INPUT
from hybrid_dynamics_ros.bags.job import Job
from hybrid_dynamics_ros.bags.process import process
from hybrid_dynamics_ros.bags.settings import make_pipeline
from hybrid_dynamics_ros.messages.interfaces import JOINT_STATE, typestore
from hybrid_dynamics_ros.messages.joint_samples import JointSample, RejectedError
from hybrid_dynamics_ros.messages.odometry import ODOMETRY, sample_of_odometry
from hybrid_dynamics_ros.parameters import NodeSettings
from hybrid_dynamics_ros.stream.results import MotionResult
from hybrid_dynamics_ros.stream.topics import topics_of
from tests.bags.messages import START, joint_state
from tests.laws.test_multi_dof import FREE, KNEE, floating_robot
from tests.sampling import examples

MS = 10**6
SETTINGS = NodeSettings({"odometry.topic": "~/base", "acceleration_filter.type": "kalman"})
TOPIC = "/hybrid_dynamics/base"


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("robot") / "tumbler.yaml"
    path.write_text(to_yaml(floating_robot().description))
    return path


def odometry(stamp_ns: int, rng: np.random.Generator, link: str) -> bytes:
    """CDR bytes of an Odometry with any pose and twist."""
    turn = rng.normal(size=4)
    turn /= np.linalg.norm(turn)
    place, linear, angular = rng.normal(size=3), rng.normal(size=3), rng.normal(size=3)
    return odometry_of(stamp_ns, Rotation.from_quat(turn), angular, linear, place, link)


def odometry_of(
    stamp_ns: int,
    turn: Rotation,
    angular: np.ndarray,
    linear: Sequence[float] = (0.0, 0.0, 0.0),
    place: Sequence[float] = (0.0, 0.0, 0.0),
    link: str = "l1",
) -> bytes:
    """CDR bytes of an Odometry."""
    types = typestore().types

    def vector(kind: str, *values: float) -> object:
        return types[f"geometry_msgs/msg/{kind}"](*map(float, values))

    pose = types["geometry_msgs/msg/Pose"](
        vector("Point", *place), vector("Quaternion", *turn.as_quat())
    )
    twist = types["geometry_msgs/msg/Twist"](
        vector("Vector3", *linear), vector("Vector3", *angular)
    )
    covariance = np.full(36, -1.0)
    time = types["builtin_interfaces/msg/Time"](sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
    message = types[ODOMETRY](
        types["std_msgs/msg/Header"](time, "odom"),
        link,
        types["geometry_msgs/msg/PoseWithCovariance"](pose, covariance),
        types["geometry_msgs/msg/TwistWithCovariance"](twist, covariance),
    )
    return bytes(typestore().serialize_cdr(message, ODOMETRY))


def write(path: Path, entries: list[tuple[str, str, int, bytes]]) -> Path:
    """A bag of entries: topic, kind, log time, data."""
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connections = {}
        for topic, kind, log_ns, data in entries:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=typestore())
            writer.write(connections[topic], log_ns, data)
    return path


def sent_by(path: Path) -> dict[str, list[bytes]]:
    """All messages of a bag by topic."""
    sent: dict[str, list[bytes]] = {}
    with Reader(path) as reader:
        for connection, _, data in reader.messages():
            sent.setdefault(connection.topic, []).append(bytes(data))
    return sent


@st.composite
def recordings(draw: st.DrawFn) -> list[tuple[str, int]]:
    """Odometry, some of another link, and joint states in any order: what, and its stamp [ms]."""
    entries, stamp = [("base", 0)], 0
    kinds = st.sampled_from(["base", "base", "state", "state", "wheel"])
    for _ in range(draw(st.integers(20, 40))):
        stamp += draw(st.sampled_from([1, 5, 10, 150]))
        entries.append((draw(kinds), stamp))
    return [*entries, ("base", stamp + 1), ("state", stamp + 2)]


@examples(16)
@given(entries=recordings(), seed=st.integers(0, 1000))
def test_recordings_have_the_wrenches_of_the_stream(
    file: Path,
    tmp_path_factory: pytest.TempPathFactory,
    entries: list[tuple[str, int]],
    seed: int,
) -> None:
    robot, rng = load(file), np.random.default_rng(seed)
    pipeline, topics = make_pipeline(robot, SETTINGS), topics_of(robot, SETTINGS)
    every = {topic.name: [] for topic in topics if SETTINGS[topic.rate] == 0.0}
    written = []
    for kind, stamp_ms in entries:
        stamp = START + stamp_ms * MS
        if kind != "state":
            data = odometry(stamp, rng, "l1" if kind == "base" else kind)
            with suppress(RejectedError):  # of another link
                sample = sample_of_odometry(typestore().deserialize_cdr(data, ODOMETRY))
                pipeline.odometry.take(sample)
            written.append((TOPIC, ODOMETRY, stamp, data))
            continue
        u, du = np.array([0.3 + 1e-5 * stamp_ms]), np.array([0.01])
        result = pipeline.process(JointSample(stamp, [KNEE], u, du))
        written.append((INPUT, JOINT_STATE, stamp, joint_state(stamp, [KNEE], u, du)))
        if isinstance(result, MotionResult):
            for topic in topics:
                data = topic.fill(result)
                if topic.name in every and data is not None:
                    every[topic.name].append(data)
    folder = tmp_path_factory.mktemp("odometry")
    process(Job(write(folder / "in", written), folder / "out", str(file), settings=SETTINGS))
    sent = sent_by(folder / "out")
    for name, expected in every.items():
        assert sent.get(f"/hybrid_dynamics/{name}", []) == expected
    assert every["joint_states"]


def test_a_bag_without_the_odometry_is_refused(file: Path, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    state = joint_state(START, [KNEE], np.array([0.3]))
    entries = [
        ("/odom", ODOMETRY, START, odometry(START, rng, "l1")),
        (INPUT, JOINT_STATE, START, state),
    ]
    job = Job(write(tmp_path / "in", entries), tmp_path / "out", str(file), settings=SETTINGS)
    words = r"no nav_msgs/msg/Odometry on /hybrid_dynamics/base; it has some on /odom"
    with pytest.raises(BagError, match=words):
        process(job)


@examples(6)
@given(seed=st.integers(0, 1000))
def test_reports_have_the_efforts_of_the_stream(
    file: Path, tmp_path_factory: pytest.TempPathFactory, seed: int
) -> None:
    """A base that tumbles: what a report computes are the efforts of the node."""
    robot, rng = load(file), np.random.default_rng(seed)
    pipeline, written, expected = make_pipeline(robot, SETTINGS), [], []
    for k in range(40):
        stamp = START + 10 * MS * k
        data = odometry(stamp, rng, "l1")
        pipeline.odometry.take(sample_of_odometry(typestore().deserialize_cdr(data, ODOMETRY)))
        written.append((TOPIC, ODOMETRY, stamp, data))
        u, du = np.array([0.3 + 1e-3 * k]), np.array([0.1])
        result = pipeline.process(JointSample(stamp, [KNEE], u, du))
        assert isinstance(result, MotionResult)
        expected.append(result.efforts)
        state = joint_state(stamp, [KNEE], u, du, [1.0])
        written.append((INPUT, JOINT_STATE, stamp + 1, state))
    path = write(tmp_path_factory.mktemp("report") / "in", written)
    recording = collect(path, str(file), smooth="causal", settings=SETTINGS)
    known = [k for k, efforts in enumerate(expected) if efforts is not None]
    assert len(known) > 30
    knee = robot.active.index(KNEE)
    found = recording.efforts[known, knee]
    np.testing.assert_array_equal(found, [expected[k][knee] for k in known])
    np.testing.assert_array_equal(recording.recorded[:, knee], 1.0)
    assert "Efforts" in report(recording, "tumbling")


def test_parameters_are_identified_on_a_base_that_tumbles(file: Path, tmp_path: Path) -> None:
    """A base that turns evenly, of which odometry tells: the knee's efforts give the shank."""
    robot, written = load(file), []
    spin, still = np.array([0.9, 0.6, -0.4]), np.zeros(3)
    for k in range(900):
        stamp, angle = START + 10 * MS * k, 0.03 * k
        turn = Rotation.from_rotvec(0.01 * k * spin)
        written.append((TOPIC, ODOMETRY, stamp, odometry_of(stamp, turn, spin)))
        u, du, ddu = 0.5 * np.sin(angle), 1.5 * np.cos(angle), -4.5 * np.sin(angle)
        poses = {FREE: Pose(still, turn.as_matrix())}
        twists = {FREE: np.r_[still, spin]}
        values, rates = np.zeros(7), np.zeros(7)
        knee = robot.active.index(KNEE)
        values[knee], rates[knee] = u, du
        state = robot.close_at_poses(poses, twists, values, rates)
        by_twists = robot.twist_map(state)
        wanted = np.zeros(7)
        wanted[knee] = ddu
        tau = robot.inverse_dynamics(state, by_twists.rate_accelerations(wanted))
        given_ = np.array([u]), np.array([du]), [float(tau[knee])]
        written.append((INPUT, JOINT_STATE, stamp + 1, joint_state(stamp, [KNEE], *given_)))
    settings = NodeSettings({"odometry.topic": "~/base"})
    path = write(tmp_path / "in", written)
    recording = collect(path, str(file), smooth="spline", settings=settings)
    found = identify_recording(recording, requested_parameters(robot, ["l2"]))
    size = np.abs(found.file_values).max()
    # a spline through samples of a sine of 3 rad/s
    assert found.identification.estimate == pytest.approx(found.file_values, abs=1e-3 * size)
    assert found.joints == (KNEE,)  # what pushes the base is not known
