"""Messages of a result, and what the monitor makes of it."""

import dataclasses

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from hybrid_dynamics_msgs.msg import ClosedState
from hybrid_dynamics_msgs.msg import CylinderStates as CylinderStatesMessage
from rclpy.serialization import deserialize_message, serialize_message
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import JointState

from hybrid_dynamics_core import HydraulicCylinder, load
from hybrid_dynamics_ros.messages.interfaces import typestore
from hybrid_dynamics_ros.messages.joint_samples import JointSample
from hybrid_dynamics_ros.messages.joint_state_layout import joint_state_template
from hybrid_dynamics_ros.node.publishers import message_class
from hybrid_dynamics_ros.parameters import (
    BASE_FRAME,
    FRAME_PREFIX,
    LEAST_RATE,
    STROKE_WARN,
    TF_RATE,
    NodeSettings,
    ParameterError,
)
from hybrid_dynamics_ros.services.kinematics import closed_state_message
from hybrid_dynamics_ros.stream.monitor import Level, Monitor
from hybrid_dynamics_ros.stream.pipeline import Pipeline
from hybrid_dynamics_ros.stream.rate_limit import RateLimit
from hybrid_dynamics_ros.stream.results import MotionResult
from hybrid_dynamics_ros.stream.stroke_margins import StrokeMargins
from hybrid_dynamics_ros.stream.topics import (
    ClosedStates,
    CylinderStates,
    JointStates,
    RequiredEfforts,
    Transforms,
    topics_of,
)
from tests.mechanisms import changed, mechanism
from tests.sampling import swept

STAMP = Time(sec=3, nanosec=4)
TWO = np.ones(2)


def result_of(robot, velocity=0.01):
    n = len(robot.active)
    sample = JointSample(
        3 * 10**9 + 4, robot.active, robot.reference.copy(), np.full(n, velocity), np.zeros(n)
    )
    pipeline = Pipeline(robot, bandwidth=10.0, max_gap=0.5)
    return pipeline, pipeline.process(sample)


@pytest.mark.parametrize("name", swept(["excavator", "staicu2015", "delta"]))
def test_transforms_put_every_link_where_forward_kinematics_does(name):
    robot = load(name)
    _, result = result_of(robot)
    message = sent(topics_of(robot, NodeSettings({TF_RATE.name: 0.0}))[-1], result)
    poses = {robot.base_frame: np.eye(4)}
    transforms = {t.child_frame_id: t for t in message.transforms}
    while set(transforms) - set(poses):
        for link, told in transforms.items():
            if told.header.frame_id in poses and link not in poses:
                q, p = told.transform.rotation, told.transform.translation
                local = np.eye(4)
                local[:3, :3], local[:3, 3] = (
                    Rotation.from_quat([q.x, q.y, q.z, q.w]).as_matrix(),
                    [p.x, p.y, p.z],
                )
                poses[link] = poses[told.header.frame_id] @ local
    assert len(transforms) == len(robot.coordinates)
    for link, told in transforms.items():
        assert (told.header.stamp.sec, told.header.stamp.nanosec) == (3, 4)
        np.testing.assert_allclose(
            poses[link], robot.forward_kinematics(result.state, link).matrix, atol=1e-12
        )


def sent(topic, result):
    return typestore().deserialize_cdr(topic.fill(result), topic.kind)


def test_two_robots_on_one_tf_share_the_base_alone():
    """A prefix and a base: the same numbers under other names."""
    robot = load("forging_chu2020")
    _, result = result_of(robot)
    trees, plain = [], topics_of(robot, NodeSettings({TF_RATE.name: 0.0}))
    for prefix in ("left/", "right/"):
        names = {FRAME_PREFIX.name: prefix, BASE_FRAME.name: "world", TF_RATE.name: 0.0}
        topics = topics_of(robot, NodeSettings(names))
        for topic, other in zip(topics, plain, strict=True):
            if other.fill(result) is None:
                continue
            message, unnamed = sent(topic, result), sent(other, result)
            if hasattr(unnamed, "header") and unnamed.header.frame_id:
                assert message.header.frame_id == "world"
        children = {}
        for transform, other in zip(message.transforms, unnamed.transforms, strict=True):
            assert transform.child_frame_id == f"{prefix}{other.child_frame_id}"
            assert transform.transform == other.transform
            children[transform.child_frame_id] = transform.header.frame_id
        assert set(children.values()) <= {"world", *children}
        trees.append(children)
    assert not set(trees[0]) & set(trees[1])


def test_tf_without_its_package_is_refused_with_what_to_do():
    pytest.importorskip("rclpy")
    try:
        import tf2_msgs  # noqa: F401
    except ImportError:
        with pytest.raises(ParameterError, match=f"{TF_RATE.name}.*robot_state_publisher"):
            message_class(Transforms.kind)
    else:
        assert message_class(Transforms.kind).__name__ == "TFMessage"


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ([TWO, TWO], "shorter"),
        ([TWO, TWO, TWO, TWO], "longer"),
        (
            [TWO, TWO.astype(np.float32), TWO],
            "slot velocity: 8 bytes of float32; expected 16 of float64",
        ),
        ([np.ones(3), TWO, TWO], "slot position: 24 bytes of float64; expected 16 of float64"),
        ([TWO, TWO, np.ones(2, dtype=np.int64)], "slot effort: 16 bytes of int64"),
        ([TWO, TWO, 1.0], "slot effort: 8 bytes of float64; expected 16"),
    ],
)
def test_a_message_with_values_missing_or_of_another_kind_is_refused(wrong, words):
    """Bytes that go out for every input: what does not fit would shift all behind it."""
    template = joint_state_template(["a", "b"], velocity=True, effort=True)
    told = deserialize_message(template.fill(7, [TWO, TWO, TWO]), JointState)
    assert [told.header.stamp.nanosec, *told.position, *told.velocity, *told.effort] == [7] + [
        1.0
    ] * 6
    with pytest.raises(ValueError, match=words):
        template.fill(7, wrong)


@pytest.mark.parametrize(
    ("sec", "fits"), [(2**31 - 1, True), (2**31, False), (-(2**31), True), (-(2**31) - 1, False)]
)
def test_a_stamp_beyond_what_messages_hold_is_told(sec, fits):
    template = joint_state_template(["a"], velocity=False, effort=False)
    stamp_ns = sec * 10**9 + 5
    if fits:
        told = deserialize_message(template.fill(stamp_ns, [np.ones(1)]), JointState).header.stamp
        assert (told.sec, told.nanosec) == (sec, 5)
    else:
        with pytest.raises(
            ValueError,
            match=rf"the stamp {stamp_ns} ns is {sec} s.* from -2147483648 to 2147483647 \(Jan",
        ):
            template.fill(stamp_ns, [np.ones(1)])


@pytest.mark.parametrize("name", ["forging_chu2020", "staicu2015", "delta", "type_c"])
def test_messages_filled_in_as_bytes_are_those_that_rclpy_writes(name):
    robot = load(name)
    _, result = result_of(robot)
    state = result.state
    topics = (JointStates, RequiredEfforts, ClosedStates)
    states, efforts, closed = (topic(robot).fill(result) for topic in topics)
    along = deserialize_message(states, JointState).effort
    expected = [
        (
            states,
            JointState(
                name=list(robot.coordinates),
                position=result.position,
                velocity=result.velocity,
                effort=along,
            ),
        ),
        (
            efforts,
            JointState(
                name=list(robot.active), position=state.u, velocity=state.du, effort=result.efforts
            ),
        ),
        (closed, closed_state_message(robot, state, STAMP)),
    ]
    for data, message in expected:
        message.header.stamp = STAMP
        assert deserialize_message(data, type(message)) == message
        assert (
            0 <= len(serialize_message(message)) - len(data) <= 16
        )  # padding, which rclpy leaves unset
    assert isinstance(expected[-1][1], ClosedState)


def test_cylinder_states_are_those_of_the_library():
    robot = load("excavator")
    _, result = result_of(robot)
    message = deserialize_message(CylinderStates(robot).fill(result), CylinderStatesMessage)
    assert list(message.name) == list(robot.cylinders) != []
    wanted = robot.hydraulics(result.state, result.efforts)
    for k, name in enumerate(message.name):
        assert message.cap_pressure[k] == float(wanted[name].cap_pressure)
        assert message.rod_flow[k] == float(wanted[name].rod_flow)
        assert message.to_upper[k] == float(wanted[name].to_upper)
    told = deserialize_message(JointStates(robot).fill(result), JointState)
    efforts = dict(zip(told.name, told.effort, strict=True))
    forces = robot.drive_forces(result.state, result.efforts)
    assert {name: efforts[name] for name in forces} == {
        name: float(force) for name, force in forces.items()
    }
    assert all(efforts[name] == 0.0 for name in told.name if name not in forces)


@pytest.mark.parametrize("dead", ["none", "some", "all"])
def test_rows_have_the_messages_of_their_samples_at_dead_centres_too(dead):
    """A cylinder that pushes a crank by its rod: with both in line it can give no effort."""
    cylinder = HydraulicCylinder("s", bore=0.05, rod=0.03)
    robot = changed(mechanism("slider_crank"), actuators={"s": cylinder})
    slide = robot.coordinates.index("s")
    centre = brentq(lambda a: robot.close([0.0, a]).R[slide, 1], -1.0, 1.0, xtol=1e-15)
    is_dead = {"none": [False] * 3, "some": [False, True, False, True, True], "all": [True] * 3}
    pipeline = Pipeline(robot, bandwidth=10.0, max_gap=0.5)
    singles = []
    for k, dies in enumerate(is_dead[dead]):
        position = np.array([0.1 * k, centre if dies else 0.6 + 0.05 * k])
        sample = JointSample(k * 10**7, robot.active, position, TWO, 0.3 * TWO)
        singles.append(pipeline.process(sample))
    topic, rows = JointStates(robot), MotionResult.joined(singles)
    filled = {}
    for group in topic.groups(rows):
        if len(group):
            template, values = topic.message(rows.rows(group))
            for place, row in enumerate(group.tolist()):
                parts = [part[place] for part in values]
                filled[row] = template.fill(singles[row].stamp_ns, parts)
    assert [filled[k] for k in range(len(singles))] == [topic.fill(one) for one in singles]
    for k, (one, dies) in enumerate(zip(singles, is_dead[dead], strict=True)):
        efforts = list(deserialize_message(filled[k], JointState).effort)
        assert bool(efforts) != dies
        if efforts:
            forces = robot.drive_forces(one.state, one.efforts)
            assert efforts == [float(forces.get(name, 0.0)) for name in robot.coordinates]


def test_rows_are_as_near_to_a_singularity_as_their_samples():
    robot = load("forging_chu2020")
    results = []
    for share in (0.0, 0.5, 1.0, 1.5):
        position = robot.reference + share * np.array([0.0, 0.05, -0.05, 0.0])
        sample = JointSample(0, robot.active, position, np.zeros(4), np.zeros(4))
        results.append(Pipeline(robot, bandwidth=10.0, max_gap=0.5).process(sample))
    joined = MotionResult.joined(results)
    assert joined.nearest[0].tolist() == [result.nearest[0] for result in results]
    assert joined.nearest[1] == results[0].nearest[1]
    for result in results:
        expected = robot.close(result.active.position)
        assert result.nearest == (float(expected.singularity), expected.singular_loop)


def test_the_monitor_tells_levels_by_its_thresholds(robot):
    pipeline, result = result_of(robot)
    monitor = Monitor(StrokeMargins(robot))

    def levels(settings, now_ns=result.stamp_ns):
        entries = monitor.report(result, pipeline.counts, now_ns, settings)
        entries += monitor.robot_report(result, settings)
        return {entry.name: entry.level for entry in entries}

    usual = levels(NodeSettings())
    assert usual["stroke margin"] is Level.OK
    assert usual["age of the stamp [s]"] is Level.OK
    assert levels(NodeSettings({STROKE_WARN.name: 10.0}))["stroke margin"] is Level.WARN
    assert levels(NodeSettings({LEAST_RATE.name: 1e6}))["rate [Hz]"] is Level.WARN
    assert levels(NodeSettings(), result.stamp_ns + 5 * 10**9)["age of the stamp [s]"] is Level.WARN
    assert (
        levels(NodeSettings(), result.stamp_ns - 5 * 10**9)["age of the stamp [s]"] is Level.WARN
    )  # from the future
    assert levels(NodeSettings())["received"] is Level.STALE  # nothing new since the last report


def test_a_joint_beyond_its_limit_is_told(robot):
    _, result = result_of(robot)
    strokes = StrokeMargins(robot)
    monitor = Monitor(strokes)
    assert not monitor.beyond(result)
    far = result.position.copy()
    name = "q12"
    k = robot.coordinates.index(name)
    far[k] = strokes.upper[k] + 0.25
    told = {name: f"{name} is beyond its upper limit by 0.25 m; it is answered"}
    assert monitor.beyond(dataclasses.replace(result, position=far)) == told
    far[k] = strokes.lower[k] - 0.5
    other = robot.coordinates.index("q22")
    far[other] = strokes.upper[other] + 0.1
    told = {
        name: f"{name} is beyond its lower limit by 0.5 m; it is answered",
        "q22": "q22 is beyond its upper limit by 0.1 m; it is answered",
    }
    assert monitor.beyond(dataclasses.replace(result, position=far)) == told


@pytest.mark.parametrize(
    ("rate", "wanted"), [(0.0, 1000), (-1.0, 0), (100.0, 100), (300.0, 300), (1e5, 1000)]
)
def test_a_pace_lets_its_rate_through_whatever_the_jitter(rate, wanted):
    pace, random = RateLimit(), np.random.default_rng(0)
    stamps = 10**12 + np.arange(1000) * 10**6 + random.integers(0, 400_000, 1000)
    assert abs(sum(pace.due(int(stamp), rate) for stamp in stamps) - wanted) <= 1


def test_a_pace_starts_anew_where_stamps_go_back():
    pace = RateLimit()
    assert [pace.due(stamp, 1.0) for stamp in (10**10, 10**10 + 1, 5, 6)] == [
        True,
        False,
        True,
        False,
    ]
