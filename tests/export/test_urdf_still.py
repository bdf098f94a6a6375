"""A robot in which nothing moves: all joints of its file are fixed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, Robot, load
from hybrid_dynamics_core.export import to_yaml
from hybrid_dynamics_core.formats.reader import parse_description

STILL = """<robot name="post"><link name="base"/><link name="post"><inertial><mass value="2"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="bolt" type="fixed"><parent link="base"/><child link="post"/><origin xyz="1 2 3"/>
</joint></robot>"""


def test_everything_has_an_answer_of_no_coordinates(tmp_path: Path) -> None:
    robot = still(tmp_path)
    state = robot.close([], [])
    assert robot.coordinates == ()
    assert state.R.shape == (0, 0)
    assert robot.minimal_form(state)[0].shape == (0, 0)
    for empty in (
        robot.accelerations(state, []),
        robot.inverse_dynamics(state, []),
        robot.forward_dynamics(state, []),
        robot.distribute(state, []).missing,
        robot.close([], [], near=state).s,
    ):
        assert empty.shape == (0,)
    assert robot.close(np.zeros((3, 0)), np.zeros((3, 0))).s.shape == (3, 0)
    assert dict(robot.drive_forces(state, [])) == {}
    assert robot.forward_kinematics(state, "post").position == pytest.approx([1, 2, 3])
    with pytest.raises(InputError, match="no joint that moves"):
        robot.workspace(10)
    back = Robot(parse_description(to_yaml(robot)))
    assert back.coordinates == ()
    assert back.description.links["base"].mass == 2.0


def test_a_body_that_nobody_drives_comes_back(tmp_path: Path) -> None:
    file = tmp_path / "post.urdf"
    file.write_text(STILL.replace('type="fixed"', 'type="floating"'))
    robot = load(file)
    assert (len(robot.idle), len(robot.active)) == (6, 6)
    back = Robot(parse_description(to_yaml(robot)))
    assert back.idle == robot.idle
    state, other = (one.close(one.reference) for one in (robot, back))
    assert robot.distribute(state, np.ones(6)).forces == {}
    falling = [one.forward_dynamics(at, np.zeros(6)) for one, at in ((robot, state), (back, other))]
    assert falling[1] == pytest.approx(falling[0])


def still(folder: Path) -> Robot:
    """A post on a base."""
    file = folder / "post.urdf"
    file.write_text(STILL)
    return load(file)
