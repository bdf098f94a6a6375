"""The lines of the pages that start a node do start it, and the blocks that talk to it get their
answer.
"""

import shlex

import pytest
import rclpy

from tests.docs.blocks import blocks_of, commands
from tests.docs.test_pages import PAGES
from tests.sampling import swept

READY = "active joints "
PATIENCE = 150.0  # [s] each makes its code
STARTS = [b for page in PAGES for b in blocks_of(page) if b.starts_nodes and not b.is_not_run]
LINES = sorted({line for block in STARTS for line in commands(block.text)})
FORGING = [line for line in LINES if "forging_chu2020" in line]  # its code is there already


def start(start_node, line):
    """Start the node as the line says."""
    program, ros_args, *arguments = shlex.split(line)
    assert (program, ros_args) == ("hybrid_dynamics_node", "--ros-args")
    return start_node(*arguments)


@pytest.mark.parametrize("line", swept(LINES, sample=FORGING))
def test_every_line_starts_a_node(start_node, line):
    node = start(start_node, line)
    node.wait_for(READY, PATIENCE)
    assert node.stop() == 0


def test_there_are_lines_of_several_robots():
    assert 2 <= len(FORGING) <= len(LINES) - 2


@pytest.mark.parametrize(
    "page", [page for page in PAGES if any(b.beside_the_node for b in blocks_of(page))]
)
def test_blocks_beside_the_node_run(start_node, robot, page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = list(blocks_of(page))
    first = next(block for block in blocks if block.starts_nodes)
    start(start_node, commands(first.text)[0]).wait_for(READY)
    names = {}
    try:
        for block in blocks:
            if block.beside_the_node:
                exec(compile(block.text, block.where, "exec"), names)  # noqa: S102  our own text
    finally:
        if rclpy.ok():
            names["node"].destroy_node()
            rclpy.shutdown()
    state = robot.close([0.0, 0.10, 0.15, 0.0], [0.17, 0.01, 0.005, 0.09])
    expected = robot.inverse_dynamics(state, [0.0] * 4)
    got = [names["efforts"][name] for name in robot.active]
    assert got == pytest.approx(
        expected, rel=1e-9, abs=1e-9
    )  # the process may have other code for one state
    check_stream(robot, names)
    check_recording(tmp_path / "recording")


def check_stream(robot, names):
    """Many messages at rest: the efforts that hold the robot."""
    weight = robot.inverse_dynamics(robot.close([0.0, 0.10, 0.15, 0.0]), [0.0] * 4)
    holding = [names["holding"][name] for name in robot.active]
    assert holding == pytest.approx(
        weight, rel=1e-9, abs=1e-9
    )  # at rest the estimated accelerations are zero
    assert len(names["received"]) > 25  # of 100 published; a loaded machine takes its time


def check_recording(path):
    """Every topic of the block is in the bag, readable."""
    reader = pytest.importorskip("rosbags.rosbag2")
    with reader.Reader(path) as bag:
        counts = {connection.topic: connection.msgcount for connection in bag.connections}
    topics = {
        f"/hybrid_dynamics/{name}"
        for name in ("active_joint_states", "joint_states", "required_efforts")
    }
    assert set(counts) == topics
    assert min(counts.values()) > 25
