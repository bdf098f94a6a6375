"""The lines of the pages that start a node do start it, and the blocks that talk to it get their answer."""

import shlex

import pytest
import rclpy

from tests.docs.blocks import blocks_of, commands
from tests.docs.test_pages import PAGES

READY = "active joints "
LINES = sorted({line for page in PAGES for b in blocks_of(page) if b.starts_nodes for line in commands(b.text)})


def start(start_node, line):
    """Start the node as the line says."""
    program, ros_args, *arguments = shlex.split(line)
    assert (program, ros_args) == ("hybrid_dynamics_node", "--ros-args")
    return start_node(*arguments)


def test_every_line_starts_a_node(start_node):
    assert len(LINES) >= 3
    nodes = [start(start_node, line) for line in LINES]
    for node in nodes:
        node.wait_for(READY)
    assert [node.stop() for node in nodes] == [0] * len(LINES)


@pytest.mark.parametrize("page", [page for page in PAGES if any(b.beside_the_node for b in blocks_of(page))])
def test_blocks_beside_the_node_run(start_node, robot, page):
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
            names["client"].destroy_node()
            rclpy.shutdown()
    state = robot.close([0.0, 0.10, 0.15, 0.0], [0.17, 0.01, 0.005, 0.09])
    expected = robot.inverse_dynamics(state, [0.0] * 4)
    got = [names["efforts"][name] for name in robot.active]
    assert got == pytest.approx(expected, rel=1e-9, abs=1e-9)  # the process may have other code for one state
