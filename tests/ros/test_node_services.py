"""Services of the node in its own process, called from this one."""

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from hybrid_dynamics_msgs.msg import ErrorCode, JointMotion
from hybrid_dynamics_msgs.srv import InverseDynamics, SolveFK, SolveIK
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

ACTIVE = ["q1", "q12", "q22", "q4"]
STAMP = Time(sec=12, nanosec=34)

# Chu (2020), corrected model, t = 5 s.
POSITION = [0.8726646259971648, 0.15000000000000002, 0.175, 0.4363323129985824]
RATES = [0.17453292519943295, 0.01, 0.005, 0.08726646259971647]
TOOL = [0.3226478557853928, 0.38451674127506036, 1.1179125884719605]
EFFORTS = [0.1783183547256898, 846.5280575553463, -4032.4362202954067, 0.0]


def joints(position, velocity=(), names=ACTIVE):
    return JointState(
        header=Header(stamp=STAMP),
        name=list(names),
        position=list(position),
        velocity=list(velocity),
    )


def target(position, quaternion=(0.0, 0.0, 0.0, 1.0), frame=""):
    x, y, z, w = quaternion
    px, py, pz = position
    return PoseStamped(
        header=Header(stamp=STAMP, frame_id=frame),
        pose=Pose(position=Point(x=px, y=py, z=pz), orientation=Quaternion(x=x, y=y, z=z, w=w)),
    )


def motion(position, velocity, acceleration, names=ACTIVE):
    return JointMotion(
        header=Header(stamp=STAMP),
        name=list(names),
        position=list(position),
        velocity=list(velocity),
        acceleration=list(acceleration),
    )


def test_solve_fk_gives_the_full_state_and_the_pose(client, robot):
    response = client.call("solve_fk", SolveFK.Request(active_joints=joints(POSITION, RATES)))
    assert response.error_code == ErrorCode.OK
    assert not response.error_text
    state = robot.close(np.array(POSITION), np.array(RATES))
    assert tuple(response.joint_state.name) == robot.coordinates
    np.testing.assert_allclose(response.joint_state.position, state.s, rtol=1e-12)
    np.testing.assert_allclose(response.joint_state.velocity, state.ds, rtol=1e-12)
    assert response.joint_state.header.stamp == STAMP
    (pose,) = response.poses
    p = pose.pose.position
    np.testing.assert_allclose([p.x, p.y, p.z], TOOL, rtol=1e-9)
    assert pose.header.frame_id == robot.base_frame
    assert pose.header.stamp == STAMP
    assert 0.0 <= response.residual < 1e-12


def test_solve_ik_inverts_solve_fk(client, robot):
    seed = joints([0.8, 0.14, 0.18, POSITION[3]])
    request = SolveIK.Request(
        target=target(TOOL), position_only=True, seed=seed, all_solutions=True
    )
    response = client.call("solve_ik", request)
    assert response.error_code == ErrorCode.OK, response.error_text
    assert tuple(response.solution.name) == robot.coordinates
    np.testing.assert_allclose(response.solution.position[:4], POSITION, rtol=0, atol=1e-9)
    assert list(response.redundant) == ["q4"]
    assert response.residual < 1e-9
    assert len(response.solutions) > 1  # turned to the target, and turned away and leaning back
    assert response.solutions[0].position == response.solution.position[:4]
    for solution in response.solutions:
        assert list(solution.name) == ACTIVE
        pose = robot.forward_kinematics(robot.close(np.array(solution.position)))
        np.testing.assert_allclose(pose.position, TOOL, rtol=0, atol=1e-9)
    assert len(response.loops) == len(response.branches) > 0


def test_solve_ik_gives_one_solution_unless_all_are_asked_for(client):
    response = client.call("solve_ik", SolveIK.Request(target=target(TOOL), position_only=True))
    assert response.error_code == ErrorCode.OK, response.error_text
    (solution,) = response.solutions
    assert solution.position == response.solution.position[:4]


def test_solve_ik_takes_a_full_pose(client, robot):
    pose = robot.forward_kinematics(robot.close(np.array(POSITION)))
    wanted = target(pose.position.tolist(), pose.quaternion.tolist(), robot.base_frame)
    response = client.call("solve_ik", SolveIK.Request(target=wanted))
    assert response.error_code == ErrorCode.OK, response.error_text
    np.testing.assert_allclose(response.solution.position[:4], POSITION, rtol=0, atol=1e-9)
    assert not response.redundant


def test_inverse_dynamics_gives_the_efforts(client, robot):
    request = InverseDynamics.Request(motion=motion(POSITION, RATES, [0.0] * 4))
    response = client.call("inverse_dynamics", request)
    assert response.error_code == ErrorCode.OK, response.error_text
    assert list(response.efforts.name) == ACTIVE
    np.testing.assert_allclose(response.efforts.effort, EFFORTS, rtol=1e-9, atol=1e-9)
    assert tuple(response.joint_state.name) == robot.coordinates
    assert response.efforts.header.stamp == STAMP


BAD_CALLS = {
    "fk, missing joint": (
        "solve_fk",
        SolveFK.Request(active_joints=joints(POSITION[:3], names=ACTIVE[:3])),
        ErrorCode.BAD_INPUT,
        "q4",
    ),
    "fk, empty": ("solve_fk", SolveFK.Request(), ErrorCode.BAD_INPUT, "no joint is named"),
    "fk, NaN": (
        "solve_fk",
        SolveFK.Request(active_joints=joints([0.0, np.nan, 0.1, 0.0])),
        ErrorCode.BAD_INPUT,
        "q12 is nan",
    ),
    "fk, unknown frame": (
        "solve_fk",
        SolveFK.Request(active_joints=joints(POSITION), frames=["no_such_frame"]),
        ErrorCode.BAD_INPUT,
        "no_such_frame",
    ),
    "fk, cylinder too long": (
        "solve_fk",
        SolveFK.Request(active_joints=joints([0.0, 0.9, 0.15, 0.0])),
        ErrorCode.OUT_OF_REACH,
        "q12",
    ),
    "ik, out of reach": (
        "solve_ik",
        SolveIK.Request(target=target([5.0, 0.0, 0.0]), position_only=True),
        ErrorCode.OUT_OF_REACH,
        "",
    ),
    "ik, NaN": (
        "solve_ik",
        SolveIK.Request(target=target([np.nan, 0.0, 1.0]), position_only=True),
        ErrorCode.BAD_INPUT,
        "nan",
    ),
    "ik, no orientation": (
        "solve_ik",
        SolveIK.Request(target=target(TOOL, (0.0, 0.0, 0.0, 0.0))),
        ErrorCode.BAD_INPUT,
        "quaternion",
    ),
    "ik, other frame": (
        "solve_ik",
        SolveIK.Request(target=target(TOOL, frame="map"), position_only=True),
        ErrorCode.BAD_INPUT,
        "map",
    ),
    "ik, seed of wrong length": (
        "solve_ik",
        SolveIK.Request(target=target(TOOL), position_only=True, seed=joints(POSITION[:2])),
        ErrorCode.BAD_INPUT,
        "2 values for 4",
    ),
    "id, no accelerations": (
        "inverse_dynamics",
        InverseDynamics.Request(motion=motion(POSITION, RATES, [])),
        ErrorCode.BAD_INPUT,
        "acceleration has 0 values",
    ),
    "id, duplicate joint": (
        "inverse_dynamics",
        InverseDynamics.Request(
            motion=motion([*POSITION, 0.1], [0.0] * 5, [0.0] * 5, names=[*ACTIVE, "q1"])
        ),
        ErrorCode.BAD_INPUT,
        "q1",
    ),
    "id, cylinder too short": (
        "inverse_dynamics",
        InverseDynamics.Request(motion=motion([0.0, 0.1, -0.35, 0.0], RATES, [0.0] * 4)),
        ErrorCode.OUT_OF_REACH,
        "q22",
    ),
}


@pytest.mark.parametrize("kind", BAD_CALLS)
def test_a_bad_call_gets_its_error_code_and_text_and_the_node_goes_on(client, kind):
    service, request, code, text = BAD_CALLS[kind]
    response = client.call(service, request)
    assert response.error_code == code
    assert text in response.error_text
    assert response.error_text
    assert "\n" not in response.error_text
    again = client.call("solve_fk", SolveFK.Request(active_joints=joints(POSITION)))
    assert again.error_code == ErrorCode.OK


@pytest.mark.parametrize("kind", [kind for kind in BAD_CALLS if not kind.startswith("id")])
def test_a_refused_call_has_nan_for_a_residual_and_no_joints(client, robot, kind):
    service, request, *_ = BAD_CALLS[kind]
    response = client.call(service, request)
    if kind == "ik, out of reach":
        assert response.residual > 1.0  # what remains at the nearest configuration found
        assert list(response.solution.name) == list(robot.coordinates)
        assert not response.solutions
        return
    assert np.isnan(response.residual)
    joint_state = response.solution if service == "solve_ik" else response.joint_state
    assert not joint_state.name
    assert not joint_state.position


def test_refused_calls_are_logged(client, node):
    client.call("solve_fk", SolveFK.Request())
    node.wait_for("solve_fk: no joint is named")
