"""Every message is counted once: answered, refused, joined, left out or lost, to the very end."""

import re
import signal
import threading
import time

import pytest
from hybrid_dynamics_msgs.msg import JointMotion
from rclpy.duration import Duration
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState

from tests.sampling import swept

NAMES = ["q1", "q12", "q22", "q4"]
POSITION = [0.0, 0.1, 0.15, 0.0]
REFUSED = ([float("nan"), 0.1, 0.15, 0.0], [0.0, 9.0, 0.15, 0.0], [0.0])
KEYS = ("received", "left out under overload", "left out while not active", "lost on the way")
STATES, MOTIONS = "active_joint_states", "active_joint_motions"


def motion():
    zeros = [0.0] * 4
    return JointMotion(name=NAMES, position=POSITION, velocity=zeros, acceleration=zeros)


def number_before(words, text):
    """The sum of the numbers that stand before some words."""
    return sum(int(found) for found in re.findall(rf"(\d+) {words}", text))


def counted(client):
    """All messages that a report counts which began after this call: four statuses each."""
    reports = len(client.diagnostics)
    client.wait_until(lambda: len(client.diagnostics) > reports + 8, "reports")
    values = client.values("stream")
    return sum(int(values[key]) for key in KEYS)


def connected(node, connect):
    """A client whose messages reach the node, and how many the node has counted so far."""
    node.wait_for("active joints")
    client = connect()
    first = client.new_stamp()
    client.publish(STATES, JointState(name=NAMES, position=POSITION), first)
    client.wait_for("joint_states", first)
    return client, counted(client)


def press(client, count):
    """Send messages of all kinds as fast as possible on two topics; their number."""
    for k in range(count):
        if k % 7 == 0:
            client.publish(MOTIONS, motion(), client.new_stamp(1e-3))
            continue
        position = POSITION if k % 3 else REFUSED[k % len(REFUSED)]
        state = JointState(name=NAMES, position=position)
        if k % 11 == 0:
            state = JointState(name=[], position=[])
        client.publish(STATES, state, client.new_stamp(1e-3))
    return count


def press_slow(client, count):
    """Send messages that the node takes longer to read than they to arrive; their number."""
    names = [f"joint_{k}" for k in range(4000)]
    slow = serialize_message(JointState(name=names, position=[0.0] * len(names)))
    for _ in range(count):
        client.publish_as_it_is(STATES, slow)
    return count


def all_arrived(client):
    """Wait until the middleware of the node has taken all."""
    for topic in (STATES, MOTIONS):
        assert client._publishers[topic].wait_for_all_acked(Duration(seconds=60))


@pytest.mark.parametrize("number", swept([signal.SIGINT, signal.SIGTERM], [signal.SIGINT]))
def test_all_that_came_is_in_the_last_line_of_a_node_that_a_signal_stops_in_a_flood(
    start_node, connect, number
):
    node = start_node("-p", "diagnostics.period:=0.1")
    client, sent = connected(node, connect)
    sent += press(client, 3000) + press_slow(client, 400)
    all_arrived(client)
    assert node.stop(number) == 0  # with a queue full of them
    line = node.wait_for("stopped: .*")[0]
    outside = ("left out under overload", "left out while not active", "lost on the way")
    assert sum(number_before(what, line) for what in ("received", *outside)) == sent, line
    parts = ("accepted", "rejected", "with some joints")
    assert sum(number_before(part, line) for part in parts) == number_before("received", line)
    assert number_before("rejected", line) > 0, line


def test_transitions_and_parameters_in_the_middle_of_a_stream_cost_no_message_its_place(
    start_node, connect
):
    node = start_node("-p", "diagnostics.period:=0.1")
    client, sent = connected(node, connect)
    is_over = threading.Event()

    def disturb():
        while not is_over.is_set():
            for transition in ("deactivate", "activate"):
                client.change(transition)
            client.set_parameter("payload.mass", 5.0)
            client.set_parameter("payload.mass", 0.0)

    thread = threading.Thread(target=disturb)
    thread.start()
    for _ in range(15):
        sent += press(client, 200)
        time.sleep(0.1)
    is_over.set()
    thread.join()
    client.wait_until(lambda: counted(client) == sent, "the count of all")
    assert int(client.values("stream")["left out while not active"]) > 0
    assert node.stop() == 0


def test_as_many_answers_come_as_the_node_says_it_gave(start_node, connect):
    node = start_node("-p", "diagnostics.period:=0.1")
    client, sent = connected(node, connect)
    before = number_before("accepted", client.values("stream")["counts"])
    answers = client._received["joint_states"]
    first = len(answers)
    for _ in range(20):  # shorter than the queue of the client
        sent += press(client, 60)
        client.wait_until(lambda wanted=sent: counted(client) == wanted, "the count of all")
    accepted = number_before("accepted", client.values("stream")["counts"]) - before
    client.wait_until(lambda: len(answers) - first == accepted, "all answers")
    assert accepted > 0
    assert node.stop() == 0
