"""The player: a process that publishes the messages of a recording at their times.

python -m hybrid_dynamics_ros.demo.play.player BAG [--rate R] [--subscribers N]
"""

from __future__ import annotations

import argparse
import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final

import rclpy
from rclpy.duration import Duration
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, QoSReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import try_shutdown
from sensor_msgs.msg import JointState

from ...bags.storage.bag_reader import read_raw
from ...bags.storage.storage import RawMessage
from ..topics import INPUT

MATCH_DEADLINE: Final = 120.0  # [s]
ACKNOWLEDGE_DEADLINE: Final = 30.0  # [s]


def main(arguments: Sequence[str] | None = None) -> int:
    """Play a recording once, and print the number of messages sent.

    Args:
        arguments: arguments of the command; None: those of the process.

    Returns:
        The exit code of the process.
    """
    parser = argparse.ArgumentParser(
        prog="python -m hybrid_dynamics_ros.demo.play.player", description=__doc__
    )
    parser.add_argument("bag", type=Path, help="rosbag2 recording")
    parser.add_argument(
        "--rate", type=float, default=1.0, help="how much faster than recorded (default 1)"
    )
    parser.add_argument(
        "--subscribers", type=int, default=1, help="wait for so many before sending (default 1)"
    )
    options = parser.parse_args(arguments)

    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    messages = read_raw(options.bag, INPUT)
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    try:
        return _run(messages, options.rate, options.subscribers, stop)
    finally:
        try_shutdown()


def _run(
    messages: Sequence[RawMessage], rate: float, subscribers: int, stop: threading.Event
) -> int:
    node = rclpy.create_node("player", enable_rosout=False, start_parameter_services=False)
    # The queue holds all messages, for subscribers that fall behind.
    qos = QoSProfile(depth=max(1, len(messages)), reliability=QoSReliabilityPolicy.RELIABLE)
    publisher = node.create_publisher(JointState, INPUT, qos)
    try:
        if not wait_for_subscribers(publisher, subscribers, stop):
            count = publisher.get_subscription_count()
            sys.stderr.write(f"{count} of {subscribers} subscribers of {INPUT} came\n")
            return 1
        sent = play(messages, publisher.publish, rate, stop)
        sys.stdout.write(f"{sent} of {len(messages)} messages sent\n")
        if not wait_for_acknowledgements(publisher, stop):
            sys.stderr.write("not every message was acknowledged\n")
            return 1
        return 0 if sent == len(messages) else 1
    finally:
        node.destroy_node()


def wait_for_subscribers(publisher: Publisher, count: int, stop: threading.Event) -> bool:
    """Wait until `count` subscriptions are matched.

    Later messages reach all of them. Returns False after a timeout, or if `stop` is set.
    """
    end = time.monotonic() + MATCH_DEADLINE
    while publisher.get_subscription_count() < count:
        if time.monotonic() > end or stop.wait(0.01):
            return False
    return True


def wait_for_acknowledgements(publisher: Publisher, stop: threading.Event) -> bool:
    """Wait until every subscriber has acknowledged every message, or until `stop` is set.

    Returns False after a timeout. Acknowledgements may take a few seconds, so `stop` may be set
    earlier when all messages are known to have arrived.
    """
    end = time.monotonic() + ACKNOWLEDGE_DEADLINE
    while not stop.is_set() and not publisher.wait_for_all_acked(Duration(seconds=0.05)):
        if time.monotonic() > end:
            return False
    return True


def play(
    messages: Sequence[RawMessage],
    publish: Callable[[bytes], None],
    rate: float,
    stop: threading.Event,
) -> int:
    """Publish each message at its time; returns the number sent before `stop` was set.

    Args:
        messages: the messages, in the order of log times.
        publish: publishes the bytes of a message.
        rate: recorded time over real time.
        stop: event that ends it early.
    """
    start = time.monotonic()
    for sent, message in enumerate(messages):
        due = start + (message.log_ns - messages[0].log_ns) * 1e-9 / rate
        if stop.wait(max(0.0, due - time.monotonic())):
            return sent
        publish(message.data)
    return len(messages)


if __name__ == "__main__":
    sys.exit(main())
