"""The demo as people start it: its own processes, real messages."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_ros.bags.storage.bag_reader import read_raw
from hybrid_dynamics_ros.demo.judge.results import read_results
from hybrid_dynamics_ros.demo.play.recording import shipped_messages
from hybrid_dynamics_ros.demo.topics import INPUT
from hybrid_dynamics_ros.demo.trajectory import paper_trajectory
from tests.sampling import swept

ROOT = Path(__file__).resolve().parents[2]
DEADLINE = 120.0  # [s], for 7 s on an idle machine


def start(*arguments, module="hybrid_dynamics_ros.demo", code=None):
    """The demo in a process group of its own."""
    command = (
        [sys.executable, "-c", code, *arguments]
        if code
        else [sys.executable, "-m", module, *arguments]
    )
    environment = {key: value for key, value in os.environ.items() if not key.startswith("ROS_")}
    environment["PYTHONUNBUFFERED"] = "1"
    return subprocess.Popen(
        command,
        cwd=ROOT,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def finish(process):
    """Exit code, output and errors of a demo that leaves no process behind."""
    try:
        out, err = process.communicate(timeout=DEADLINE)
    finally:
        left = group_alive(process.pid)
        if left:
            os.killpg(process.pid, signal.SIGKILL)
    assert not left
    return process.returncode, out, err


def group_alive(pid):
    """Whether a process of the group runs; one that ended and waits for its parent does not."""
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, group = path.read_text(encoding="utf-8").rpartition(")")[2].split()[:3]
        except (FileNotFoundError, ProcessLookupError):
            continue
        if int(group) == pid and state != "Z":
            return True
    return False


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """A run at five times the recorded speed: exit code, output, errors, folder."""
    folder = tmp_path_factory.mktemp("demo") / "output"
    return *finish(start("--rate", "5", "--output", str(folder))), folder


@pytest.fixture(scope="module")
def received(done):
    return read_results(done[3] / "forging_chu2020_results")


def test_it_succeeds_and_says_what_it_made(done):
    code, out, err, folder = done
    assert (code, err) == (0, "")
    assert "1001 messages played, 0 messages lost" in out
    assert "t 10.00 s | q1 100.000 deg" in out
    assert sorted(path.name for path in folder.iterdir()) == [
        "forging_chu2020.png",
        "forging_chu2020.svg",
        "forging_chu2020_results",
        "node.log",
        "player.log",
    ]


def test_the_input_arrives_byte_for_byte(done):
    recorded = read_raw(done[3] / "forging_chu2020_results", INPUT)
    assert [data for _, data in recorded] == [data for _, data in shipped_messages()]


def test_every_message_is_answered_once_and_in_order(received):
    stamps = received.inputs.stamp_ns
    assert len(stamps) == 1001
    np.testing.assert_array_equal(received.states.stamp_ns, stamps)
    np.testing.assert_array_equal(received.pose.stamp_ns, stamps)
    np.testing.assert_array_equal(
        received.efforts.stamp_ns, stamps[-len(received.efforts.stamp_ns) :]
    )
    assert len(received.efforts.stamp_ns) >= 990


def test_efforts_states_and_poses_are_those_of_the_model(received, robot):
    motion = paper_trajectory(100)
    state = robot.close(motion.position, motion.velocity)
    pose = robot.forward_kinematics(state)
    tau = robot.inverse_dynamics(state, np.zeros_like(motion.velocity))[
        -len(received.efforts.stamp_ns) :
    ]
    assert received.efforts.names == robot.active
    assert received.states.names == robot.coordinates
    # rounding only; tau_4 is rounding itself: 1e-9 of the least torque that matters
    np.testing.assert_allclose(received.efforts.effort, tau, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(received.states.position, state.s, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(received.states.velocity, state.ds, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(received.pose.position, pose.position, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(received.pose.quaternion, pose.quaternion, rtol=1e-9, atol=1e-12)
    assert received.pose.frame == robot.base_frame


@pytest.mark.parametrize("number", swept([signal.SIGINT, signal.SIGTERM], [signal.SIGINT]))
def test_a_signal_while_messages_flow_ends_all_processes_and_leaves_no_bag(number, tmp_path):
    process = start("--rate", "0.5", "--output", str(tmp_path))
    for text in process.stdout:
        if text.startswith("t "):
            break
    process.send_signal(number)
    code, _, err = finish(process)
    assert (code, err) == (130, "Stopped.\n")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["node.log", "player.log"]


def test_a_node_that_does_not_start_is_reported_with_its_words(tmp_path):
    code = (
        "import sys, hybrid_dynamics_ros.demo.session as session; session.ROBOT = 'no_such_robot'\n"
        "from hybrid_dynamics_ros.demo.cli import main; sys.exit(main(sys.argv[1:]))"
    )
    begin = time.monotonic()
    exit_code, _, err = finish(start("--output", str(tmp_path), code=code))
    assert exit_code == 1
    assert "The node has no robot" in err
    assert "no_such_robot" in err
    assert "Traceback" not in err
    assert time.monotonic() - begin < DEADLINE / 2  # it does not wait for a dead node


def test_help_has_examples_and_needs_no_ros():
    process = start("--help")
    code, out, _ = finish(process)
    assert code == 0
    assert "examples:" in out
    assert "--rate 5" in out


@pytest.mark.parametrize(
    "arguments", [["--rate", "0"], ["--rate", "nan"], ["--rate", "fast"], ["--domain", "300"]]
)
def test_wrong_options_are_refused(arguments):
    code, _, err = finish(start(*arguments))
    assert code == 2
    assert arguments[1] in err
