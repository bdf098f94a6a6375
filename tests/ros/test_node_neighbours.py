"""A node that is not alone: a reader that is stopped, and a second robot on /tf."""

import json
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from sensor_msgs.msg import JointState

from hybrid_dynamics_ros.messages.link_transforms import LinkTransforms
from tests.ros import message_build

HERE = Path(__file__).resolve().parent
ACTIVE = ["q1", "q12", "q22", "q4"]
SIDES = ("left", "right")
COUNT = 600  # messages: three times what a publisher keeps for a reader


def state(turn):
    return JointState(name=ACTIVE, position=[turn, 0.1, 0.15, 0.0])


class Beside:
    """A script of this folder in a process of its own; what it prints goes to a file."""

    def __init__(self, folder, script, *words, environment=None):
        self._log = folder / f"{script}.log"
        with self._log.open("w") as log:
            self.process = subprocess.Popen(
                [sys.executable, str(HERE / script), *words], stdout=log, env=environment
            )

    def lines(self):
        return [line for line in self._log.read_text().split("\n")[:-1] if line]

    def close(self):
        self.process.kill()
        self.process.wait()


@pytest.fixture
def beside(tmp_path):
    """Starts scripts that end with the test."""
    started = []

    def start(script, *words, **options):
        started.append(Beside(tmp_path, script, *words, **options))
        return started[-1]

    yield start
    for entry in started:
        entry.close()


@pytest.mark.sweep(
    sample="test_floods_are_counted_to_the_last_message_and_the_newest_state_is_answered"
)
def test_a_reader_that_is_stopped_costs_the_others_nothing(start_node, connect, beside):
    node = start_node("-p", "diagnostics.period:=0.1")
    node.wait_for("active joints")
    client = connect()
    reader = beside("stopped_reader.py", "/hybrid_dynamics/joint_states")

    def is_heard():
        client.publish("active_joint_states", state(0.0), client.new_stamp(0.01))
        return reader.lines()

    client.wait_until(is_heard, "a stamp at the reader")
    reader.process.send_signal(signal.SIGSTOP)
    try:
        last = 0
        for k in range(COUNT):
            last = client.new_stamp(0.01)
            client.publish("active_joint_states", state(1e-3 * k), last)
            if k % 20 == 19:  # no more at once than the node answers one by one
                client.wait_for("joint_states", last)
        stamps = [last - k * 10**7 for k in range(COUNT)]
        assert all(client.received("joint_states", stamp) for stamp in stamps)
        assert client.values("stream")["left out under overload"] == "0"
        assert client.state() == "active"
    finally:
        reader.process.send_signal(signal.SIGCONT)
    client.wait_until(lambda: str(last) in reader.lines(), "the newest state at the reader")
    assert node.stop() == 0


def transforms(listener):
    """What the listener has seen so far of each side, by stamp."""
    by_side = {side: {} for side in SIDES}
    for line in map(json.loads, listener.lines()):
        sides = {name.split("/")[0] for row in line["rows"] for name in row[:2]}
        assert len(sides) == 1  # no message has frames of both
        by_side[sides.pop()][line["stamp"]] = line["rows"]
    return by_side


def assert_links_of(robot, rows, turn):
    """The transforms are those of the robot at this turn of its first joint."""
    values = LinkTransforms(robot).values(robot.close([turn, 0.1, 0.15, 0.0]).s)
    found = [np.array(part) for row in rows for part in row[2:]]
    for value, other in zip(values, found, strict=True):
        np.testing.assert_allclose(other, value, atol=1e-12)


@pytest.mark.sweep(sample="test_two_robots_on_one_tf_share_the_base_alone")
def test_two_robots_on_one_tf_do_not_clash(start_node, connect, beside, robot, monkeypatch):
    """Both move differently; a listener sees a tree for each, with the links where they are."""
    for name, value in message_build.environment("tf2_msgs").items():
        monkeypatch.setenv(name, value)
    clients = {}
    for side in SIDES:
        prefix = ("-p", f"frame_prefix:={side}/", "-p", "rates.tf:=0.0")
        node = start_node("-r", f"__ns:=/{side}", *prefix)
        node.wait_for("active joints")
        clients[side] = connect(f"/{side}/hybrid_dynamics")
    listener = beside("frame_listener.py")
    turns = {"left": 0.3, "right": -0.4}
    newest = dict.fromkeys(SIDES, 0)

    def are_heard():
        for side in SIDES:
            newest[side] = clients[side].new_stamp(0.01)
            message = state(turns[side])
            clients[side].publish("active_joint_states", message, newest[side])
            clients[side].wait_for("joint_states", newest[side])
        return all(newest[side] in transforms(listener)[side] for side in SIDES)

    clients["left"].wait_until(are_heard, "transforms of both")
    parents = {}
    for side, by_stamp in transforms(listener).items():
        rows = by_stamp[newest[side]]
        for parent, child, _, _ in rows:
            assert parents.setdefault(child, parent) == parent
        assert_links_of(robot, rows, turns[side])
    assert len(parents) == 2 * len(robot.coordinates)
