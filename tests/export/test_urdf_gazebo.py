"""What a URDF says to Gazebo, drives and Drake: loops, followers, springs, rotors; else notes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import DescriptionError, Robot, load
from hybrid_dynamics_core.description.geometry import Transform, rotation_from_rpy, rpy_of
from hybrid_dynamics_core.ground.arrays import frozen
from tests.export.test_urdf_words import LOOP, TIES
from tests.sampling import examples

BODY = (
    '<inertial><origin xyz="{}"/><mass value="{}"/><inertia ixx="{}" iyy="{}" izz="{}"/></inertial>'
)
FOUR_BAR = (
    '<robot name="gazebo_joint">\n<link name="ground"/>\n'
    f'<link name="one">{BODY.format("0.05 0 0.15", 1.2, 0.011, 0.011, 0.002)}</link>\n'
    f'<link name="two">{BODY.format("0.3 0 0.05", 0.9, 0.002, 0.03, 0.03)}</link>\n'
    f'<link name="three">{BODY.format("0.04 0 0.2", 1.7, 0.026, 0.026, 0.002)}</link>\n'
    '<joint name="p" type="continuous"><parent link="ground"/><child link="one"/>'
    '<axis xyz="0 1 0"/></joint>\n'
    '<joint name="q" type="continuous"><parent link="one"/><child link="two"/>'
    '<origin xyz="0.05 0 0.25"/><axis xyz="0 1 0"/></joint>\n'
    '<joint name="r" type="continuous"><parent link="ground"/><child link="three"/>'
    '<origin xyz="0.5 0 0"/><axis xyz="0 1 0"/></joint>\n'
    "MORE</robot>\n"
)
SHUT = (
    '<gazebo><joint name="shut" type="revolute"><parent>two</parent><child>three</child>'
    "<pose>0.05 0 0.32 0 0 0</pose><axis><xyz>0 1 0</xyz></axis></joint></gazebo>\n"
)


def robot(folder: Path, more: str, text: str = FOUR_BAR) -> Robot:
    file = folder / "file.urdf"
    file.write_text(text.replace("MORE", more), encoding="utf-8")
    return load(file)


def notes(machine: Robot) -> str:
    return "\n".join(machine.description.notes)


def held(machine: Robot, *u: float) -> list[float]:
    """Efforts that hold the robot still."""
    state = machine.close(list(u))
    efforts: list[float] = machine.inverse_dynamics(state, [0.0] * len(u)).tolist()
    return efforts


# -- loops


def test_a_loop_of_gazebos_tutorial_is_closed(tmp_path: Path) -> None:
    """Efforts by the same loop written as a closure, at (0.5, 0, 0.07) of `two`."""
    machine = robot(tmp_path, SHUT)
    assert machine.active == ("p",)
    assert held(machine, 0.0) == pytest.approx([-1.48871], abs=5e-6)
    assert held(machine, 0.25) == pytest.approx([-2.77716], abs=5e-6)
    assert "the file does not say what is driven" in notes(machine)


def test_the_three_ways_to_tie_two_links_agree(tmp_path: Path) -> None:
    states = [
        robot(tmp_path, tie, LOOP.replace("TIE", "MORE")).close([0.4], [0.3])
        for tie in TIES.values()
    ]
    for state in states[1:]:
        assert state.s == pytest.approx(states[0].s, abs=1e-12)
        assert state.ds == pytest.approx(states[0].ds, abs=1e-12)


@examples(24)
@given(
    pose=st.lists(st.floats(-2.0, 2.0), min_size=3, max_size=3),
    frame=st.sampled_from(["", "two", "three", "one", "__model__"]),
    expressed_in=st.sampled_from(["", "one", "__model__"]),
    turned=st.booleans(),
)
def test_the_same_pin_in_any_frame_closes_alike(
    pose: list[float],
    frame: str,
    expressed_in: str,
    turned: bool,
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    """The joint's frame may be turned, and its pose relative to any link."""
    origins = {"two": [0.05, 0, 0.25], "three": [0.5, 0, 0], "": [0.5, 0, 0]}
    around = Transform(translation=frozen(origins.get(frame, [0, 0, 0])))
    rotation = rotation_from_rpy(*pose)
    joint = around.inverse() @ Transform(rotation, frozen([0.55, 0, 0.32]))
    axis = np.array([0.0, 1.0, 0.0]) if expressed_in else rotation.T @ [0, 1, 0]
    ends = ["two", "three"]
    if turned and frame:
        ends.reverse()
    numbers = " ".join(map(repr, [*joint.translation.tolist(), *rpy_of(joint.rotation).tolist()]))
    relative = f' relative_to="{frame}"' if frame else ""
    expressed = f' expressed_in="{expressed_in}"' if expressed_in else ""
    tie = (
        f'<gazebo><joint name="shut" type="revolute"><parent>{ends[0]}</parent>'
        f"<child>robot::{ends[1]}</child><pose{relative}>{numbers}</pose>"
        f"<axis><xyz{expressed}>{' '.join(map(repr, axis.tolist()))}</xyz></axis></joint></gazebo>"
    )
    machine = robot(tmp_path_factory.mktemp("pin"), tie)
    assert held(machine, 0.25) == pytest.approx([-2.7771570328], abs=1e-8)


def test_friction_and_a_spring_in_a_loops_joint_are_kept(tmp_path: Path) -> None:
    """The joint angle at the pin is r - p - q; tau = tau_0 + (d r' + k r)(dr/dp)."""
    plain = robot(tmp_path, SHUT)
    dynamics = (
        "<dynamics><damping>0.5</damping><spring_stiffness>3</spring_stiffness>"
        "<spring_reference>0.2</spring_reference></dynamics></axis>"
    )
    effects = robot(tmp_path, SHUT.replace("</axis>", dynamics))
    u, du = [0.25], [0.7]
    state, other = plain.close(u, du), effects.close(u, du)
    ds = dict(zip(plain.coordinates, state.ds, strict=True))
    s = dict(zip(plain.coordinates, state.s, strict=True))
    angle = s["r"] - s["p"] - s["q"]
    rate = ds["r"] - ds["p"] - ds["q"]
    force = 0.5 * rate + 3.0 * (angle - 0.2)
    expected = plain.inverse_dynamics(state, [0.3]) + force * rate / du[0]
    assert effects.inverse_dynamics(other, [0.3]) == pytest.approx(expected, abs=1e-9)


SLIDER = """\
<robot name="slider"><link name="base"/>
<link name="crank"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01"/></inertial></link>
<link name="rod"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>
<inertia ixx="0.02" iyy="0.02" izz="0.02"/></inertial></link>
<link name="block"/>
<joint name="a" type="continuous"><parent link="base"/><child link="crank"/><axis xyz="0 1 0"/>
<origin rpy="0 -0.5 0"/></joint>
<joint name="b" type="continuous"><parent link="crank"/><child link="rod"/><axis xyz="0 1 0"/>
<origin xyz="0.2 0 0" rpy="0 0.9 0"/></joint>
<joint name="c" type="continuous"><parent link="rod"/><child link="block"/><axis xyz="0 1 0"/>
<origin xyz="PLACE" rpy="0 -0.4 0"/></joint>
MORE</robot>
"""


RAIL = (
    '<gazebo><joint name="rail" type="prismatic"><parent>base</parent><child>block</child>'
    "<axis><xyz>1 0 0</xyz><limit>LIMIT</limit></axis></joint></gazebo>"
)


@pytest.mark.parametrize(
    ("limit", "limits"),
    [("<lower>-1</lower>", (-1.0, np.inf)), ("<upper>1</upper>", (-np.inf, 1.0))],
)
def test_an_end_that_is_not_given_is_none(
    tmp_path: Path, limit: str, limits: tuple[float, float]
) -> None:
    text = SLIDER.replace("PLACE", "0.5 0 0")
    machine = robot(tmp_path, RAIL.replace("LIMIT", limit), text)
    assert machine.description.joints["rail"].limits == limits


def test_a_slide_closes_a_loop(tmp_path: Path) -> None:
    """A slider-crank whose slide is in <gazebo>: power of gravity by differences of heights."""
    rail = RAIL.replace("LIMIT", "<lower>-1</lower><upper>1</upper>")
    text = SLIDER.replace("PLACE", "0.5 0 0")
    machine = robot(tmp_path, rail, text)
    assert machine.active == ("a",)
    assert machine.description.joints["rail"].limits == (-1, 1)

    def potential(u: float) -> float:
        state = machine.close([u])
        heights = 0.0
        for link, arm, mass in (("crank", 0.1, 1.0), ("rod", 0.2, 2.0)):
            pose = machine.forward_kinematics(state, link)
            heights += mass * (pose.position + pose.rotation @ [arm, 0, 0])[2]
        return 9.81 * float(heights)

    slope = (potential(0.301) - potential(0.299)) / 0.002
    assert held(machine, 0.3) == pytest.approx([slope], abs=1e-5)
    block = machine.forward_kinematics(machine.close([0.3]), "block")
    assert block.rotation == pytest.approx(np.eye(3), abs=1e-9)
    zero = machine.forward_kinematics(machine.close([0.0]), "block")
    assert block.position[2] == pytest.approx(zero.position[2], abs=1e-9)


SCREW = """\
<robot name="lift"><link name="base"/><link name="nut"><inertial><mass value="10"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial></link><link name="spindle"/>
<joint name="lift" type="prismatic"><parent link="base"/><child link="nut"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="turn" type="continuous"><parent link="base"/><child link="spindle"/><axis xyz="0 0 1"/>
</joint>
<transmission name="t" type="SimpleTransmission"><joint name="turn"/><actuator name="m"/>
</transmission>
<gazebo><joint name="thread" type="screw"><parent>nut</parent><child>spindle</child>
<axis><xyz>0 0 1</xyz></axis>PITCH</joint></gazebo></robot>
"""


@pytest.mark.parametrize(
    ("pitch", "metres"),
    [
        ("<screw_thread_pitch>0.004</screw_thread_pitch>", 0.004),
        ("<thread_pitch>3141.6</thread_pitch>", -2.0 * np.pi / 3141.6),
    ],
)
def test_a_screw_lifts_by_its_pitch(tmp_path: Path, pitch: str, metres: float) -> None:
    """The spindle moves by `metres` a turn in the nut: the nut goes the other way."""
    machine = robot(tmp_path, "", SCREW.replace("PITCH", pitch))
    assert machine.active == ("turn",)
    state = machine.close([2.0 * np.pi])
    values = dict(zip(machine.coordinates, state.s, strict=True))
    assert values["lift"] == pytest.approx(-metres, abs=1e-12)
    assert held(machine, 0.0) == pytest.approx([-98.1 * metres / (2.0 * np.pi)], abs=1e-9)


def test_a_ball_of_drake_is_a_point(tmp_path: Path) -> None:
    ball = (
        '<drake:ball_constraint><drake:ball_constraint_body_A name="two"/>'
        '<drake:ball_constraint_body_B name="three"/>'
        '<drake:ball_constraint_p_AP value="0.5 0 0.07"/>'
        '<drake:ball_constraint_p_BQ value="0.05 0 0.32"/></drake:ball_constraint>'
    )
    text = FOUR_BAR.replace("<robot ", '<robot xmlns:drake="http://drake.mit.edu" ')
    assert held(robot(tmp_path, ball, text), 0.25) == pytest.approx([-2.7771570328], abs=1e-8)
    machine = robot(tmp_path, ball + ball, text)  # the second one says the same
    assert len(machine.description.closures) == 2
    assert held(machine, 0.25) == pytest.approx([-2.7771570328], abs=1e-8)


def test_the_base_may_be_put_on_the_world(tmp_path: Path) -> None:
    ground = (
        '<gazebo><joint name="g" type="fixed"><parent>world</parent><child>ground</child></joint>'
        "</gazebo>"
    )
    machine = robot(tmp_path, SHUT + ground)
    assert "joins 'ground' to the world, where the base stands anyway" in notes(machine)
    with pytest.raises(DescriptionError, match="joins 'one' to the world; here the base 'ground'"):
        robot(tmp_path, SHUT + ground.replace("<child>ground", "<child>one"))


WRONG = {
    "type": ('type="revolute"', 'type="universal"', "closes a loop with a joint of type 'univ"),
    "parent": ("<parent>two</parent>", "", "has no <parent>"),
    "link": ("<child>three", "<child>thre", r"there is no link 'thre' \(did you mean 'three'"),
    "ends": ("<child>three", "<child>two", "has both ends on one link"),
    "axis": ("<xyz>0 1 0", "<xyz>0 0 0", "the axis has no length"),
    "pose": ("<pose>0.05", "<pose>", "expected 6 numbers"),
    "degrees": ("<pose>", '<pose degrees="true">', "has degrees, not covered here"),
    "frame": ("<pose>", '<pose relative_to="hand">', "there is no link 'hand'"),
    "name": ('name="shut"', 'name="q"', "has the name of another joint"),
    "body": ("<gazebo>", '<gazebo><link name="x"/>', "<link> in <gazebo> adds bodies"),
}


@pytest.mark.parametrize(("old", "new", "words"), WRONG.values(), ids=WRONG.keys())
def test_a_wrong_loop(tmp_path: Path, old: str, new: str, words: str) -> None:
    assert old in SHUT
    with pytest.raises(DescriptionError, match=words) as caught:
        robot(tmp_path, SHUT.replace(old, new, 1))
    assert caught.value.line == 9


# -- all else in <gazebo>


def test_springs_of_gazebo_are_read(tmp_path: Path) -> None:
    spring = (
        '<gazebo reference="q"><springStiffness>4</springStiffness>'
        "<springReference>0.3</springReference><implicitSpringDamper>1</implicitSpringDamper></gazebo>"
    )
    machine = robot(tmp_path, spring)
    effect = machine.description.effects["q"]
    assert (effect.stiffness, effect.rest) == (4.0, 0.3)
    without = robot(tmp_path, "")
    difference = np.subtract(held(machine, 0.1, 0.5, 0.2), held(without, 0.1, 0.5, 0.2))
    assert difference == pytest.approx([0.0, 4.0 * (0.5 - 0.3), 0.0], abs=1e-12)
    words = "of <gazebo> is left out, from here on: <implicitSpringDamper> (1)"
    assert f"file.urdf:9: {words}" in notes(machine)


GRAVITY_OFF = '<gazebo reference="one"><turnGravityOff>true</turnGravityOff></gazebo>'
DIFFERENTIAL = (
    '<transmission name="t"><type>transmission_interface/DifferentialTransmission</type>'
    '<actuator name="x"/><actuator name="y"/><joint name="p"/><joint name="q"/></transmission>'
)
LOST_MIMIC = (
    '<gazebo><plugin filename="libmimic.so"><joint>p</joint><mimicJoint>x</mimicJoint></plugin>'
    "</gazebo>"
)
NOTED = {
    "gravity off": (GRAVITY_OFF, "it has its weight here"),
    "gravity": ('<gazebo reference="one"><gravity>0</gravity></gazebo>', "its weight here"),
    "damped": ('<gazebo reference="one"><dampingFactor>0.1</dampingFactor></gazebo>', "changes"),
    "static": ("<gazebo><static>true</static></gazebo>", "changes the motion"),
    "contact": ('<gazebo reference="one"><mu1>0.2</mu1></gazebo>', "<mu1> (1)"),
    "plugin": ('<gazebo><plugin filename="liba.so"/></gazebo>', "<plugin> liba.so (1)"),
    "nothing": ('<gazebo reference="nobody"><mu1>1</mu1></gazebo>', "'nobody', which is not there"),
    "attribute": ('<gazebo reference="one" more="1"/>', "more of <gazebo>"),
    "still": (
        '<gazebo reference="one"><springStiffness>1</springStiffness></gazebo>',
        "does not move; its spring is left out",
    ),
    "differential": (DIFFERENTIAL, "transmission t drives p and q together"),
    "simple": (
        '<transmission name="t"><joint name="p"/></transmission>',
        "<transmission>s are",
    ),
    "control": ('<ros2_control name="c" type="system"/>', "<ros2_control> is left out, but"),
    "no joint": (
        '<ros2_control><joint name="x"/></ros2_control>',
        "no joint 'x' that moves",
    ),
    "no mimic": (LOST_MIMIC, "no joint 'x' moves here"),
}


@pytest.mark.parametrize(("more", "words"), NOTED.values(), ids=NOTED.keys())
def test_what_is_left_out_is_noted_with_its_line(tmp_path: Path, more: str, words: str) -> None:
    machine = robot(tmp_path, more)
    (note,) = [note for note in machine.description.notes if words in note]
    assert note.startswith("file.urdf:9: ")


# -- followers and drives


MIMICS = {
    "gazebo": '<gazebo><plugin filename="libroboticsgroup_gazebo_mimic_joint_plugin.so">'
    "<joint>p</joint><mimicJoint>r</mimicJoint><multiplier>-2</multiplier><offset>0.1</offset>"
    "</plugin></gazebo>",
    "ros2_control": '<ros2_control><joint name="r"><param name="mimic">p</param>'
    '<param name="multiplier">-2</param><param name="offset">0.1</param></joint></ros2_control>',
}


@pytest.mark.parametrize("more", MIMICS.values(), ids=MIMICS.keys())
def test_followers_are_read(tmp_path: Path, more: str) -> None:
    machine = robot(tmp_path, more)
    mimic = machine.description.mimics["r"]
    assert (dict(mimic.multipliers), mimic.offset) == ({"p": -2.0}, 0.1)
    assert machine.active == ("p", "q")


def test_two_words_on_one_follower_have_to_agree(tmp_path: Path) -> None:
    follower = '<child link="three"/><mimic joint="p" multiplier="{}" offset="0.1"/>'
    text = FOUR_BAR.replace('<child link="three"/>', follower.format("-2"))
    assert robot(tmp_path, MIMICS["gazebo"], text).active == ("p", "q")
    text = FOUR_BAR.replace('<child link="three"/>', follower.format("3"))
    with pytest.raises(DescriptionError, match="follows 'p' here and something else in <mimic>"):
        robot(tmp_path, MIMICS["gazebo"], text)


DRIVES = {
    "transmission": '<transmission name="t" type="SimpleTransmission"><joint name="r"/>'
    '<actuator name="m"/></transmission>',
    "ros2_control": '<ros2_control><joint name="r"><command_interface name="effort"/></joint>'
    '<joint name="p"><state_interface name="position"/></joint></ros2_control>',
}


@pytest.mark.parametrize("more", DRIVES.values(), ids=DRIVES.keys())
def test_motors_of_a_robot_with_loops_are_those_of_its_transmissions(
    tmp_path: Path, more: str
) -> None:
    machine = robot(tmp_path, SHUT + more)
    assert machine.active == ("r",)
    assert "does not say what is driven" not in notes(machine)
    assert robot(tmp_path, more).active == ("p", "q", "r")  # a tree without loops


def test_rotors_of_drake_are_read(tmp_path: Path) -> None:
    actuator = (
        '<transmission><joint name="p"/><actuator name="m"><drake:rotor_inertia value="0.002"/>'
        '<drake:gear_ratio value="50"/></actuator></transmission>'
    )
    text = FOUR_BAR.replace("<robot ", '<robot xmlns:drake="http://drake.mit.edu" ')
    machine = robot(tmp_path, actuator, text)
    effect = machine.description.effects["p"]
    assert (effect.rotor_inertia, effect.gear_ratio) == (0.002, 50.0)
    with pytest.raises(DescriptionError, match="has a rotor inertia, and drives several joints"):
        robot(
            tmp_path,
            actuator.replace('<joint name="p"/>', '<joint name="p"/><joint name="q"/>'),
            text,
        )
