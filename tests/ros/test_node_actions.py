"""Actions of the running node, called by a client in this process."""

import threading

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from hybrid_dynamics_msgs.action import ConvertTrajectory
from hybrid_dynamics_msgs.msg import ErrorCode, TrajectoryStatus
from hybrid_dynamics_msgs.srv import SolveFK
from rclpy.action import ActionClient
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

ACTIVE = ["q1", "q12", "q22", "q4"]
START = np.array([0.0, 0.1, 0.15, 0.0])
PATIENCE = 60.0  # [s]


class Goals:
    """Sends goals of one action, and keeps what comes back."""

    def __init__(self, client, kind, name):
        self._client = ActionClient(client._node, kind, name)
        self._between_turns = client.between_turns
        self.feedback = []
        assert self._client.wait_for_server(PATIENCE)

    def send(self, goal):
        """The handle of a goal, once it is answered."""
        return done(self._ask(self._client.send_goal_async, goal, self._on_feedback))

    def _on_feedback(self, message):
        self.feedback.append(message.feedback)

    def result(self, handle):
        """The future of a goal's result."""
        return self._ask(handle.get_result_async)

    def cancel(self, handle):
        """What comes of the wish to cancel a goal."""
        return done(self._ask(handle.cancel_goal_async))

    def _ask(self, call, *arguments):
        # An answer that another thread takes before rclpy knows of the question is thrown away.
        return self._between_turns(call, *arguments)

    def destroy(self):
        self._between_turns(self._client.destroy)


def done(future):
    """What comes of a future, while another thread spins."""
    arrived = threading.Event()
    future.add_done_callback(lambda _: arrived.set())
    assert arrived.wait(PATIENCE), "nothing came back"
    return future.result()


@pytest.fixture
def goals(client):
    made = Goals(client, ConvertTrajectory, "/hybrid_dynamics/convert_trajectory")
    yield made
    made.destroy()


def trajectory(count, step=0.5, names=ACTIVE, way=(0.2, 0.02, 0.02, 0.1)):
    message = JointTrajectory(joint_names=list(names))
    for k in range(count):
        share = 0.5 - 0.5 * np.cos(np.pi * k / (count - 1))
        point = JointTrajectoryPoint(positions=(START + share * np.array(way)).tolist())
        nanoseconds = round(k * step * 1e9)
        point.time_from_start.sec, point.time_from_start.nanosec = divmod(nanoseconds, 10**9)
        message.points.append(point)
    return message


def test_the_action_answers_as_the_service_does(client, goals):
    message = trajectory(9)
    handle = goals.send(ConvertTrajectory.Goal(joints=message))
    assert handle.accepted
    outcome = done(goals.result(handle))
    assert outcome.status == GoalStatus.STATUS_SUCCEEDED
    request = client._services["convert_trajectory"].srv_type.Request(joints=message)
    answer = client.call("convert_trajectory", request)
    assert outcome.result.error_code == answer.error_code == ErrorCode.OK
    assert outcome.result.trajectory == answer.trajectory
    assert len(answer.trajectory.points) >= 9
    assert outcome.result.first_bad == answer.first_bad == -1
    assert np.isnan(outcome.result.first_bad_time)
    assert outcome.result.nearest_singularity == answer.nearest_singularity


def test_a_goal_that_goes_wrong_is_aborted_with_the_first_bad_time(goals):
    message = trajectory(9, way=(0.0, 0.9, 0.0, 0.0))
    outcome = done(goals.result(goals.send(ConvertTrajectory.Goal(joints=message))))
    assert outcome.status == GoalStatus.STATUS_ABORTED
    result = outcome.result
    assert result.error_code in (ErrorCode.LIMIT, ErrorCode.OUT_OF_REACH, ErrorCode.SINGULAR)
    assert 0 < result.first_bad < 9
    assert 0.5 * (result.first_bad - 1) < result.first_bad_time <= 0.5 * result.first_bad
    assert f"{result.first_bad_time:.9g} s" in result.error_text
    outcome = done(goals.result(goals.send(ConvertTrajectory.Goal())))
    assert outcome.status == GoalStatus.STATUS_ABORTED
    assert outcome.result.error_code == ErrorCode.BAD_INPUT


def test_a_long_goal_gives_feedback_lets_others_be_answered_and_can_be_cancelled(client, goals):
    handle = goals.send(ConvertTrajectory.Goal(joints=trajectory(20_000)))
    client.wait_until(lambda: len(goals.feedback) > 2, "feedback", PATIENCE)
    first, last = goals.feedback[0], goals.feedback[-1]
    assert first.stage == "motion"
    assert 0.0 < first.progress < last.progress < 1.0
    assert 0.0 < first.reached < last.reached
    assert 0.0 < last.nearest_singularity < 1.0
    joints = JointState(name=ACTIVE, position=START.tolist())
    short = client.call("solve_fk", SolveFK.Request(active_joints=joints))
    assert short.error_code == ErrorCode.OK
    message = client._services["convert_trajectory"].srv_type.Request(joints=trajectory(3))
    assert client.call("convert_trajectory", message).error_code == ErrorCode.OK
    outcome = goals.result(handle)
    assert not outcome.done()
    assert goals.cancel(handle).goals_canceling
    assert done(outcome).status == GoalStatus.STATUS_CANCELED
    assert not done(outcome).result.trajectory.points


def test_every_trajectory_on_the_topic_is_answered_on_the_status_topic(client):
    seen = []
    name = "/hybrid_dynamics/joint_trajectory_status"
    subscription = client._node.create_subscription(TrajectoryStatus, name, seen.append, 10)
    try:
        client.wait_until(subscription.get_publisher_count, "the status topic")
        client.wait_until(
            lambda: client._node.count_subscribers(name), "the subscription in the graph"
        )
        late = trajectory(3)
        late.points[2].time_from_start.sec = 0
        late.points[2].time_from_start.nanosec = 0
        messages = [trajectory(3), JointTrajectory(), late]
        messages.append(trajectory(3, names=["q1", "q12", "q22", "knee"]))
        messages.append(trajectory(9, way=(0.0, 0.9, 0.0, 0.0)))
        answers = []
        for message in messages:
            stamp = client.new_stamp()
            before = len(seen)
            client.publish("joint_trajectory", message, stamp)
            client.wait_until(lambda before=before: len(seen) > before, "a status", PATIENCE)
            answers.append(seen[-1])
            assert seen[-1].header.stamp.sec == stamp // 10**9
    finally:
        client.between_turns(client._node.destroy_subscription, subscription)
    good, empty, backward, unknown, beyond = answers
    assert good.error_code == ErrorCode.OK
    assert not good.error_text
    assert good.first_bad == -1
    assert 0.0 < good.nearest_singularity < 1.0
    for bad in (empty, backward, unknown):
        assert bad.error_code == ErrorCode.BAD_INPUT
    assert "expected later" in backward.error_text
    assert "knee" in unknown.error_text
    assert beyond.first_bad_time > 0.0
    assert beyond.error_code != ErrorCode.OK
