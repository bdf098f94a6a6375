"""What the processes do: a sender, a receiver, an echo, and a client of a service."""

from __future__ import annotations

import ctypes
import json
import signal
import struct
import time
from typing import Any

from .topics import ANSWERS, CLOSED_STATE, INPUT, NAMESPACE

DEPTH = 1000  # of sender and receiver: what is lost is lost by the node
STAMP = struct.Struct("<iI")  # of a header in CDR, behind four bytes that name the encoding
QUIET = 2.0  # [s] without a message: nothing more will come
SET_TIMER_SLACK = 29  # of prctl


def echo(_settings: dict[str, Any]) -> None:
    """A node that sends each JointState on as three."""
    import rclpy
    from rclpy.signals import SignalHandlerOptions
    from sensor_msgs.msg import JointState

    from hybrid_dynamics_ros.node.executor import make_executor

    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node("echo")
    publishers = [node.create_publisher(JointState, topic, DEPTH) for topic in ANSWERS]

    def on_state(message: JointState) -> None:
        for publisher in publishers:
            publisher.publish(message)

    node.create_subscription(JointState, INPUT, on_state, 200)
    executor = make_executor()
    executor.add_node(node)
    stop: list[int] = []
    signal.signal(signal.SIGINT, lambda number, _: stop.append(number))
    while not stop:
        executor.spin_once(timeout_sec=0.5)


def send(settings: dict[str, Any]) -> None:
    """Publish states of a moving robot; print the stamps [ns]."""
    import rclpy
    from rclpy.serialization import serialize_message
    from sensor_msgs.msg import JointState

    from hybrid_dynamics_core import load

    robot = load(settings["robot"])
    zero = [0.0] * len(robot.active)
    message = JointState(name=list(robot.active), position=robot.reference.tolist(), velocity=zero)
    data = bytearray(serialize_message(message))
    rclpy.init()
    node = rclpy.create_node("sender")
    publisher = node.create_publisher(JointState, INPUT, DEPTH)
    while not (publisher.get_subscription_count() and all(map(node.count_subscribers, ANSWERS))):
        time.sleep(0.05)
    time.sleep(2.0)
    _precise_sleep()
    stamps = []
    due = time.perf_counter()
    for rate, seconds in settings["plan"]:
        for _ in range(round(rate * seconds)):
            due += 1.0 / rate
            pause = due - time.perf_counter()
            if pause > 0.0:
                time.sleep(pause)
            now = time.time_ns()
            STAMP.pack_into(data, 4, *divmod(now, 10**9))
            publisher.publish(bytes(data))
            stamps.append(now)
    time.sleep(QUIET)
    print(json.dumps({"stamps": stamps}))
    rclpy.shutdown()


def receive(settings: dict[str, Any]) -> None:
    """Note when the answers to each stamp came; print them once all is quiet."""
    import rclpy
    from hybrid_dynamics_msgs.msg import ClosedState
    from sensor_msgs.msg import JointState

    from hybrid_dynamics_ros.node.executor import make_executor

    rclpy.init()
    node = rclpy.create_node("receiver")
    arrivals: dict[int, list[int]] = {}
    latest = time.monotonic()

    def note(data: bytes) -> None:
        nonlocal latest
        seconds, nanoseconds = STAMP.unpack_from(data, 4)
        arrivals.setdefault(seconds * 10**9 + nanoseconds, []).append(time.time_ns())
        latest = time.monotonic()

    for topic in ANSWERS:
        kind = JointState
        if topic == CLOSED_STATE and not settings["echoed"]:
            kind = ClosedState
        node.create_subscription(kind, topic, note, DEPTH, raw=True)
    executor = make_executor()
    executor.add_node(node)
    while not arrivals or time.monotonic() < latest + QUIET:
        executor.spin_once(timeout_sec=0.2)
    print(json.dumps(arrivals))


def call(_settings: dict[str, Any]) -> None:
    """Ask for a target out of reach all the time; print how often it was answered."""
    import rclpy
    from hybrid_dynamics_msgs.srv import SolveIK
    from rclpy.signals import SignalHandlerOptions

    from hybrid_dynamics_ros.node.executor import make_executor

    stop: list[int] = []
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    signal.signal(signal.SIGINT, lambda number, _: stop.append(number))
    node = rclpy.create_node("caller")
    client = node.create_client(SolveIK, f"{NAMESPACE}/solve_ik")
    executor = make_executor()
    executor.add_node(node)
    client.wait_for_service()
    request = SolveIK.Request(position_only=True, all_solutions=True)
    request.target.pose.position.x = 100.0
    answered = 0
    future = client.call_async(request)
    while not stop:
        executor.spin_once(timeout_sec=0.2)
        if future.done():
            answered += 1
            future = client.call_async(request)
    print(answered)


def _precise_sleep() -> None:
    """Let sleeps end within microseconds: Linux rounds them up by 50 us unless asked not to."""
    ctypes.CDLL(None).prctl(SET_TIMER_SLACK, 1, 0, 0, 0)
