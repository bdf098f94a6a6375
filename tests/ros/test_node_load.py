"""The running node under load: nothing is lost, nothing leaks, nothing hangs."""

import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from hybrid_dynamics_msgs.msg import ErrorCode, JointMotion
from hybrid_dynamics_msgs.srv import SolveFK, SolveIK
from sensor_msgs.msg import JointState

from tests.sampling import swept

ROOT = Path(__file__).resolve().parents[2]
ACTIVE = ["q1", "q12", "q22", "q4"]
POSITION = [0.0, 0.1, 0.15, 0.0]
FLOODS = "test_floods_are_counted_to_the_last_message_and_the_newest_state_is_answered"


def state(position=POSITION, velocity=(0.0,) * 4):
    return JointState(name=ACTIVE, position=list(position), velocity=list(velocity))


def motion():
    zeros = [0.0] * 4
    return JointMotion(name=ACTIVE, position=POSITION, velocity=zeros, acceleration=zeros)


def far_target():
    request = SolveIK.Request(position_only=True, all_solutions=True)
    request.target.pose.position.x = 100.0
    return request


def benchmark(*words):
    return subprocess.run(
        [sys.executable, "-m", "benchmarks.node", *words],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        timeout=170,
    ).stdout


def test_the_stream_loses_nothing_while_a_target_out_of_reach_is_sought_all_the_time():
    told = benchmark("--alone", "--calls", "--rate", "400", "--seconds", "4", "--rounds", "1")
    lost, sent = re.search(r"lost (\d+) of (\d+)", told).groups()
    answered = int(re.search(r"calls answered meanwhile: (\d+)", told)[1])
    assert (int(lost), answered > 0) == (0, True), told
    assert int(sent) >= 1000, told


def memory(node):
    pages = int(Path(f"/proc/{node.process.pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def test_a_flood_of_calls_is_answered_busy_beyond_the_queue_and_the_node_goes_on(
    start_node, connect
):
    node = start_node("-p", "services.queue:=4")
    client = connect()
    calls = [client.call_async("solve_ik", far_target()) for _ in range(60)]
    begin = time.monotonic()
    while not all(call.done() for call in calls) and time.monotonic() < begin + 100.0:
        stamp = client.new_stamp()
        client.publish("active_joint_states", state(), stamp)
        client.wait_for("joint_states", stamp)  # the stream goes on all the while
        time.sleep(0.02)
    assert all(call.done() for call in calls)
    codes = [call.result().error_code for call in calls]
    assert set(codes) == {ErrorCode.OUT_OF_REACH, ErrorCode.BUSY}
    assert node.stop() == 0


@pytest.mark.sweep(
    sample="test_the_stream_loses_nothing_while_a_target_out_of_reach_is_sought_all_the_time"
)
def test_clients_that_vanish_leave_the_others_their_answers(start_node, connect):
    node = start_node()
    client = connect()
    code = (
        "import os, rclpy; from hybrid_dynamics_msgs.srv import SolveIK; rclpy.init(); n ="
        " rclpy.create_node('gone');c = n.create_client(SolveIK, '/hybrid_dynamics/solve_ik');"
        " c.wait_for_service();q = SolveIK.Request(position_only=True); q.target.pose.position.x ="
        " 100.0;[c.call_async(q) for _ in range(5)]; rclpy.spin_once(n, timeout_sec=0.1);"
        " os._exit(0)"
    )
    for _ in range(3):
        subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
    assert client.call("solve_ik", far_target()).error_code == ErrorCode.OUT_OF_REACH
    assert (
        client.call("solve_fk", SolveFK.Request(active_joints=state())).error_code == ErrorCode.OK
    )
    assert node.stop() == 0
    assert "Traceback" not in node.output()


def test_a_call_that_takes_too_long_is_ended_and_the_next_one_answered(start_node, connect):
    node = start_node()
    client = connect(only=("solve_fk",))
    assert (
        client.call("solve_fk", SolveFK.Request(active_joints=state())).error_code == ErrorCode.OK
    )
    assert client.set_parameter("services.timeout", 0.01) == ""
    client.wait_until(
        lambda: client.call("solve_ik", far_target()).error_code == ErrorCode.TIMEOUT, "a timeout"
    )
    assert client.set_parameter("services.timeout", 60.0) == ""
    assert (
        client.call("solve_fk", SolveFK.Request(active_joints=state())).error_code == ErrorCode.OK
    )
    assert node.stop() == 0


def children(pid):
    """Processes that it has started, and forks of these; not those that have ended."""
    texts = [path.read_text() for path in Path(f"/proc/{pid}/task").glob("*/children")]
    own = {int(word) for text in texts for word in text.split()}
    forks = [children(child) for child in own]
    return {child for child in own.union(*forks) if Path(f"/proc/{child}/exe").exists()}


def workers_of(client, node):
    """The processes that answer its calls, once all are there."""
    client.wait_until(lambda: len(children(node.process.pid)) == 3, "three processes")
    return children(node.process.pid)


def test_calls_are_answered_though_the_process_that_works_on_them_is_killed(start_node, connect):
    """In the middle of a call, and while none waits: no answer changes anything."""
    node = start_node()
    node.wait_for("active joints")
    client = connect(only=("get_state",))
    idle = workers_of(client, node)
    for worker in idle:
        os.kill(worker, signal.SIGKILL)

    def replaced():
        now = children(node.process.pid)
        return len(now) == len(idle) and not now & idle

    client.wait_until(replaced, "new processes, without a call")
    calls = [client.call_async("solve_ik", far_target()) for _ in range(6)]
    client.wait_until(calls[0].done, "the first answer")
    for worker in children(node.process.pid):
        os.kill(worker, signal.SIGKILL)
    client.wait_until(lambda: all(call.done() for call in calls), "all answers", 60.0)
    assert {call.result().error_code for call in calls} == {ErrorCode.OUT_OF_REACH}
    assert node.stop() == 0


def test_a_killed_worker_is_replaced_and_a_killed_node_leaves_no_process(start_node, connect):
    node = start_node()
    client = connect()
    workers = workers_of(client, node)
    for worker in workers:
        os.kill(worker, signal.SIGKILL)
    client.wait_until(
        lambda: (
            client.call("solve_fk", SolveFK.Request(active_joints=state())).error_code
            == ErrorCode.OK
        ),
        "an answer",
    )
    workers = children(node.process.pid)
    node.process.kill()
    node.process.wait()
    client.wait_until(
        lambda: not any(Path(f"/proc/{pid}/exe").exists() for pid in workers),
        "the end of all workers",
    )
    again = start_node()  # after SIGKILL a new one has the same names at once
    again.wait_for("active joints")
    client.connect()
    assert again.stop() == 0


@pytest.mark.parametrize("number", swept([signal.SIGINT, signal.SIGTERM], [signal.SIGINT]))
def test_a_signal_under_load_ends_the_node_cleanly(start_node, connect, number):
    node = start_node()
    client = connect()
    stop = threading.Event()

    def press():
        while not stop.is_set():
            client.publish("active_joint_states", state(), client.new_stamp(0.002))
            time.sleep(0.002)

    presser = threading.Thread(target=press)
    presser.start()
    calls = [client.call_async("solve_ik", far_target()) for _ in range(10)]
    time.sleep(0.5)
    try:
        assert node.stop(number) == 0
    finally:
        stop.set()
        presser.join()
    assert "Traceback" not in node.output()
    assert "stopped: " in node.output()
    assert calls


def test_two_publishers_and_one_that_dies_and_comes_back_are_told_and_survived(start_node, connect):
    node = start_node("-p", "log_period:=0.0")
    client = connect()
    early, late = client.new_stamp(), client.new_stamp(100.0)
    for k in range(20):  # one clock behind the other: rates cannot be told, positions can
        for base in (early, late):
            client.publish("active_joint_states", state(), base + k * 10**7)
    last = late + 19 * 10**7
    client.wait_for("joint_states", last)
    assert "rates are estimated anew: backward stamp" in node.output()
    again = last + 60 * 10**9  # the publisher was away for a minute
    for k in range(10):
        client.publish("active_joint_states", state(), again + k * 10**7)
    client.wait_for("required_efforts", again + 9 * 10**7)
    assert "rates are estimated anew: gap of " in node.output()
    for _ in range(6):
        client.publish("active_joint_states", state(), again + 10**8)
    node.wait_for("stamps stay at")
    assert node.stop() == 0


def test_numbers_at_the_end_of_their_range_never_come_back_as_numbers(start_node, connect):
    node = start_node()
    client = connect()
    for value in (np.nan, np.inf, -np.inf, 1e300, -1e300, 5.0):
        for place in range(4):
            position = list(POSITION)
            position[place] = value
            stamp = client.new_stamp()
            client.publish("active_joint_states", state(position), stamp)
            good = client.new_stamp()
            client.publish("active_joint_states", state(), good)
            client.wait_for("joint_states", good)
            told = client.received("joint_states", stamp)
            if told is not None:  # a slewing angle may be any finite number
                assert place in (0, 3)
                assert np.isfinite(told.position).all()
    assert node.stop() == 0


@pytest.mark.sweep(
    sample="test_a_flood_of_calls_is_answered_busy_beyond_the_queue_and_the_node_goes_on"
)
def test_a_flood_leaves_memory_flat_and_the_last_message_is_answered():
    told = benchmark("--flood", "--seconds", "6")
    early, late = (
        float(x)
        for x in re.search(r"([\d.]+) MB 2 s into the flood, ([\d.]+) MB at", told).groups()
    )
    # Queues fill at first, and stay full. Messages that are kept would be 20 MB and more.
    assert late < early + 8.0, told
    assert "the last message of all: answered" in told, told


def totals(client):
    """Inputs that the newest report counts: received, left out and lost."""
    values = client.values("stream")
    counted = (values[key] for key in ("received", "left out under overload", "lost on the way"))
    return sum(map(int, counted))


def totals_of_now(client):
    """The totals in a report that began after this call: four statuses each."""
    reports = len(client.diagnostics)
    client.wait_until(lambda: len(client.diagnostics) > reports + 8, "reports")
    return totals(client)


def test_floods_are_counted_to_the_last_message_and_the_newest_state_is_answered(
    start_node, connect
):
    """With nothing behind them, as fast as they can be sent: losses must not hang the node."""
    node = start_node("-p", "diagnostics.period:=0.1")
    node.wait_for("active joints")
    client = connect()
    first = client.new_stamp()
    client.publish("active_joint_states", state(), first)
    client.wait_for("joint_states", first)
    sent = totals_of_now(client)
    for _ in range(3):
        end = time.monotonic() + 0.4
        while time.monotonic() < end:
            last = client.new_stamp(1e-4)
            client.publish("active_joint_states", state(), last)
            sent += 1
        client.wait_for("joint_states", last)
        client.wait_until(lambda wanted=sent: totals(client) == wanted, "the count of all")
    assert client.state() == "active"
    assert node.stop() == 0


@pytest.mark.parametrize(
    "profile",
    [
        "latest",
        pytest.param("sensor_data", marks=pytest.mark.sweep(sample=FLOODS)),
    ],
)
def test_losses_of_short_queues_are_counted(start_node, connect, profile):
    """What the middleware threw away, by the numbers of the messages around it."""
    node = start_node("-p", f"qos.input:={profile}", "-p", "diagnostics.period:=0.1")
    node.wait_for("active joints")
    client = connect()
    first = client.new_stamp()
    client.publish("active_joint_states", state(), first)
    client.wait_for("joint_states", first)
    sent = [totals_of_now(client)]
    for _ in range(2000):
        client.publish("active_joint_states", state(), client.new_stamp(1e-4))
        sent[0] += 1

    def all_counted():
        """One more is needed where the last was lost, too."""
        client.publish("active_joint_states", state(), client.new_stamp(1e-4))
        sent[0] += 1
        time.sleep(0.3)
        return totals(client) == sent[0]

    client.wait_until(all_counted, "the count of all")
    assert int(client.values("stream")["lost on the way"]) > 0
    assert node.stop() == 0


def test_an_oversized_message_on_one_topic_costs_the_other_none(start_node, connect):
    node = start_node("-p", "log_period:=0.0")
    node.wait_for("active joints")
    client = connect()
    names = [f"joint_{k}" for k in range(60_000)]
    long = JointState(name=names, position=np.zeros(len(names)).tolist())
    long.velocity = long.effort = long.position
    client.publish("active_joint_states", long, client.new_stamp())
    stamps = [client.new_stamp(0.01) for _ in range(100)]
    for stamp in stamps:
        client.publish("active_joint_motions", motion(), stamp)
    for stamp in stamps:
        client.wait_for("joint_states", stamp)
    node.wait_for("rejected, too long: a message of [0-9]+ bytes, expected 131072 at most")
    assert node.stop() == 0
