"""Topics of the node in its own process: what goes in, what comes out, and what bad input does."""

import numpy as np
import pytest
from hybrid_dynamics_msgs.msg import JointMotion
from sensor_msgs.msg import JointState

from hybrid_dynamics_ros.stream.filter.rate_estimator import MotionEstimator

ACTIVE = ["q1", "q12", "q22", "q4"]
COORDINATES = [*ACTIVE, "q2", "q3", "q11", "q21", "q31", "q32", "q41", "q42"]
RATES = [0.17453292519943295, 0.01, 0.005, 0.08726646259971647]

# Chu (2020), corrected model, t = 5 s: rates constant, accelerations zero.
AT_5S = {
    "position": [0.8726646259971648, 0.15000000000000002, 0.175, 0.4363323129985824],
    "passive": [
        2.240221999268083, -1.7753447316754485, 0.6068849106766953, 0.34752827573786155,
        2.240221999268083, -0.6694256724731864, 2.0356735943875313, -0.4648772675926345,
    ],
    "passive_rates": [
        -0.025048971643405988, -0.029362117506863936, 0.0011385896201548114, -0.005356227484711477,
        -0.025048971643405988, 0.02504897164340598, -0.05441108915026993, 0.054411089150269945,
    ],
    "tool": [0.3226478557853928, 0.38451674127506036, 1.1179125884719605],
    "efforts": [0.1783183547256898, 846.5280575553463, -4032.4362202954067, 0.0],
}  # fmt: skip

MS = 10**6  # [ns]


def trajectory(t):
    """Active coordinates of the paper's trajectory at t [s]."""
    return [np.deg2rad(10 * t), 0.1 + 0.01 * t, 0.15 + 0.005 * t, np.deg2rad(5 * t)]


def state(position, velocity=(), names=ACTIVE):
    return JointState(name=list(names), position=list(position), velocity=list(velocity))


def motion(position, velocity, acceleration, names=ACTIVE):
    return JointMotion(
        name=list(names),
        position=list(position),
        velocity=list(velocity),
        acceleration=list(acceleration),
    )


def send(client, message, topic="active_joint_states", after_s=10.0):
    """Publishes a message with a new stamp; the stamp."""
    stamp = client.new_stamp(after_s)
    client.publish(topic, message, stamp)
    return stamp


def test_the_first_message_gives_the_full_state_and_the_pose_but_no_efforts(client):
    stamp = send(client, state(AT_5S["position"], RATES))
    states = client.wait_for("joint_states", stamp)
    assert list(states.name) == COORDINATES
    np.testing.assert_allclose(states.position, AT_5S["position"] + AT_5S["passive"], rtol=1e-9)
    np.testing.assert_allclose(states.velocity, RATES + AT_5S["passive_rates"], rtol=1e-9)
    assert not states.effort

    pose = client.wait_for("end_effector_pose", stamp)
    p = pose.pose.position
    np.testing.assert_allclose([p.x, p.y, p.z], AT_5S["tool"], rtol=1e-9)

    later = send(client, state(AT_5S["position"], RATES))
    client.wait_for("end_effector_pose", later)
    assert client.received("required_efforts", stamp) is None


def test_the_pose_is_that_of_the_core_in_the_base_frame(client, robot):
    stamp = send(client, state(AT_5S["position"], RATES))
    pose = client.wait_for("end_effector_pose", stamp)
    expected = robot.forward_kinematics(robot.close(np.array(AT_5S["position"])))
    p, o = pose.pose.position, pose.pose.orientation
    np.testing.assert_allclose([p.x, p.y, p.z], expected.position, rtol=0, atol=1e-12)
    np.testing.assert_allclose([o.x, o.y, o.z, o.w], expected.quaternion, rtol=0, atol=1e-12)
    assert pose.header.frame_id == robot.base_frame


def test_efforts_follow_as_soon_as_the_filter_has_its_samples(client):
    """10 Hz bandwidth: the lag is 20.5 ms, so of samples every 10 ms the fourth is the first with
    efforts.
    """
    times = 5.0 + 0.01 * np.arange(-3, 1)
    stamps = [
        send(client, state(trajectory(t), RATES), after_s=10.0 if k == 0 else 0.01)
        for k, t in enumerate(times)
    ]
    efforts = client.wait_for("required_efforts", stamps[-1])
    assert list(efforts.name) == ACTIVE
    np.testing.assert_allclose(efforts.effort, AT_5S["efforts"], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(efforts.position, AT_5S["position"], rtol=1e-14)
    np.testing.assert_allclose(efforts.velocity, RATES, rtol=1e-14)
    assert [client.received("required_efforts", s) is not None for s in stamps] == [
        False,
        False,
        False,
        True,
    ]


def test_efforts_of_a_moving_robot_are_those_of_the_core_with_the_estimated_acceleration(
    client, robot
):
    estimator, before = MotionEstimator(bandwidth=10.0, max_gap=0.5), None
    expected = {}
    for k in range(40):
        t = 0.008 * k
        position = np.array(
            [0.3 * np.sin(4 * t), 0.15 + 0.02 * np.sin(6 * t), 0.18 - 0.01 * np.sin(5 * t), t * t]
        )
        velocity = np.array(
            [1.2 * np.cos(4 * t), 0.12 * np.cos(6 * t), -0.05 * np.cos(5 * t), 2 * t]
        )
        stamp = send(client, state(position, velocity), after_s=10.0 if k == 0 else 0.008)
        before, estimate = estimator.step(before, stamp, position, velocity)
        if estimate.acceleration is not None:
            expected[stamp] = robot.inverse_dynamics(
                robot.close(position, velocity), estimate.acceleration
            )
    assert len(expected) == 37
    for stamp, efforts in expected.items():
        found = client.wait_for("required_efforts", stamp)
        np.testing.assert_allclose(found.effort, efforts, rtol=1e-9, atol=1e-9)


def test_positions_alone_are_enough(client):
    """Velocities stay empty until they are known, and are right once they are."""
    times = 5.0 + 0.01 * np.arange(-9, 1)
    stamps = [
        send(client, state(trajectory(t)), after_s=10.0 if k == 0 else 0.01)
        for k, t in enumerate(times)
    ]
    efforts = client.wait_for("required_efforts", stamps[-1])
    first, last = (client.wait_for("joint_states", stamp) for stamp in (stamps[0], stamps[-1]))
    assert len(first.position) == 12
    assert not first.velocity
    np.testing.assert_allclose(last.velocity, RATES + AT_5S["passive_rates"], rtol=1e-9)
    # Second differences over squares of 10 ms make 1e-16 of an angle some 1e-11 rad/s^2, times 40
    # kg m^2.
    np.testing.assert_allclose(efforts.effort, AT_5S["efforts"], rtol=1e-7, atol=1e-7)


def test_any_order_and_extra_joints_give_the_same_answer(client):
    plain = send(client, state(AT_5S["position"], RATES))
    mixed = ["gripper", "q4", "q22", "wheel", "q1", "q12"]
    values = dict(zip(ACTIVE, AT_5S["position"], strict=True)) | {
        "gripper": np.nan,
        "wheel": np.inf,
    }
    rates = dict(zip(ACTIVE, RATES, strict=True)) | {"gripper": np.nan, "wheel": -1.0}
    permuted = send(
        client, state([values[n] for n in mixed], [rates[n] for n in mixed], names=mixed)
    )
    one, two = (client.wait_for("joint_states", stamp) for stamp in (plain, permuted))
    assert one.name == two.name
    assert one.position == two.position
    assert one.velocity == two.velocity


def test_a_motion_with_accelerations_is_taken_as_it_is(client):
    """Random state 3 of the reference.

    Efforts from the first message on, of accelerations no filter has seen.
    """
    stamp = send(
        client,
        motion(
            [-2.950072572451802, 0.3686350229686578, 0.16542729697869665, 1.8635211280904178],
            [-0.9901818610566706, 0.396641364192897, 0.42524781165824777, -1.5548293123588761],
            [2.3215335582074648, 1.7816527949044674, 0.711416642284382, -5.90919723539675],
        ),
        topic="active_joint_motions",
    )
    efforts = client.wait_for("required_efforts", stamp)
    expected = [72.07777020390348, -724.9220642267553, -1046.2027248836825, -2.1598115895375125]
    np.testing.assert_allclose(efforts.effort, expected, rtol=1e-9)
    assert client.wait_for("joint_states", stamp)
    assert client.wait_for("end_effector_pose", stamp)


def test_backward_stamps_start_the_filter_anew(client, node):
    stamps = [
        send(client, state(trajectory(0.01 * k), RATES), after_s=10.0 if k == 0 else 0.01)
        for k in range(6)
    ]
    client.wait_for("required_efforts", stamps[-1])
    back = stamps[0] - 5000 * MS
    for k in range(4):  # one by one: of a burst a busy node answers the newest
        stamp = back + 10 * k * MS
        client.publish("active_joint_states", state(trajectory(0.01 * k), RATES), stamp)
        client.wait_for("joint_states", stamp)
    client.wait_for("required_efforts", back + 30 * MS)
    assert client.received("required_efforts", back) is None
    node.wait_for("backward stamp")


GOOD = AT_5S["position"]
BAD_STATES = {
    "missing joint": (
        state(GOOD[:3], RATES[:3], names=ACTIVE[:3]),
        "missing joint: q4 not named; named are q1, q12, q22",
    ),
    "duplicate joint": (state([*GOOD, 0.1], names=[*ACTIVE, "q12"]), "duplicate joint: joint q12"),
    "NaN position": (
        state([GOOD[0], np.nan, *GOOD[2:]], RATES),
        "not finite: position of joint q12 is nan",
    ),
    "infinite velocity": (
        state(GOOD, [*RATES[:3], np.inf]),
        "not finite: velocity of joint q4 is inf",
    ),
    "empty message": (JointState(), "empty: no joint is named"),
    "positions too few": (state(GOOD[:3], RATES), "wrong length: position has 3 values for 4"),
    "positions none": (state([], RATES), "wrong length: position has 0 values for 4"),
    "velocities too many": (
        state(GOOD, [*RATES, 0.0]),
        "wrong length: velocity has 5 values for 4",
    ),
    "cylinder too long": (state([0.0, 0.9, 0.15, 0.0], RATES), r"unreachable: .*q12.*0\.9"),
    "cylinder too short": (state([0.0, 0.1, -0.35, 0.0], RATES), r"unreachable: .*q22.*-0\.35"),
}


@pytest.mark.parametrize("kind", BAD_STATES)
def test_a_bad_state_is_logged_and_not_answered_and_the_node_goes_on(client, node, kind):
    message, line = BAD_STATES[kind]
    bad = send(client, message)
    node.wait_for(f"rejected, {line}")
    good = send(client, state(GOOD, RATES))
    found = client.wait_for("joint_states", good)
    np.testing.assert_allclose(found.position[4:], AT_5S["passive"], rtol=1e-9)
    client.wait_for("end_effector_pose", good)
    assert all(
        client.received(t, bad) is None
        for t in ("joint_states", "required_efforts", "end_effector_pose")
    )


BAD_MOTIONS = {
    "no accelerations": (motion(GOOD, RATES, []), "wrong length: acceleration has 0 values for 4"),
    "no velocities": (motion(GOOD, [], [0.0] * 4), "wrong length: velocity has 0 values for 4"),
    "missing joint": (
        motion([0.1], [0.0], [0.0], names=["q12"]),
        "missing joint: q1, q22, q4 not named; named are q12",
    ),
    "NaN acceleration": (
        motion(GOOD, RATES, [0.0, 0.0, 0.0, np.nan]),
        "not finite: acceleration of joint q4",
    ),
    "empty message": (JointMotion(), "empty: no joint is named"),
    "huge numbers": (motion(GOOD, [1e300] * 4, [0.0] * 4), "overflow: "),
    "out of reach": (motion([0.0, 5.0, 0.15, 0.0], RATES, [0.0] * 4), r"unreachable: .*q12"),
}


@pytest.mark.parametrize("kind", BAD_MOTIONS)
def test_a_bad_motion_is_logged_and_not_answered_and_the_node_goes_on(client, node, kind):
    message, line = BAD_MOTIONS[kind]
    bad = send(client, message, "active_joint_motions")
    node.wait_for(f"rejected, {line}")
    good = send(client, motion(GOOD, RATES, [0.0] * 4), "active_joint_motions")
    efforts = client.wait_for("required_efforts", good)
    np.testing.assert_allclose(efforts.effort, AT_5S["efforts"], rtol=1e-9, atol=1e-9)
    client.wait_for("joint_states", good)
    assert client.received("joint_states", bad) is None
    assert client.received("required_efforts", bad) is None


def test_a_negative_stamp_is_refused(client, node):
    message = state(GOOD, RATES)
    client.publish("active_joint_states", message, -5 * 10**9)
    node.wait_for("rejected, bad stamp: stamp is -5000000000 ns")


def test_a_rejected_sample_does_not_reach_the_filter(client):
    """One wild sample in a steady stream: efforts after it are as if it had not been."""
    stamps = []
    for k in range(8):
        position = trajectory(5.0 + 0.01 * (k - 7))
        stamps.append(client.new_stamp(10.0 if k == 0 else 0.01))
        client.publish("active_joint_states", state(position, RATES), stamps[-1])
        if k == 5:
            client.publish(
                "active_joint_states", state([0.0, 9.0, 0.15, 0.0], [50.0] * 4), stamps[-1] + 5 * MS
            )
    efforts = client.wait_for("required_efforts", stamps[-1])
    np.testing.assert_allclose(efforts.effort, AT_5S["efforts"], rtol=1e-9, atol=1e-9)
