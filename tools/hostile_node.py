"""Floods, hostile messages, calls and transitions against a node of its own, run by hand.

python tools/hostile_node.py            floods and the hostile set
python tools/hostile_node.py --soak 3600    an hour at 1 kHz, all services called
"""

from __future__ import annotations

import argparse
import itertools
import math
import os
import re
import signal
import struct
import subprocess
import sys
import time
from collections.abc import Callable, Hashable, Iterator
from pathlib import Path
from typing import Any, Final

os.environ.setdefault("AMENT_PREFIX_PATH", sys.prefix)
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from hybrid_dynamics_msgs import srv
from hybrid_dynamics_msgs.msg import JointMotion
from lifecycle_msgs.srv import ChangeState, GetState
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from hybrid_dynamics_ros.node.executor import make_executor
from hybrid_dynamics_ros.services.table import TABLE
from hybrid_dynamics_ros.stream.sequence_gaps import SequenceGaps

_NODE: Final = "/hybrid_dynamics"
_NAMES: Final = ["q1", "q12", "q22", "q4"]
_POSITION: Final = [0.0, 0.1, 0.15, 0.0]
_RECEIVED, _LOST = "received", "lost on the way"
_KEYS: Final = (_RECEIVED, "left out under overload", "left out while not active", _LOST)
_PARTS: Final = re.compile(r"(\d+) (accepted|with some joints|rejected)")  # of received
_STAMP: Final = struct.Struct("<iI")  # of a header in CDR, behind four bytes that name the encoding
_CALL_EVERY: Final = 20  # states
_PATIENCE: Final = 60.0  # [s] for an answer


class Attacker:
    """A node that sends, calls and counts."""

    def __init__(self) -> None:
        self.node = rclpy.create_node("attacker")
        self._executor = make_executor()
        self._executor.add_node(self.node)
        self.values: dict[str, str] = {}
        self.reports = 0
        self.sent = 0
        self.answered = 0
        self.waiting: set[int] = set()  # stamps of states without an answer
        queue = QoSProfile(depth=1000)
        self._states = self.node.create_publisher(JointState, f"{_NODE}/active_joint_states", queue)
        self._answers = self.node.create_subscription(
            JointState, f"{_NODE}/joint_states", self._on_answer, queue, raw=True
        )
        # By its signature the callback would get the message alone.
        self._answers._callback_type = Subscription.CallbackType.WithMessageInfo  # noqa: SLF001
        self.gaps = SequenceGaps(self._answering)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._on_report, 10)
        kinds = {service.name: service.kind for service in TABLE}
        kinds |= {"get_state": GetState, "change_state": ChangeState}
        self.clients = {
            name: self.node.create_client(kind, f"{_NODE}/{name}", qos_profile=queue)
            for name, kind in kinds.items()
        }

    def spin(self, seconds: float) -> None:
        """Do what waits, or wait for it so long."""
        self._executor.spin_once(timeout_sec=seconds)

    def _answering(self) -> frozenset[Hashable]:
        """Who publishes answers."""
        endpoints = self.node.get_publishers_info_by_topic(f"{_NODE}/joint_states")
        return frozenset(bytes(endpoint.endpoint_gid) for endpoint in endpoints)

    def _on_answer(self, *taken: Any) -> None:
        # The events executor gives message and information as one argument, others as two.
        message, information = taken[0] if len(taken) == 1 else taken
        self.gaps.note(information["publication_sequence_number"])
        seconds, nanoseconds = _STAMP.unpack_from(message, 4)
        self.waiting.discard(seconds * 10**9 + nanoseconds)
        self.answered += 1

    def _on_report(self, report: DiagnosticArray) -> None:
        for status in report.status:
            if status.name.endswith(": stream"):
                self.values = {entry.key: entry.value for entry in status.values}
                self.reports += 1

    def send(self, **fields: Any) -> int:
        """Publish a state; its stamp [ns]."""
        now = time.time_ns()
        message = JointState(**{"name": _NAMES, "position": _POSITION, **fields})
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(now, 10**9)
        self.waiting.add(now)
        self._states.publish(message)
        self.sent += 1
        return now

    def wait(self, condition: Callable[[], bool], seconds: float = _PATIENCE) -> bool:
        """Spin until the condition holds; whether it does."""
        end = time.monotonic() + seconds
        while not condition() and time.monotonic() < end:
            self.spin(0.02)
        return condition()

    def answers(self) -> bool:
        """Whether the node answers a new state and a call."""
        future = self.clients["get_state"].call_async(GetState.Request())
        stamp = self.send()
        return self.wait(lambda: bool(future.done() and stamp not in self.waiting))

    @property
    def is_connected(self) -> bool:
        """Whether states reach the node, and answers this tool.

        A state that is sent before reaches nobody, and nobody can count it.
        """
        has_ends = self._states.get_subscription_count() and self._answers.get_publisher_count()
        return bool(has_ends and self.values)

    def numbers(self) -> dict[str, int]:
        """What the newest report of the node counts: all states, and parts of those received."""
        numbers = {key: int(self.values.get(key, "0")) for key in _KEYS}
        parts = {"accepted": 0, "with some joints": 0, "rejected": 0}
        for number, part in _PARTS.findall(self.values.get("counts", "")):
            parts[part] += int(number)
        return numbers | parts

    def counted(self) -> str:
        """What the node says of the states so far, and whether each is counted once."""
        begin = self.reports
        self.wait(lambda: self.reports > begin + 1)  # the first may have begun before
        numbers = self.numbers()
        total = sum(numbers[key] for key in _KEYS)
        parts = sum(numbers.values()) - total
        answers = self.answered + self.gaps.lost
        is_exact = (total, parts, answers) == (
            self.sent,
            numbers[_RECEIVED],
            numbers["accepted"],
        )
        return (
            f"sent {self.sent}, counted {total}, answers {self.answered}, lost by this tool"
            f" {self.gaps.lost}, of the node {numbers}; exact {is_exact}"
        )


def flood(attacker: Attacker) -> None:
    """As fast as possible for 3 s; the newest has to be answered with nothing behind it."""
    end = time.monotonic() + 3.0
    last = 0
    while time.monotonic() < end:
        last = attacker.send()
    is_newest = attacker.wait(lambda: last not in attacker.waiting)
    print(f"flood of 3 s: newest answered {is_newest}, {attacker.counted()}", flush=True)


def bad_states() -> Iterator[dict[str, Any]]:
    """States of every bad kind, again and again."""
    nan, large = float("nan"), 1e300
    kinds: list[dict[str, Any]] = [
        {"name": []},
        {"name": _NAMES[:2], "position": [0.0]},
        {"name": [*_NAMES[:3], "q1"]},
        {"name": ["a", "b", "c", "d"]},
        {"position": [nan, 0.1, 0.15, 0.0]},
        {"position": [large, 0.1, 0.15, 0.0]},
        {"velocity": [float("inf")] * 4},
        {"velocity": [0.0]},
        {"position": [0.0, 9.0, 0.15, 0.0]},
        {"name": ["x" * 300_000]},
    ]
    return itertools.cycle(kinds)


def hostile(attacker: Attacker) -> None:
    """10,000 bad messages, 2,000 empty calls and 60 transitions."""
    services = itertools.cycle(service.name for service in TABLE)
    transitions = itertools.cycle(("deactivate", "cleanup", "configure", "activate"))
    futures = []
    for count, fields in enumerate(itertools.islice(bad_states(), 10_000)):
        attacker.send(**fields)
        if count % 5 == 0:
            client = attacker.clients[next(services)]
            futures.append(client.call_async(client.srv_type.Request()))
        attacker.spin(0.0)
    is_done = attacker.wait(lambda: all(future.done() for future in futures), 300.0)
    done = sum(future.done() for future in futures)
    print(f"calls: {done} of {len(futures)} answered, all: {is_done}", flush=True)
    changed = 0
    for _ in range(60):
        request = ChangeState.Request()
        request.transition.label = next(transitions)
        future = attacker.clients["change_state"].call_async(request)
        changed += attacker.wait(future.done) and future.result().success
    print(f"transitions: {changed} of 60 done", flush=True)


def usual_requests() -> dict[str, Any]:
    """A call of each service that does its work; of the others an empty one."""
    state = JointState(name=_NAMES, position=_POSITION)
    still = JointState(name=_NAMES, position=_POSITION, velocity=[0.0] * 4, effort=[0.0] * 4)
    motion = JointMotion(name=_NAMES, position=_POSITION, velocity=[0.0] * 4)
    motion.acceleration = [0.0] * 4
    target = srv.SolveIK.Request(position_only=True, seed=state)
    place = target.target.pose.position
    place.x, place.y, place.z = 0.3226478557853928, 0.38451674127506036, 1.1179125884719605
    joints = JointTrajectory(joint_names=_NAMES)
    for second in range(3):
        point = JointTrajectoryPoint(positions=[0.1 * second, *_POSITION[1:]])
        point.time_from_start.sec = second
        joints.points.append(point)
    return {
        "solve_fk": srv.SolveFK.Request(active_joints=state),
        "solve_ik": target,
        "inverse_dynamics": srv.InverseDynamics.Request(motion=motion),
        "forward_dynamics": srv.ForwardDynamics.Request(active_joints=still),
        "compute_jacobian": srv.ComputeJacobian.Request(active_joints=state),
        "minimal_form": srv.MinimalForm.Request(active_joints=still),
        "close_loops": srv.CloseLoops.Request(given=motion, near=state),
        "list_assembly_modes": srv.ListAssemblyModes.Request(active_joints=state),
        "convert_trajectory": srv.ConvertTrajectory.Request(joints=joints),
    }


def memory(process: int) -> float:
    """Resident memory of a process [MB]."""
    text = Path(f"/proc/{process}/status").read_text()
    line = next(line for line in text.splitlines() if line.startswith("VmRSS"))
    return int(line.split()[1]) / 1024.0


class Calls:
    """All services, one call after the other, each as it should be and then empty."""

    def __init__(self, attacker: Attacker) -> None:
        self.made = 0
        self.answered = 0
        self.good: set[str] = set()
        self._attacker = attacker
        self._name = ""
        self._future: Any = None
        self._order = itertools.cycle(self._requests())

    def _requests(self) -> list[tuple[str, Any]]:
        usual = usual_requests()
        requests = []
        for service in TABLE:
            empty = service.kind.Request()
            requests += [(service.name, usual.get(service.name, empty)), (service.name, empty)]
        return requests

    def step(self) -> None:
        """Make the next call, if the last one is answered."""
        if self._future is not None:
            if not self._future.done():
                return
            self.answered += 1
            if not self._future.result().error_code:
                self.good.add(self._name)
        self._name, request = next(self._order)
        self._future = self._attacker.clients[self._name].call_async(request)
        self.made += 1


def soak(attacker: Attacker, seconds: float, process: int) -> None:
    """States of a moving robot at 1 kHz, all services called one after the other."""
    calls = Calls(attacker)
    begin = time.monotonic()
    count = 0

    def report() -> None:
        print(
            f"{time.monotonic() - begin:.0f} s: sent {attacker.sent}, answers {attacker.answered}, "
            f"lost by this tool {attacker.gaps.lost}, {attacker.numbers()}, calls {calls.made}, "
            f"answered {calls.answered}, with success {len(calls.good)} of {len(TABLE)} kinds, "
            f"memory {memory(process):.1f} MB, load {os.getloadavg()[0]:.1f}",
            flush=True,
        )

    while time.monotonic() < begin + seconds:
        count += 1
        turn = 0.3 * math.sin(1e-3 * count)
        attacker.send(position=[turn, *_POSITION[1:]])
        if count % _CALL_EVERY == 0:
            calls.step()
        due = begin + 1e-3 * count
        attacker.spin(max(0.0, due - time.monotonic()))
        while time.monotonic() < due:
            attacker.spin(max(0.0, due - time.monotonic()))
        if count % 60_000 == 0:
            report()
    attacker.wait(lambda: not attacker.waiting, 5.0)
    print(attacker.counted(), flush=True)
    report()


def main() -> None:
    """Start a node, and do what was asked."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--soak", type=float, default=0.0, metavar="SECONDS")
    options = parser.parse_args()
    process = subprocess.Popen([sys.executable, "-m", "hybrid_dynamics_ros.node"])
    rclpy.init()
    attacker = Attacker()
    try:
        attacker.wait(attacker.clients["get_state"].service_is_ready)
        attacker.wait(lambda: attacker.is_connected)
        attacker.wait(attacker.answers, 120.0)
        if options.soak:
            soak(attacker, options.soak, process.pid)
        else:
            for _ in range(3):
                flood(attacker)
            hostile(attacker)
        print(f"the node still answers: {attacker.answers()}", flush=True)
    finally:
        process.send_signal(signal.SIGINT)
        print(f"exit code {process.wait(60.0)}")


if __name__ == "__main__":
    main()
