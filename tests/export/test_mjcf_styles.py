"""MJCF as people write it: classes, degrees, shapes, loops between bodies, position drives."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import DescriptionError, Robot, load

MASS = '<inertial pos=".1 0 0" mass="1" diaginertia=".01 .01 .01"/>'
HINGE = '<joint name="j1" axis="0 1 0"/>'
ARM = f'<body name="rod2" pos=".2 0 0">{MASS}<joint name="j2" axis="0 1 0"/></body>'  # on the rod


def model(
    *, head: str = '<compiler angle="radian"/>', rod: str = "", tail: str = "", on: str = ""
) -> str:
    """A rod on a hinge, with more in its tag, on it, and behind the bodies."""
    body = f'<body name="rod" {rod}>{MASS}{HINGE}{on}</body>'
    return f'<mujoco model="h">{head}<worldbody>{body}</worldbody>{tail}</mujoco>'


def read(folder: Path, text: str) -> Robot:
    file = folder / "model.xml"
    file.write_text(text, encoding="utf-8")
    return load(file)


def held(robot: Robot, *u: float) -> float:
    """The effort of the first drive that holds a pose."""
    return float(robot.inverse_dynamics(robot.close(list(u)), np.zeros(len(u)))[0])


WEIGHT = 9.81 * 0.1  # [N m] of the rod that lies level; its hinge is along y, so it holds -WEIGHT
STYLES = {
    "degrees, which need no word": (model(head=""), -WEIGHT),
    "turned by fixed angles": (
        model(
            head='<compiler angle="radian" eulerseq="zyx"/>',
            rod='euler=".1 .2 .3"',
        ),
        -WEIGHT * math.cos(0.2) * math.cos(0.3),  # the hinge leans with the last turn
    ),
    "a floor": (
        model(tail='<worldbody><geom type="plane" size="1 1 .1"/></worldbody>'),
        -WEIGHT,
    ),
    "a shape beside an inertial": (
        model(on='<geom type="capsule" size=".01" fromto="0 0 0 .2 0 0"/>'),
        -WEIGHT,
    ),
    "a position drive": (
        model(tail='<actuator><position joint="j1" kp="10"/></actuator>'),
        -WEIGHT,
    ),
    # The second rod turns as the first one: virtual work at zero, and with q2 = 0.1 - 2 q1.
    "a follower by default": (
        model(on=ARM, tail='<equality><joint joint1="j2" joint2="j1"/></equality>'),
        -9.81 * (0.1 + 0.2 + 2 * 0.1),
    ),
    "a follower with a short polynomial": (
        model(
            on=ARM, tail='<equality><joint joint1="j2" joint2="j1" polycoef=".1 -2"/></equality>'
        ),
        -9.81 * (0.1 + 0.2 - 0.1 * math.cos(0.1)),
    ),
}


@pytest.mark.parametrize(("text", "expected"), STYLES.values(), ids=STYLES.keys())
def test_a_style_is_read(text: str, expected: float, tmp_path: Path) -> None:
    robot = read(tmp_path, text)
    assert robot.active == ("j1",)
    assert held(robot, 0.0) == pytest.approx(expected, rel=1e-12)


BARS = """<mujoco model="fourbar">
  <compiler angle="radian"/>
  <default><joint damping="0.1"/><geom density="100"/></default>
  <worldbody>
    <body name="crank"><inertial pos=".1 0 0" mass="1" diaginertia=".001 .0033 .0033"/>
      <joint name="a" axis="0 1 0"/>
      <geom size="0.02 0.1" pos="0.1 0 0" quat="0.707107 0 -0.707107 0" type="capsule"/>
      <body name="coupler" pos=".2 0 0">
        <inertial pos=".25 0 0" mass="1" diaginertia=".001 .021 .021"/>
        <joint name="b" axis="0 1 0"/></body></body>
    <body name="rocker" pos=".45 0 0">
      <inertial pos=".2 0 0" mass="1" diaginertia=".001 .013 .013"/>
      <joint name="c" axis="0 1 0" ref="0.3"/></body>
  </worldbody>
  <equality><connect body1="coupler" body2="rocker" anchor=".5 0 0"/></equality>
  <actuator><general joint="a" gear="50"/></actuator>
</mujoco>
"""


def test_a_loop_is_closed_where_the_file_draws_it(tmp_path: Path) -> None:
    """A four-bar with its pin at the anchor, in both bodies where they are drawn."""
    drawn = BARS.replace('name="rocker" pos=".45 0 0"', 'name="rocker" pos=".6 0 -.2"')
    robot = read(tmp_path, drawn)
    assert robot.active == ("a",)
    (closure,) = robot.description.closures
    assert closure.point_b == pytest.approx([0.1, 0.0, 0.2], abs=1e-12)
    state = robot.close(robot.reference)
    assert dict(zip(robot.coordinates, state.s, strict=True)) == pytest.approx(
        {"a": 0.0, "b": 0.0, "c": 0.3}, abs=1e-9
    )
    assert robot.description.effects["b"].viscous == 0.1
    (note,) = (note for note in robot.description.notes if "gear" in note)
    assert note == "model.xml:16: gear of <general> is 50; efforts here are of the joint"


def test_motors_lead_the_joints_that_are_coupled_with_them(tmp_path: Path) -> None:
    """MuJoCo's polynomial gives joint1 from joint2, whichever has the motor."""
    tail = '<equality><joint joint1="j2" joint2="j1" polycoef=".1 -2"/></equality>'
    motor = '<actuator><motor joint="j2"/></actuator>'
    robot = read(tmp_path, model(on=ARM, tail=tail + motor))
    assert robot.active == ("j2",)
    state = robot.close([0.7])
    assert dict(zip(robot.coordinates, state.s, strict=True))["j1"] == pytest.approx(-0.3)


def test_a_joint_that_an_equality_holds_does_not_move(tmp_path: Path) -> None:
    tail = '<equality><joint joint1="j2" polycoef="0.4"/></equality>'
    robot = read(tmp_path, model(on=ARM, tail=tail))
    assert robot.coordinates == ("j1",)
    expected = -9.81 * (0.1 + 0.2 + 0.1 * math.cos(0.4))
    assert held(robot, 0.0) == pytest.approx(expected)
    assert any(note == "model.xml:1: joint j2 is held at 0.4" for note in robot.description.notes)


def test_couplings_in_a_circle_are_refused(tmp_path: Path) -> None:
    one = '<joint joint1="j2" joint2="j1"/>'
    with pytest.raises(DescriptionError, match="which others tie already"):
        read(tmp_path, model(on=ARM, tail=f"<equality>{one}{one}</equality>"))


def test_a_free_base_is_six_joints_that_nobody_drives(tmp_path: Path) -> None:
    """Thrown without efforts, it falls: all of it has the acceleration of gravity."""
    text = model(tail='<actuator><motor joint="j2"/></actuator>', on=ARM)
    robot = read(tmp_path, text.replace(HINGE, "<freejoint/>"))
    assert robot.active[0] == "j2"
    assert len(robot.coordinates) == 7
    state = robot.close(robot.reference)
    accelerations = robot.forward_dynamics(state, np.zeros(len(robot.active)))
    falling = dict(zip(robot.active, accelerations, strict=True))
    assert falling.pop("joint0_z") == pytest.approx(-9.81)
    assert list(falling.values()) == pytest.approx([0.0] * 6, abs=1e-9)


def test_constraints_that_do_not_hold_are_noted(tmp_path: Path) -> None:
    robot = read(tmp_path, BARS.replace("<connect ", '<connect active="false" '))
    assert robot.description.closures == ()
    assert 'model.xml:15: <connect> is left out: active="false"' in robot.description.notes


def test_bounds_of_the_compiler_raise_light_bodies_with_a_note(tmp_path: Path) -> None:
    robot = read(tmp_path, model(head='<compiler boundmass="3" boundinertia="0.5"/>'))
    link = robot.description.links["rod"]
    assert (link.mass, link.inertia[0, 0]) == (3.0, 0.5)
    assert any("raised or balanced" in note for note in robot.description.notes)


PANDA = """<tendon><fixed name="both"><joint joint="j1" coef=".5"/><joint joint="j2" coef=".5"/>
</fixed></tendon><actuator><general tendon="both"/></actuator>"""


def test_a_tendon_of_coupled_joints_is_one_drive(tmp_path: Path) -> None:
    tied = '<equality><joint joint1="j1" joint2="j2"/></equality>'
    robot = read(tmp_path, model(on=ARM, tail=tied + PANDA))
    assert robot.active == ("j1",)
    apart = read(tmp_path, model(on=ARM, tail=PANDA))
    assert apart.active == ("j1", "j2")
    words = "drives a tendon of j1, j2, which no equality couples; each of them is taken as driven"
    assert any(words in note for note in apart.description.notes)


DRIVES = {
    '<motor joint="j1" gear="50" forcerange="-2 2"/>': 100.0,
    '<motor joint="j1" gear="25" ctrlrange="-4.5 4.5"/>': 112.5,
    '<motor joint="j1" ctrlrange="-2 2" forcerange="-1 1"/>': 1.0,
    '<position joint="j1" ctrlrange="-1 1"/>': math.inf,  # it is a place there
    '<position joint="j1" forcerange="-3 5"/>': 5.0,
    '<motor joint="j1" forcerange="-2 2"/><velocity joint="j1" forcerange="-1 1"/>': 3.0,
    '<motor joint="j1" forcerange="-2 2"/><velocity joint="j1"/>': math.inf,
    '<motor joint="j1" forcerange="-2 2" forcelimited="false"/>': math.inf,
}


@pytest.mark.parametrize(("drives", "limit"), DRIVES.items())
def test_forces_of_actuators_through_their_gears_limit_efforts(
    drives: str, limit: float, tmp_path: Path
) -> None:
    robot = read(tmp_path, model(tail=f"<actuator>{drives}</actuator>"))
    assert robot.description.joints["j1"].effort_limit == limit


def test_the_drawn_pose_is_moved_into_the_limits(tmp_path: Path) -> None:
    limited = model().replace('name="j1"', 'name="j1" range=".2 1"')
    robot = read(tmp_path, limited)
    assert robot.reference == pytest.approx([0.2])
    assert any("drawn at 0, beyond its limits" in note for note in robot.description.notes)


SCENE = """<mujoco model="scene">
  <include file="robot.xml"/>
  <worldbody><light pos="0 0 3"/><geom type="plane" size="1 1 .1"/></worldbody>
</mujoco>
"""


def test_included_files_stand_in_place_of_their_include(tmp_path: Path) -> None:
    robot_file = tmp_path / "robot.xml"
    robot_file.write_text(model(on='\n<camera name="c"/>'), encoding="utf-8")
    robot = read(tmp_path, SCENE)
    assert (robot.name, robot.active) == ("scene", ("j1",))
    assert held(robot, 0.0) == pytest.approx(-WEIGHT)
    assert "<camera> is left out (line 2 of robot.xml)" in robot.description.notes
    assert "<light> is left out (line 3)" in robot.description.notes


def test_errors_in_included_files_name_them(tmp_path: Path) -> None:
    robot_file = tmp_path / "robot.xml"
    robot_file.write_text(model(on='\n<joint name="x" type="screw"/>'), encoding="utf-8")
    with pytest.raises(DescriptionError, match="invalid keyword: 'screw'") as caught:
        read(tmp_path, SCENE)
    assert (caught.value.file, caught.value.line) == (robot_file, 2)
