"""Latency and losses of the node, beside a node that only echoes JointState on three topics with the same executor.

python -m benchmarks.node [--rate 1000] [--seconds 10] [--rounds 3] [--robot forging_chu2020]
                          [--calls] [--flood] [--soak SECONDS]

Three processes: a sender, the node (or the echo), a receiver. Sender and receiver handle serialised
messages, so that
they cost little. The latency of an input runs from before it is published until the last of its
three answers is there.
  --alone  leaves the echo node out
  --calls  asks for inverse kinematics out of reach all the time, from a fourth process
  --flood  10000 messages a second for the time given, then 200 a second: when is the latency as it
  was before?
  --soak   one robot at 200 Hz for so long: latency and memory of the node by tenths of the time,
  and latency of an echo
"""

from __future__ import annotations

import argparse
import ctypes
import json
import os
import signal
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

# Before ROS is imported: a graph of its own.
os.environ.setdefault("ROS_DOMAIN_ID", "93")
os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
os.environ.setdefault("AMENT_PREFIX_PATH", sys.prefix)
NAMESPACE = "/hybrid_dynamics"
INPUT = f"{NAMESPACE}/active_joint_states"
ANSWERS = tuple(
    f"{NAMESPACE}/{topic}" for topic in ("joint_states", "required_efforts", "closed_state")
)
DEPTH = 1000  # of sender and receiver: what is lost is lost by the node
STAMP = struct.Struct("<iI")  # of a header in CDR, behind four bytes that tell the encoding
QUIET = 2.0  # [s] without a message: nothing more will come
WARM_UP = 1.0  # [s] that is not counted


def main() -> None:
    """Measure what is asked for; print it."""
    options = _options()
    if options.part:
        {"echo": echo, "send": send, "receive": receive, "call": call}[options.part](
            json.loads(options.settings)
        )
        return
    print(
        f"{options.robot}, {options.seconds:g} s, {os.cpu_count()} processors, load"
        f" {os.getloadavg()[0]:.1f}"
    )
    if options.soak:
        soak(options)
        return
    if options.flood:
        flood(options)
        return
    compare(options)


def compare(options: argparse.Namespace) -> None:
    """Echo and node, round after round; how many times the echo's latency the node's is."""
    ratios = []
    for _ in range(options.rounds):
        latency = {}
        for what in ("node",) if options.alone else ("echo", "node"):
            with (
                _subject(what, options.robot) as process,
                _caller(options.calls and what == "node"),
            ):
                used = _cpu(process.pid)
                found = _measure(
                    options.robot, [(options.rate, options.seconds)], echoed=what == "echo"
                )
                busy = (_cpu(process.pid) - used) / options.seconds
            latency[what] = np.percentile(found["latency"], (50.0, 99.0))
            line = _line(found, options.rate * (options.seconds - WARM_UP))
            print(f"{what:5s} {line}  processor {100 * busy:.0f} %", flush=True)
        if not options.alone:
            ratios.append(latency["node"] / latency["echo"])
    if ratios:
        middle, late = np.median(ratios, axis=0)
        print(
            f"node in times of echo, median of {len(ratios)} rounds: {middle:.2f} (median),"
            f" {late:.2f} (99 %)"
        )


def flood(options: argparse.Namespace) -> None:
    """Latency before, memory during and latency after a flood."""
    plan = [(200.0, 5.0), (10000.0, options.seconds), (200.0, 5.0)]
    with _subject("node", options.robot) as process:
        over, sizes = threading.Event(), [(time.time(), _memory(process.pid))]

        def watch() -> None:
            while not over.wait(0.25):
                sizes.append((time.time(), _memory(process.pid)))

        watcher = threading.Thread(target=watch)
        watcher.start()
        found = _measure(options.robot, plan)
        over.set()
        watcher.join()
    sent = np.array(found["sent"])
    latency, stamp = np.array(found["latency"]), np.array(found["stamp"]) * 1e-9
    ends = np.cumsum([seconds for _, seconds in plan]) + found["begin"]
    usual = np.percentile(latency[stamp < ends[0]], 99)
    late = stamp[(stamp > ends[1]) & (latency > 2.0 * usual)]
    recovery = max(0.0, float(late.max() - ends[1])) if late.size else 0.0
    last = stamp[(stamp > ends[0]) & (stamp < ends[1])]
    print(f"sent {sent.size}, answered {latency.size}, of them in the flood {last.size}")
    print(
        f"usual latency, 99 %: {1e3 * usual:.2f} ms; as usual again {1e3 * recovery:.0f} ms after"
        " the flood"
    )
    early, late = (
        next(size for when, size in sizes if when >= at) for at in (ends[0] + 2.0, ends[1])
    )
    print(
        f"memory of the node {sizes[0][1]:.1f} MB before, {early:.1f} MB 2 s into the flood,"
        f" {late:.1f} MB at its end"
    )


def soak(options: argparse.Namespace) -> None:
    """Latency and memory over a long time; for a tenth of it those of an echo in a graph of its own."""
    print("  part   median ms   99 % ms   lost   memory MB   echo's median ms   times")
    aside = {"ROS_DOMAIN_ID": str(int(os.environ["ROS_DOMAIN_ID"]) + 1)}
    with _subject("node", options.robot) as process, _subject("echo", options.robot, aside):
        for part in range(10):
            seconds = options.soak / 10.0
            found = _measure(options.robot, [(200.0, 0.9 * seconds)])
            short = [(200.0, max(0.1 * seconds, 2.0 * WARM_UP))]
            floor = _measure(options.robot, short, echoed=True, environment=aside)
            middle, late = 1e3 * np.percentile(found["latency"], (50.0, 99.0))
            least = 1e3 * float(np.median(floor["latency"]))
            lost = len(found["sent"]) - len(found["latency"])
            told = (
                f"{part + 1:4d}   {middle:9.3f}   {late:7.3f}   {lost:4d}  "
                f" {_memory(process.pid):9.1f}"
            )
            print(f"  {told}   {least:16.3f}   {middle / least:5.2f}", flush=True)


def _measure(
    robot: str,
    plan: list[tuple[float, float]],
    *,
    echoed: bool = False,
    environment: Mapping[str, str] = MappingProxyType({}),
) -> dict[str, Any]:
    """What was sent and what came back; plan: rate [Hz] and seconds, one after the other."""
    settings = {"robot": robot, "plan": plan, "echoed": echoed}
    receiver = _start("receive", settings, environment)
    sender = _start("send", settings, environment)
    sent, received = (
        json.loads(process.communicate()[0].splitlines()[-1]) for process in (sender, receiver)
    )
    counted = np.array(sent["stamps"])
    first = counted[0] + WARM_UP * 1e9
    arrivals = {int(stamp): times for stamp, times in received.items() if int(stamp) >= first}
    whole = {stamp: times[-1] for stamp, times in arrivals.items() if len(times) == len(ANSWERS)}
    latency = [(end - stamp) * 1e-9 for stamp, end in whole.items()]
    return {
        "sent": counted[counted >= first].tolist(),
        "latency": latency,
        "stamp": list(whole),
        "begin": counted[0] * 1e-9,
    }


def _line(found: dict[str, Any], wanted: float) -> str:
    middle, late, last = 1e3 * np.percentile(found["latency"], (50.0, 99.0, 100.0))
    sent = len(found["sent"])
    lost = sent - len(found["latency"])
    text = f"median {middle:.3f} ms  99 % {late:.3f} ms  most {last:.1f} ms  lost {lost} of {sent}"
    return text if sent > 0.9 * wanted else text + " (the sender was too slow)"


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rate", type=float, default=1000.0)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--robot", default="forging_chu2020")
    parser.add_argument("--calls", action="store_true")
    parser.add_argument("--alone", action="store_true", help="without the echo node")
    parser.add_argument("--flood", action="store_true")
    parser.add_argument("--soak", type=float)
    parser.add_argument("--part", help=argparse.SUPPRESS)
    parser.add_argument("--settings", default="{}", help=argparse.SUPPRESS)
    return parser.parse_args()


# -- processes


def _start(
    part: str, settings: dict[str, Any], environment: Mapping[str, str] = MappingProxyType({})
) -> subprocess.Popen[str]:
    command = [
        sys.executable,
        "-m",
        "benchmarks.node",
        "--part",
        part,
        "--settings",
        json.dumps(settings),
    ]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, text=True, env={**os.environ, **environment}
    )


@contextmanager
def _subject(
    what: str, robot: str, environment: Mapping[str, str] = MappingProxyType({})
) -> Iterator[subprocess.Popen[str]]:
    if what == "echo":
        process = _start("echo", {}, environment)
    else:
        words = [*("--ros-args", "-p", f"robot:={robot}"), "--log-level", "error"]
        process = subprocess.Popen(
            [sys.executable, "-m", "hybrid_dynamics_ros.node", *words], text=True
        )
    try:
        time.sleep(6.0)  # until it is up, workers too
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(20.0)


@contextmanager
def _caller(wanted: bool) -> Iterator[None]:
    process = _start("call", {}) if wanted else None
    try:
        yield
    finally:
        if process is not None:
            process.send_signal(signal.SIGINT)
            print(
                f"  calls answered meanwhile: {(process.communicate()[0].split() or ['none'])[-1]}"
            )


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
            left = due - time.perf_counter()
            if left > 0.0:
                time.sleep(left)
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
    last = [time.monotonic()]

    def note(data: bytes) -> None:
        seconds, nanoseconds = STAMP.unpack_from(data, 4)
        arrivals.setdefault(seconds * 10**9 + nanoseconds, []).append(time.time_ns())
        last[0] = time.monotonic()

    for topic in ANSWERS:
        kind = (
            ClosedState if topic.endswith("closed_state") and not settings["echoed"] else JointState
        )
        node.create_subscription(kind, topic, note, DEPTH, raw=True)
    executor = make_executor()
    executor.add_node(node)
    while not arrivals or time.monotonic() < last[0] + QUIET:
        executor.spin_once(timeout_sec=0.2)
    print(json.dumps(arrivals))


def call(_settings: dict[str, Any]) -> None:
    """Ask for a target out of reach again and again; print how often it was answered."""
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


# -- what the system tells


def _memory(pid: int) -> float:
    """Resident memory of a process [MB]."""
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def _cpu(pid: int) -> float:
    """Processor time of a process so far [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _precise_sleep() -> None:
    """Let sleeps end within microseconds: Linux rounds them up by 50 us unless asked not to."""
    ctypes.CDLL(None).prctl(29, 1, 0, 0, 0)  # PR_SET_TIMERSLACK


if __name__ == "__main__":
    main()
