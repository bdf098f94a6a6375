"""A robot in which nothing moves: all joints of its file are fixed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, Robot, load
from hybrid_dynamics_core.export import to_yaml

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
    assert "fixed" in to_yaml(robot)


def still(folder: Path) -> Robot:
    """A post on a base."""
    file = folder / "post.urdf"
    file.write_text(STILL)
    return load(file)
