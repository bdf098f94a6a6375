"""The proxy in front of a controller: a planner, the node and a controller, each a process."""

import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from action_msgs.msg import GoalStatus

from hybrid_dynamics_core import load
from hybrid_dynamics_ros.actions.follow_tolerances import active_tolerances
from hybrid_dynamics_ros.services.trajectory_steps import JointMaps
from tests.ros import message_build

HERE = Path(__file__).resolve().parent
SERIAL = ["slew", "boom_pitch", "stick_pitch", "bucket_pitch"]
CONTROLLER = "/controller/follow_joint_trajectory"
INVALID_GOAL, INVALID_JOINTS, GOAL_TOLERANCE_VIOLATED = -1, -2, -5
PATIENCE = 120.0  # [s]


class Tolerance:
    """As control_msgs/JointTolerance."""

    def __init__(self, name="", position=0.0, velocity=0.0, acceleration=0.0):
        self.name, self.position = name, position
        self.velocity, self.acceleration = velocity, acceleration


@pytest.mark.parametrize("name", ["excavator", "forging_chu2020"])
def test_joints_are_within_their_tolerances_where_active_ones_are_within_theirs(name):
    robot = load(name)
    rng = np.random.default_rng(4)
    entries = np.abs(robot.close(robot.reference).R)
    maps = JointMaps(robot.coordinates, robot.active, entries, entries)
    sizes = rng.uniform(0.01, 0.1, len(entries))
    asked = [
        Tolerance(joint, position, 2.0 * position)
        for joint, position in zip(robot.coordinates, sizes.tolist(), strict=True)
    ]
    given = active_tolerances(asked, maps, entries)
    by_name = {tolerance.name: tolerance for tolerance in given}
    position = np.array([by_name[joint].position for joint in robot.active])
    most = entries @ position
    limits = np.array([tolerance.position for tolerance in asked])
    assert (most <= limits * (1.0 + 1e-9)).all()
    # none could be larger alone: some joint uses up its share
    moving = np.count_nonzero(entries > 1e-9, axis=1)
    uses = entries * position * moving[:, None] / limits[:, None]
    np.testing.assert_allclose(uses.max(axis=0), 1.0)
    velocity = np.array([by_name[joint].velocity for joint in robot.active])
    np.testing.assert_allclose(velocity, 2.0 * position)
    free = active_tolerances([Tolerance(robot.active[0], -1.0)], maps, entries)
    assert [(entry.name, entry.position) for entry in free] == [(robot.active[0], -1.0)]
    assert active_tolerances([], maps, entries) == []


def plan(goal):
    """What comes of a goal of a planner in a process of its own."""
    done = subprocess.run(
        [sys.executable, str(HERE / "trajectory_client.py")],
        input=json.dumps(goal),
        stdout=subprocess.PIPE,
        text=True,
        timeout=PATIENCE,
        check=True,
    )
    return json.loads(done.stdout)


class Controller:
    """The process of the controller; what it got is a list."""

    def __init__(self, joints, folder):
        self._log = folder / "controller.log"
        with self._log.open("w") as log:
            self._process = subprocess.Popen(
                [sys.executable, str(HERE / "trajectory_controller.py"), ",".join(joints)],
                stdin=subprocess.PIPE,
                stdout=log,
                stderr=subprocess.STDOUT,
            )

    def got(self):
        lines = self._log.read_text().splitlines()
        return [json.loads(line) for line in lines if line.startswith("{")]

    def wait(self):
        """Until it takes goals."""
        end = time.monotonic() + PATIENCE
        while "ready" not in self._log.read_text():
            assert self._process.poll() is None, self._log.read_text()
            assert time.monotonic() < end, "the controller is not ready"
            time.sleep(0.05)

    def close(self):
        self._process.kill()
        self._process.wait()
        self._process.stdin.close()


def asked(robot, count=4, step=0.5, **more):
    """A goal of the serial joints, and the active coordinates at its points."""
    shares = 0.5 - 0.5 * np.cos(np.pi * np.arange(count) / (count - 1))
    u = robot.reference + np.outer(shares, [0.2, 0.05, 0.05, 0.05])
    s = robot.close_path(u).s
    places = [robot.coordinates.index(name) for name in SERIAL]
    goal = {
        "names": SERIAL,
        "time": (step * np.arange(count)).tolist(),
        "positions": s[:, places].tolist(),
    }
    return goal | more, u


@pytest.mark.timeout(600)  # the first run on a machine builds control_msgs
@pytest.mark.sweep(
    sample="test_joints_are_within_their_tolerances_where_active_ones_are_within_theirs"
)
def test_a_planner_moves_serial_joints_by_a_controller_of_cylinders(
    start_node, tmp_path, monkeypatch
):
    for name, value in message_build.environment("control_msgs").items():
        monkeypatch.setenv(name, value)
    robot = load("excavator")
    node = start_node("-p", "robot:=excavator", "-p", f"trajectory.follow_action:={CONTROLLER}")
    node.wait_for("active joints", PATIENCE)
    goal, u = asked(robot)
    alone = plan(goal)
    assert (alone["status"], alone["code"]) == (GoalStatus.STATUS_ABORTED, INVALID_GOAL)
    assert CONTROLLER in alone["text"]

    controller = Controller(robot.active, tmp_path)
    try:
        controller.wait()
        # The node learns of it a little later, and code is made for the first feedback.
        for _ in range(20):
            told = plan(goal | {"tolerance": {"boom_pitch": 0.05}, "goal_time": 3})
            if len(told["feedback"]) > 3:
                break
        assert (told["status"], told["text"]) == (GoalStatus.STATUS_SUCCEEDED, "there")
        sent = controller.got()[-1]
        check_what_was_sent(robot, sent, goal, u)
        check_feedback(robot, told["feedback"], sent)

        long, _ = asked(robot, step=20.0, cancel=True)
        told = plan(long)
        assert (told["status"], told["text"]) == (
            GoalStatus.STATUS_CANCELED,
            "stopped on the way",
        )
        check_refusals(robot, goal)
        assert controller.got()[-1]["time"][-1] > 1000.0  # what is refused is not sent
    finally:
        controller.close()
    assert node.stop() == 0
    assert "Traceback" not in node.output()


def check_refusals(robot, goal):
    """What the controller, or the proxy, does not do, and why."""
    told = plan(asked(robot, goal_time=77)[0])
    assert told["status"] == GoalStatus.STATUS_ABORTED
    assert (told["code"], told["text"]) == (GOAL_TOLERANCE_VIOLATED, "off by too much")
    told = plan(asked(robot, step=500.0)[0])
    assert (told["status"], told["code"]) == (GoalStatus.STATUS_ABORTED, INVALID_GOAL)
    assert "did not accept" in told["text"]
    told = plan(goal | {"names": [*SERIAL[:3], "knee"]})
    assert (told["status"], told["code"]) == (GoalStatus.STATUS_ABORTED, INVALID_JOINTS)
    assert "knee" in told["text"]
    far, _ = asked(robot, step=20.0)
    far["positions"][-1][1] += 3.0
    told = plan(far)
    assert (told["status"], told["code"]) == (GoalStatus.STATUS_ABORTED, INVALID_GOAL)
    assert "point 3" in told["text"]


def check_what_was_sent(robot, sent, goal, u):
    assert tuple(sent["names"]) == robot.active
    times = np.array(sent["time"])
    places = [int(np.argmin(np.abs(times - time))) for time in goal["time"]]
    np.testing.assert_allclose(times[places], goal["time"], atol=1e-9)
    np.testing.assert_allclose(np.array(sent["positions"])[places], u, atol=1e-8)
    state = robot.close_path(np.array(sent["positions"]), np.array(sent["velocities"]))
    expected = robot.inverse_dynamics(state, np.array(sent["accelerations"]))
    scale = np.abs(expected).max()
    np.testing.assert_allclose(sent["effort"], expected, atol=1e-9 * scale)
    assert sent["goal_time"] == 3.0
    assert set(sent["goal_tolerance"]) == {"boom_cylinder"}
    row = state.R[:, robot.coordinates.index("boom_pitch"), robot.active.index("boom_cylinder")]
    assert sent["goal_tolerance"]["boom_cylinder"] == pytest.approx(0.05 / abs(row[-1]), rel=1e-6)
    assert sent["path_tolerance"]["boom_cylinder"] == pytest.approx(
        0.1 / np.abs(row).max(), rel=1e-2
    )


def check_feedback(robot, feedback, sent):
    places = [robot.coordinates.index(name) for name in SERIAL]
    for entry in feedback:
        assert entry["names"] == SERIAL
        np.testing.assert_allclose(
            entry["error"], np.subtract(entry["desired"], entry["actual"]), atol=1e-12
        )
        values = dict(zip(SERIAL, entry["desired"], strict=True))
        desired = robot.close_given(values, near=robot.close(robot.reference))
        actual = robot.close(0.99 * desired.u)
        np.testing.assert_allclose(actual.s[places], entry["actual"], atol=1e-7)
    assert feedback[-1]["time"] == pytest.approx(sent["time"][-1], abs=0.5)
