"""The longest gaps in a node's stream while services are called and parameters set, cold.

python tools/stream_gaps.py [--robot forging_chu2020] [--rate 100] [--warm] [--most 50]

The node starts with an empty cache of compiled code. One process sends joint states and takes what
comes back. This one calls every service and sets every parameter that may change, one after the
other. Each line: the longest time between two answers and between an input and its answer, and how
late the sender itself was. Ends with 1 where an answer came later than `--most` milliseconds.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import rclpy
from hybrid_dynamics_msgs import msg, srv
from hybrid_dynamics_msgs.action import ConvertTrajectory
from rcl_interfaces.srv import SetParameters
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_ros.demo.play.domain import private_domain
from hybrid_dynamics_ros.parameters import TABLE, ChangeTime, sensor_rows

NODE = "/hybrid_dynamics"
PATIENCE = 120.0  # [s] for the node to come up, and for an answer
GOAL = 3.0  # [s] after which a goal is cancelled
SETTLE = 0.3  # [s] after an answer that still belong to it
Action = tuple[str, Callable[[], str]]


def main() -> int:
    """Measure, print, judge."""
    options = _options()
    if options.stream:
        stream(options.robot, options.rate)
        return 0
    with private_domain(None), tempfile.TemporaryDirectory() as folder:
        if not options.warm:
            os.environ["HYBRID_DYNAMICS_CACHE"] = folder
        return measure(options, Path(folder))


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robot", default="forging_chu2020")
    parser.add_argument("--rate", type=float, default=100.0, help="joint states a second")
    parser.add_argument("--warm", action="store_true", help="with the cache of this user")
    parser.add_argument("--most", type=float, default=50.0, help="longest way of an input [ms]")
    parser.add_argument("--only", default="", help="actions whose name has this word")
    parser.add_argument("--points", type=int, default=3, help="of the trajectory to convert")
    parser.add_argument("--stream", action="store_true", help=argparse.SUPPRESS)
    return parser.parse_args()


def measure(options: argparse.Namespace, folder: Path) -> int:
    """Start the processes, do everything, print the gaps; the exit code."""
    robot = load(options.robot)
    log, arrivals = folder / "node.log", folder / "arrivals"
    words = [sys.executable, "-m", "hybrid_dynamics_ros.node", "--ros-args"]
    words += ["-p", f"robot:={options.robot}"]
    with log.open("w") as file, arrivals.open("w") as out:
        node = subprocess.Popen(words, stdout=file, stderr=file)
        again = [sys.executable, __file__, "--stream", "--robot", options.robot]
        sender = subprocess.Popen([*again, "--rate", str(options.rate)], stdout=out)
        try:
            _wait_for(log, "active joints")
            _wait_for(arrivals, "\n")
            windows = list(_act(robot, options))
        finally:
            for process in (sender, node):
                process.terminate()
                process.wait(PATIENCE)
    rows = [json.loads(line) for line in arrivals.read_text().splitlines() if line.endswith("]")]
    return _report(rows, windows, options)


def _wait_for(file: Path, text: str) -> None:
    end = time.monotonic() + PATIENCE
    while text not in file.read_text():
        if time.monotonic() > end:
            sys.exit(f"no '{text.strip()}' in {file.name}:\n{file.read_text()}")
        time.sleep(0.05)


def _report(rows: list[list[float]], windows: list[Any], options: argparse.Namespace) -> int:
    """Print a line for each window; 1 where an input took too long."""
    worst = 0.0
    print(f"{options.robot} at {options.rate:g} Hz, load {os.getloadavg()[0]:.1f}; [ms]")
    print(f"{'':44s}{'lasted':>8s}{'gap':>8s}{'way':>8s}{'sender':>8s}")
    for name, answer, start, end in windows:
        inside = [row for row in rows if start <= row[0] <= end + SETTLE]
        received = sorted(row[1] for row in inside)
        sent = sorted(row[0] for row in inside)
        way = 1e3 * max((row[1] - row[0] for row in inside), default=float("nan"))
        worst = max(worst, way)
        gaps = f"{_longest(received):8.1f}{way:8.1f}{_longest(sent):8.1f}"
        print(f"{name:44s}{1e3 * (end - start):8.0f}{gaps}  {answer}")
    print(f"{len(rows)} answers; longest way of an input {worst:.1f} ms, allowed {options.most:g}")
    return int(worst > options.most)


def _longest(times: list[float]) -> float:
    gaps = (after - before for before, after in itertools.pairwise(times))
    return 1e3 * max(gaps, default=float("nan"))


# -- what is done


def _act(robot: Robot, options: argparse.Namespace) -> Iterator[tuple[str, str, float, float]]:
    """Do one thing after the other: name, answer, start and end [s]."""
    rclpy.init()
    client = rclpy.create_node("stream_gaps")
    calls = _calls(robot, client, options.points)
    for name, act in [("nothing", _rest), *calls, *_settings(robot, client)]:
        if options.only not in name:
            continue
        time.sleep(SETTLE)
        start = time.monotonic()
        answer = act()
        yield name, answer, start, time.monotonic()
        time.sleep(SETTLE)
    client.destroy_node()
    rclpy.shutdown()


def _rest() -> str:
    time.sleep(2.0)
    return ""


def _call(client: Any, kind: Any, name: str, request: Any) -> Any:
    service = client.create_client(kind, f"{NODE}/{name}")
    if not service.wait_for_service(PATIENCE):
        sys.exit(f"there is no service {name}")
    future = service.call_async(request)
    rclpy.spin_until_future_complete(client, future, timeout_sec=PATIENCE)
    return future.result()


def _calls(robot: Robot, client: Any, points: int) -> Iterator[Action]:
    """Every service, with requests that make it work."""
    state = robot.close(robot.reference)
    names, u = list(robot.active), robot.reference.tolist()
    still = [0.0] * len(names)
    joints = JointState(name=names, position=u, velocity=still, effort=still)
    motion = msg.JointMotion(name=names, position=u, velocity=still, acceleration=still)
    target = srv.SolveIK.Request(position_only=True, seed=joints)
    point = target.target.pose.position
    point.x, point.y, point.z = robot.forward_kinematics(state).position.tolist()
    trajectory = JointTrajectory(joint_names=names)
    for second in range(points):
        entry = JointTrajectoryPoint(positions=u, velocities=still)
        entry.time_from_start.sec = second
        trajectory.points.append(entry)
    wants = {
        "solve_fk": (srv.SolveFK, {"active_joints": joints}),
        "solve_ik": (srv.SolveIK, target),
        "inverse_dynamics": (srv.InverseDynamics, {"motion": motion}),
        "forward_dynamics": (srv.ForwardDynamics, {"active_joints": joints}),
        "compute_jacobian": (srv.ComputeJacobian, {"active_joints": joints}),
        "minimal_form": (srv.MinimalForm, {"active_joints": joints}),
        "close_loops": (srv.CloseLoops, {"given": motion}),
        "convert_trajectory": (srv.ConvertTrajectory, {"joints": trajectory}),
        "describe_robot": (srv.DescribeRobot, {}),
        "list_assembly_modes": (srv.ListAssemblyModes, {}),
    }
    for name, (kind, fields) in wants.items():
        request = kind.Request(**fields) if isinstance(fields, dict) else fields
        yield name, _outcome(client, kind, name, request)
    yield "goal of convert_trajectory, cancelled", _goal(client, trajectory)
    for frame in dict.fromkeys(["", *robot.frames]):
        request = srv.SetPayload.Request(frame=frame)
        request.inertia.m = 1.0
        yield f"set_payload at '{frame}'", _outcome(client, srv.SetPayload, "set_payload", request)
    yield from _modes(robot, client)


def _outcome(client: Any, kind: Any, name: str, request: Any) -> Callable[[], str]:
    def act() -> str:
        answer = _call(client, kind, name, request)
        return "no answer" if answer is None else answer.error_text or "ok"

    return act


def _goal(client: Any, trajectory: JointTrajectory) -> Callable[[], str]:
    """A goal that is cancelled after some seconds."""

    def act() -> str:
        conversion = ActionClient(client, ConvertTrajectory, f"{NODE}/convert_trajectory")
        conversion.wait_for_server(PATIENCE)
        sent = conversion.send_goal_async(ConvertTrajectory.Goal(joints=trajectory))
        rclpy.spin_until_future_complete(client, sent, timeout_sec=PATIENCE)
        time.sleep(GOAL)
        ended = sent.result().cancel_goal_async()
        rclpy.spin_until_future_complete(client, ended, timeout_sec=PATIENCE)
        return "ok"

    return act


def _modes(robot: Robot, client: Any) -> Iterator[Action]:
    """A switch to each other assembly mode, and back."""
    modes = [mode.branch for mode in robot.assembly_modes(robot.reference)][:4]
    for branch in modes:
        request = srv.SwitchAssemblyMode.Request(
            loops=list(branch), branches=list(map(str, branch.values()))
        )
        name = "switch_assembly_mode"
        yield (
            f"{name} {' '.join(request.branches)}"[:43],
            _outcome(client, srv.SwitchAssemblyMode, name, request),
        )


def _settings(robot: Robot, client: Any) -> Iterator[Action]:
    """Every parameter that may change at any time, to another value and back."""
    rows = [*TABLE, *sensor_rows(robot.active[0])]
    for row in rows:
        if row.change is not ChangeTime.ANY_TIME:
            continue
        for value in (_other(row, robot), row.default):
            yield f"{row.name} {value}"[:43], _setting(client, row.name, value)


def _other(row: Any, robot: Robot) -> Any:
    """A value that is not the default."""
    if row.kind is str:
        return robot.frames[len(robot.frames) // 2]
    if row.name.endswith(".sign"):
        return -1.0
    if row.length:
        return [0.1] * 3 + [0.0] * (row.length - 3)
    low, high = row.bounds or (0.0, 1.0)
    return row.kind(min(max(2.0 * row.default, low + 1.0), high))


def _setting(client: Any, name: str, value: Any) -> Callable[[], str]:

    given = list(value) if isinstance(value, tuple) else value
    message = Parameter(name, value=given).to_parameter_msg()

    def act() -> str:
        request = SetParameters.Request(parameters=[message])
        (result,) = _call(client, SetParameters, "set_parameters", request).results
        return result.reason or "ok"

    return act


# -- the process that sends and receives


def stream(name: str, rate: float) -> None:
    """Send the state at rest, and print for each answer when it was sent and received [s]."""
    robot = load(name)
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("stream_sender")
    publisher = node.create_publisher(JointState, f"{NODE}/active_joint_states", 100)
    sent: dict[tuple[int, int], float] = {}
    stop: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, _: stop.append(number))

    def receive(message: Any) -> None:
        now = time.monotonic()
        begin = sent.pop((message.header.stamp.sec, message.header.stamp.nanosec), None)
        if begin is not None:
            sys.stdout.write(json.dumps([begin, now]) + "\n")
            sys.stdout.flush()

    node.create_subscription(JointState, f"{NODE}/joint_states", receive, 100)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    message = JointState(name=list(robot.active), position=robot.reference.tolist())
    message.velocity = [0.0] * len(robot.active)
    due = time.monotonic()
    while not stop:
        message.header.stamp = node.get_clock().now().to_msg()
        sent[message.header.stamp.sec, message.header.stamp.nanosec] = time.monotonic()
        publisher.publish(message)
        due += 1.0 / rate
        while (left := due - time.monotonic()) > 0.0:
            executor.spin_once(timeout_sec=left)
    rclpy.shutdown()


if __name__ == "__main__":
    sys.exit(main())
