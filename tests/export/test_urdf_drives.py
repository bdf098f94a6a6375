"""Drives of a URDF: differentials and four-bar linkages, and the limits of <ros2_control>."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio
import pytest

from hybrid_dynamics_core import DescriptionError, Robot, load
from hybrid_dynamics_core.export import to_urdf, to_urdf_plus, to_yaml

LINK = """<link name="{0}"><inertial><origin xyz="{1} 0.1 0.2"/><mass value="{2}"/>
<inertia ixx="0.1" iyy="0.2" izz="0.15" ixy="0.01" ixz="0" iyz="0"/></inertial></link>
"""
WRIST = (
    '<robot name="wrist"><link name="base"/>\n'
    + LINK.format("arm", 0.3, 3)
    + LINK.format("pitch", 0.05, 1)
    + LINK.format("roll", 0.02, 2)
    + """<joint name="a" type="revolute"><parent link="base"/><child link="arm"/>
<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="90" velocity="3"/></joint>
<joint name="p" type="revolute"><parent link="arm"/><child link="pitch"/><origin xyz="0.6 0 0"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="20" velocity="3"/></joint>
<joint name="r" type="continuous"><parent link="pitch"/><child link="roll"/>
<origin xyz="0.1 0 0"/><axis xyz="1 0 0"/></joint>
MORE</robot>
"""
)
OF_ROS_1 = """<transmission name="t"><type>transmission_interface/KIND</type>
<actuator name="two"><role>actuator2</role><mechanicalReduction>-50</mechanicalReduction></actuator>
<actuator name="one"><role>actuator1</role><mechanicalReduction>40</mechanicalReduction></actuator>
<joint name="p"><role>joint1</role><offset>0.5</offset><mechanicalReduction>2</mechanicalReduction>
</joint>
<joint name="r"><role>joint2</role><offset>-0.1</offset><mechanicalReduction>3</mechanicalReduction>
</joint></transmission>
"""
OF_ROS_2 = """<ros2_control name="c" type="system"><joint name="a">
<command_interface name="effort"/></joint><transmission name="t">
<plugin>transmission_interface/KIND</plugin>
<actuator name="one" role="actuator1"><mechanical_reduction>40</mechanical_reduction></actuator>
<actuator name="two" role="actuator2"><mechanical_reduction>-50</mechanical_reduction></actuator>
<joint name="r" role="joint2"><offset>-0.1</offset><mechanical_reduction>3</mechanical_reduction>
</joint>
<joint name="p" role="joint1"><offset>0.5</offset><mechanical_reduction>2</mechanical_reduction>
</joint></transmission></ros2_control>
"""
# Rates of the actuators by those of p and r, as transmission_interface has them.
RATES = {
    "DifferentialTransmission": np.array([[40 * 2, 40 * 3], [-50 * 2, 50 * 3]]),
    "FourBarLinkageTransmission": np.array([[40 * 2, 0], [-50, -50 * 3]]),
}


def robot(folder: Path, more: str) -> Robot:
    """The wrist with more elements."""
    file = folder / "wrist.urdf"
    file.write_text(WRIST.replace("MORE", more))
    return load(file)


@pytest.mark.parametrize("written", [OF_ROS_1, OF_ROS_2], ids=["ROS 1", "ROS 2"])
@pytest.mark.parametrize("kind", RATES)
def test_two_actuators_share_two_joints(tmp_path: Path, kind: str, written: str) -> None:
    """Their efforts give the joints' efforts, which Pinocchio computes."""
    machine = robot(tmp_path, written.replace("KIND", kind))
    assert machine.active == ("a", "p", "r")
    assert machine.all_drives == ("a", "one", "two")
    one, two = machine.description.transmissions.values()
    assert (one.offset, two.offset) == pytest.approx(RATES[kind] @ [-0.5, 0.1])
    state = machine.close([0.3, -0.4, 0.9], [0.5, -0.2, 0.7])
    tau = machine.inverse_dynamics(state, [1.0, 2.0, 3.0])
    model = pinocchio.buildModelFromXML((tmp_path / "wrist.urdf").read_text())
    q = np.array([0.3, -0.4, np.cos(0.9), np.sin(0.9)])
    expected = pinocchio.rnea(model, model.createData(), q, state.ds, np.array([1.0, 2.0, 3.0]))
    assert tau == pytest.approx(expected, rel=1e-12)
    shared = machine.distribute(state, tau)
    forces = np.array([shared.forces["one"], shared.forces["two"]])
    assert forces == pytest.approx(np.linalg.solve(RATES[kind].T, expected[1:]), rel=1e-9)
    assert shared.is_possible
    assert machine.generalised_forces(state, shared.forces) == pytest.approx(tau)
    # what the actuators do is what the joints do
    power = RATES[kind] @ state.ds[1:] @ forces
    assert power == pytest.approx(tau[1:] @ state.ds[1:])


def test_coupled_drives_survive_every_file(tmp_path: Path) -> None:
    machine = robot(tmp_path, OF_ROS_1.replace("KIND", "DifferentialTransmission"))
    for text, name in ((to_yaml(machine), "back.yaml"), (to_urdf_plus(machine), "back.urdf")):
        (tmp_path / name).write_text(text)
        back = load(tmp_path / name).description.transmissions
        for drive, transmission in machine.description.transmissions.items():
            assert dict(back[drive].multipliers) == dict(transmission.multipliers)
            assert back[drive].offset == transmission.offset
    assert "drives that move several joints" in to_urdf(machine)


def test_what_is_no_coupled_drive_is_noted_as_before(tmp_path: Path) -> None:
    machine = robot(tmp_path, OF_ROS_1.replace("KIND", "HalfDifferentialTransmission"))
    assert machine.all_drives == ("a", "p", "r")
    assert any("transmission t drives" in note for note in machine.description.notes)
    wrong = OF_ROS_1.replace("KIND", "DifferentialTransmission")
    with pytest.raises(DescriptionError, match="has the reduction 0") as caught:
        robot(tmp_path, wrong.replace(">2<", ">0<"))
    assert caught.value.line == 17
    machine = robot(tmp_path, wrong.replace('name="one"', 'name="r"'))
    assert machine.all_drives == ("a", "r_motor", "two")
    assert any("'r' is called 'r_motor' here" in note for note in machine.description.notes)
    twice = wrong + OF_ROS_2.replace("KIND", "DifferentialTransmission")
    assert robot(tmp_path, twice).all_drives == ("a", "one", "two")
    third = wrong.replace("</transmission>", '<joint name="a"/></transmission>')
    assert robot(tmp_path, third).all_drives == ("a", "p", "r")


CONTROL = """<ros2_control name="c" type="system"><joint name="p">
<command_interface name="position"><param name="min">-0.4</param><param name="max">7</param>
</command_interface>
<command_interface name="velocity"><param name="min">-2</param><param name="max">2.5</param>
</command_interface>
<command_interface name="effort"><param name="min">-50</param><param name="max">50</param>
</command_interface><state_interface name="position"/></joint>
<joint name="r"><command_interface name="position"><param name="min">-1</param>
<param name="max">1.5</param></command_interface>
<command_interface name="effort"><param name="max">5</param></command_interface></joint>
</ros2_control>
"""


def test_limits_of_commands_narrow_those_of_joints(tmp_path: Path) -> None:
    machine = robot(tmp_path, CONTROL)
    assert machine.limits.tolist() == [[-2, 2], [-0.4, 1], [-1, 1.5]]
    assert machine.velocity_limits.tolist() == [3.0, 2.0, np.inf]
    assert machine.effort_limits.tolist() == [90.0, 20.0, 5.0]
    for switch in ('<joint name="p">', '<command_interface name="position">'):
        off = CONTROL.replace(switch, f'{switch}<limits enable="false"/>')
        assert robot(tmp_path, off).limits[1].tolist() == [-1, 1]
    apart = CONTROL.replace(">-0.4<", ">2<")
    machine = robot(tmp_path, apart)
    assert machine.limits[1].tolist() == [-1, 1]
    (note,) = (note for note in machine.description.notes if "leave no range" in note)
    assert "p (line 15)" in note
    with pytest.raises(DescriptionError, match=r"limits: <param> 'low'; expected a number"):
        robot(tmp_path, CONTROL.replace(">-0.4<", ">low<"))


def test_limits_the_wrong_way_round_are_none(tmp_path: Path) -> None:
    """Bullet writes so that there are none, for followers too."""
    turned = WRIST.replace('lower="-1" upper="1"', 'lower="1" upper="-1"').replace("MORE", "")
    end = 'effort="20" velocity="3"/>'
    for text in (turned, turned.replace(end, f'{end}<mimic joint="a"/>')):
        file = tmp_path / "wrist.urdf"
        file.write_text(text)
        machine = load(file)
        assert machine.description.joints["p"].limits == (-np.inf, np.inf)
        (note,) = (note for note in machine.description.notes if "above the upper one" in note)
        assert "p (line " in note


@pytest.mark.parametrize(("kind", "place"), [("revolute", 0.7), ("prismatic", -0.3)])
def test_equal_limits_fix_a_joint_where_it_is_held(tmp_path: Path, kind: str, place: float) -> None:
    """The other joints move as if the joint were at that coordinate; Pinocchio says how."""
    text = WRIST.replace("MORE", "").replace('1 0 0"/></joint>', '0.6 0 -0.8"/></joint>')
    text = text.replace('name="p" type="revolute"', f'name="p" type="{kind}"')
    file = tmp_path / "wrist.urdf"
    file.write_text(text.replace('lower="-1" upper="1"', f'lower="{place}" upper="{place}"'))
    machine = load(file)
    assert machine.coordinates == ("a", "r")
    assert any(f"hold at {place:g}" in note for note in machine.description.notes)
    model = pinocchio.buildModelFromXML(text)
    q = np.array([0.4, place, np.cos(1.1), np.sin(1.1)])
    full = pinocchio.crba(model, model.createData(), q)
    state = machine.close([0.4, 1.1])
    expected = np.triu(full) + np.triu(full, 1).T
    assert machine.minimal_form(state)[0] == pytest.approx(expected[::2, ::2], rel=1e-12)


def test_a_spherical_joint_of_bullet_is_a_ball_joint(tmp_path: Path) -> None:
    file = tmp_path / "wrist.urdf"
    text = WRIST.replace('name="r" type="continuous"', 'name="r" type="spherical"')
    file.write_text(text.replace("MORE", ""))
    machine = load(file)
    assert machine.coordinates == ("a", "p", "r_rx", "r_ry", "r_rz")
    (joint,) = machine.description.freely_turning
    assert joint.name == "r"


def test_dependent_joints_that_nothing_ties_are_noted(tmp_path: Path) -> None:
    """As in files whose constraint stands in the code of a program."""
    file = tmp_path / "wrist.urdf"
    loose = WRIST.replace(
        'name="r" type="continuous"', 'name="r" type="continuous" independent="false"'
    )
    file.write_text(loose.replace("MORE", ""))
    machine = load(file)
    assert machine.active == ("a", "p", "r")
    (note,) = (note for note in machine.description.notes if "nothing in the file ties" in note)
    assert "r (line " in note
    ends = '<predecessor link="pitch"/><successor link="roll"/>'
    tie = f'<coupling name="c">{ends}<ratio value="2"/></coupling>'
    file.write_text(loose.replace("MORE", tie))
    assert not any("ties" in note for note in load(file).description.notes)
