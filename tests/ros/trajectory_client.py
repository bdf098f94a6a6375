"""For tests: a client of FollowJointTrajectory, as MoveIt is one, in a process of its own.

Reads a goal as JSON from its standard input, and prints as JSON what came of it.
"""

import json
import os
import sys
import threading

import rclpy
from control_msgs.action import FollowJointTrajectory
from control_msgs.msg import JointTolerance
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from trajectory_msgs.msg import JointTrajectoryPoint

PATIENCE = 90.0  # [s]


def tell(text):
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def goal_of(asked):
    goal = FollowJointTrajectory.Goal()
    goal.trajectory.joint_names = asked["names"]
    for time, position in zip(asked["time"], asked["positions"], strict=True):
        point = JointTrajectoryPoint(positions=position)
        point.time_from_start.sec = int(time)
        point.time_from_start.nanosec = round((time - int(time)) * 1e9)
        goal.trajectory.points.append(point)
    goal.goal_time_tolerance.sec = asked.get("goal_time", 0)
    for name, value in asked.get("tolerance", {}).items():
        goal.goal_tolerance.append(JointTolerance(name=name, position=value))
        goal.path_tolerance.append(JointTolerance(name=name, position=2.0 * value))
    return goal


def done(future):
    arrived = threading.Event()
    future.add_done_callback(lambda _: arrived.set())
    assert arrived.wait(PATIENCE), "nothing came back"
    return future.result()


def main():
    asked = json.load(sys.stdin)
    rclpy.init()
    node = rclpy.create_node("planner")
    client = ActionClient(node, FollowJointTrajectory, "/hybrid_dynamics/follow_joint_trajectory")
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    threading.Thread(target=executor.spin, daemon=True).start()
    assert client.wait_for_server(PATIENCE), "there is no action server"
    feedback = []
    moving = threading.Event()

    def on_feedback(message):
        feedback.append(message.feedback)
        moving.set()

    def ask(call, *arguments):
        """A future, asked for by the thread that spins: rclpy may lose an answer otherwise."""
        return done(executor.create_task(call, *arguments))

    handle = done(ask(client.send_goal_async, goal_of(asked), on_feedback))
    result = ask(handle.get_result_async)
    if asked.get("cancel"):
        assert moving.wait(PATIENCE), "no feedback"
        done(ask(handle.cancel_goal_async))
    outcome = done(result)
    told = {
        "status": outcome.status,
        "code": outcome.result.error_code,
        "text": outcome.result.error_string,
        "feedback": [
            {
                "names": list(entry.joint_names),
                "desired": list(entry.desired.positions),
                "actual": list(entry.actual.positions),
                "error": list(entry.error.positions),
                "velocity": list(entry.desired.velocities),
                "time": entry.desired.time_from_start.sec
                + 1e-9 * entry.desired.time_from_start.nanosec,
            }
            for entry in feedback
        ],
    }
    tell(json.dumps(told))
    os._exit(0)  # a thread still spins


if __name__ == "__main__":
    main()
