"""For tests: a controller that follows trajectories, in a process of its own.

It speaks as a joint_trajectory_controller does: a goal is followed by polynomials of degree five,
with feedback, and it can be cancelled. The joints stand in the command line. Each goal is printed
as a line of JSON. One that ends after 1000 s is not accepted; one with a time tolerance of 77 s
misses its end.
"""

import json
import sys
import threading
import time

import rclpy
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from scipy.interpolate import BPoly
from trajectory_msgs.msg import JointTrajectoryPoint

NAME = "/controller/follow_joint_trajectory"
JOINTS = sys.argv[1].split(",")
TRACKING = 0.99  # what is reached of what is desired


def tell(text):
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def seconds(duration):
    return duration.sec + 1e-9 * duration.nanosec


def judge(goal):
    trajectory = goal.trajectory
    points = trajectory.points
    line = {
        "names": list(trajectory.joint_names),
        "time": [seconds(point.time_from_start) for point in points],
        "positions": [list(point.positions) for point in points],
        "velocities": [list(point.velocities) for point in points],
        "accelerations": [list(point.accelerations) for point in points],
        "effort": [list(point.effort) for point in points],
        "goal_tolerance": {entry.name: entry.position for entry in goal.goal_tolerance},
        "path_tolerance": {entry.name: entry.position for entry in goal.path_tolerance},
        "goal_time": seconds(goal.goal_time_tolerance),
    }
    tell(json.dumps(line))
    good = sorted(trajectory.joint_names) == sorted(JOINTS) and line["time"][-1] < 1000.0
    return GoalResponse.ACCEPT if good else GoalResponse.REJECT


def follow(handle):
    trajectory = handle.request.trajectory
    points = trajectory.points
    times = [seconds(point.time_from_start) for point in points]
    rows = [[point.positions, point.velocities, point.accelerations] for point in points]
    curve = BPoly.from_derivatives(times, rows)
    begin = time.monotonic()
    result = FollowJointTrajectory.Result()
    while True:
        now = min(time.monotonic() - begin, times[-1])
        desired = JointTrajectoryPoint(
            positions=curve(now).tolist(), velocities=curve(now, 1).tolist()
        )
        reached = [TRACKING * value for value in desired.positions]
        actual = JointTrajectoryPoint(positions=reached, velocities=desired.velocities)
        for point in (desired, actual):
            point.time_from_start.sec = int(now)
            point.time_from_start.nanosec = int(now % 1.0 * 1e9)
        feedback = FollowJointTrajectory.Feedback(
            joint_names=trajectory.joint_names, desired=desired, actual=actual
        )
        handle.publish_feedback(feedback)
        if handle.is_cancel_requested:
            handle.canceled()
            result.error_string = "stopped on the way"
            return result
        if now == times[-1]:
            break
        time.sleep(0.02)
    if handle.request.goal_time_tolerance.sec == 77:
        handle.abort()
        result.error_code = FollowJointTrajectory.Result.GOAL_TOLERANCE_VIOLATED
        result.error_string = "off by too much"
        return result
    handle.succeed()
    result.error_string = "there"
    return result


def main():
    rclpy.init()
    node = rclpy.create_node("controller")
    ActionServer(
        node,
        FollowJointTrajectory,
        NAME,
        follow,
        goal_callback=judge,
        cancel_callback=lambda _: CancelResponse.ACCEPT,
        callback_group=ReentrantCallbackGroup(),
    )
    executor = MultiThreadedExecutor(4)
    executor.add_node(node)
    tell("ready")
    threading.Thread(target=executor.spin, daemon=True).start()
    sys.stdin.read()  # until the test closes it


if __name__ == "__main__":
    main()
