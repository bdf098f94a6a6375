"""Joints of SDFormat in whatever direction they are written, and of several degrees of freedom."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np
import pytest
from hypothesis import given

from hybrid_dynamics_core import DescriptionError, Robot, load
from hybrid_dynamics_core.description.geometry import rotation_about, unit_axis
from hybrid_dynamics_core.export import to_sdf
from hybrid_dynamics_core.kinematics.pose import Pose
from tests.generated.case import Case
from tests.generated.robots import STATES, examples, robots
from tests.generated.test_closure_laws import close_to, margin

BODY = (
    "<inertial><mass>1</mass>"
    "<inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial>"
)


def legs(joint: str) -> str:
    """A base, a leg on a hinge about y at its foot, and a platform on a joint between the two."""
    return f"""<sdf version="1.9"><model name="rev">
<link name="base">{BODY}</link>
<link name="leg"><pose>0 0 0.2 0 0 0</pose>{BODY}</link>
<link name="platform"><pose>0 0 0.4 0 0 0</pose>{BODY}</link>
<joint name="w" type="fixed"><parent>world</parent><child>base</child></joint>
<joint name="a" type="revolute"><parent>base</parent><child>leg</child>
<axis><xyz>0 1 0</xyz></axis></joint>
{joint}
</model></sdf>
"""


def read(folder: Path, text: str) -> Robot:
    file = folder / "model.sdf"
    file.write_text(text, encoding="utf-8")
    return load(file)


def turned_around(text: str, seed: int) -> str:
    """The same model with some joints written from their child to their parent.

    A joint without a pose of its own stands in its child; its coordinate turns the child about the
    axis, so the former parent about the opposite one.
    """
    rng = np.random.default_rng(seed)
    ElementTree.register_namespace("hybrid_dynamics", "urn:hybrid_dynamics")
    root = ElementTree.fromstring(text)
    for joint in root.iter("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent.text == "world" or rng.integers(2):
            continue
        pose = joint.find("pose")
        if pose is None:
            pose = SubElement(joint, "pose")
        if not pose.get("relative_to"):
            pose.set("relative_to", child.text)
        parent.text, child.text = child.text, parent.text
        turn_axis(joint)
    return ElementTree.tostring(root, encoding="unicode")


def turn_axis(joint: Element) -> None:
    xyz = joint.find("axis/xyz")
    if xyz is not None:
        xyz.text = " ".join(repr(-float(value)) for value in xyz.text.split())


@examples(6)
@given(robots(), STATES)
def test_the_direction_in_which_a_joint_is_written_changes_nothing(case: Case, seed: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        text = to_sdf(case.robot)
        plain = read(Path(folder), text)
        turned = read(Path(folder), turned_around(text, seed))
    assert turned.coordinates == plain.coordinates
    assert turned.description.base == plain.description.base
    s, du, ddu = case.somewhere(seed), case.rates(seed), case.rates(seed + 1)
    one, two = plain.close(s[: case.n], du), turned.close(s[: case.n], du)
    m = margin(case, s)
    assert close_to(one.s, two.s, 1e-9 / m)
    a, b = plain.inverse_dynamics(one, ddu), turned.inverse_dynamics(two, ddu)
    assert close_to(a, b, 1e-9 / m**3 * max(1.0, abs(a).max()))


BACKWARDS = """<joint name="b" type="revolute"><parent>platform</parent><child>leg</child>
<pose>0 0 0.2 0 0 0</pose><axis><xyz>0 1 0</xyz></axis></joint>"""


def test_a_joint_from_platform_to_leg_keeps_its_sign(tmp_path: Path) -> None:
    """By hand: the leg stands on (0, 0, 0.2) in its pose, the pin 0.2 m above it."""
    robot = read(tmp_path, legs(BACKWARDS))
    assert robot.coordinates == ("a", "b")
    a, b = 0.3, 0.5
    pose = robot.forward_kinematics(robot.close([a, b]), "platform")
    pin = np.array([0, 0, 0.2]) + rotation_about(unit_axis("y"), a) @ [0, 0, 0.2]
    assert pose.position == pytest.approx(pin, abs=1e-12)
    # The leg turns by b about y in the platform, so the platform by -b in the leg.
    assert pose.rotation == pytest.approx(rotation_about(unit_axis("y"), a - b), abs=1e-12)
    assert any("joint b is turned around" in note for note in robot.description.notes)


def rotations(robot: Robot, angles: Mapping[str, float]) -> np.ndarray:
    state = robot.close([angles.get(name, 0.0) for name in robot.active])
    return robot.forward_kinematics(state, "platform").rotation


UNIVERSAL = """<joint name="b" type="{type}"><parent>{parent}</parent><child>{child}</child>
<pose relative_to="platform">0 0 0 0.1 0.2 0.3</pose>
<axis><xyz>0 1 0</xyz><limit><lower>-1</lower><upper>2</upper></limit></axis>
<axis2><xyz>1 0 1</xyz><dynamics><damping>0.5</damping></dynamics></axis2></joint>"""


@pytest.mark.parametrize("kind", ["universal", "revolute2"])
@pytest.mark.parametrize("ends", [("leg", "platform"), ("platform", "leg")])
def test_a_universal_joint_is_two_hinges_in_a_row(
    kind: str, ends: tuple[str, str], tmp_path: Path
) -> None:
    """The first axis is fixed in the parent, the second in the child."""
    parent, child = ends
    robot = read(tmp_path, legs(UNIVERSAL.format(type=kind, parent=parent, child=child)))
    turn = rotation_rpy = np.eye(3)
    for axis, angle in zip("xyz", (0.1, 0.2, 0.3), strict=True):
        rotation_rpy = rotation_about(unit_axis(axis), angle) @ rotation_rpy
    turn = rotation_about(unit_axis("y"), 0.4) @ rotation_about(unit_axis([1, 0, 1]), 0.7)
    turn = rotation_rpy @ turn @ rotation_rpy.T
    if parent == "platform":
        turn = turn.T
    assert rotations(robot, {"b_1": 0.4, "b_2": 0.7}) == pytest.approx(turn, abs=1e-12)
    assert robot.description.joints["b_1"].limits == (-1.0, 2.0)
    assert robot.description.effects["b_2"].viscous == 0.5
    assert any("its coordinates: b_1, b_2" in note for note in robot.description.notes)
    joint = robot.description.multi_dof["b"]
    assert joint.type == "universal"
    assert set(joint.joints) == {"b_1", "b_2"}


def test_an_axis_that_is_not_given_is_z_with_a_note(tmp_path: Path) -> None:
    joint = """<joint name="b" type="universal"><parent>leg</parent><child>platform</child>
<axis><xyz>0 1 0</xyz></axis></joint>"""
    robot = read(tmp_path, legs(joint))
    assert robot.coordinates == ("a", "b_1", "b_2")
    assert "model.sdf:8: joint b has no <axis2>; taken: 0 0 1" in robot.description.notes


@pytest.mark.parametrize("ends", [("leg", "platform"), ("platform", "leg")])
def test_a_ball_joint_stands_at_every_orientation(ends: tuple[str, str], tmp_path: Path) -> None:
    parent, child = ends
    joint = (
        f"""<joint name="b" type="ball"><parent>{parent}</parent><child>{child}</child></joint>"""
    )
    robot = read(tmp_path, legs(joint))
    for quaternion in ([0.6, 0, 0, 0.8], [0, 0.5**0.5, 0, 0.5**0.5], [0.5, 0.5, 0.5, -0.5]):
        pose = Pose.from_quaternion([0, 0, 0], quaternion)
        state = robot.close_at_poses({"b": pose})
        assert robot.joint_pose(state, "b").rotation == pytest.approx(pose.rotation, abs=1e-14)


def test_a_ball_joint_has_three_angles(tmp_path: Path) -> None:
    joint = """<joint name="b" type="ball"><parent>leg</parent><child>platform</child>
<axis><xyz>0 1 0</xyz></axis></joint>"""
    robot = read(tmp_path, legs(joint))
    x, y, z = (rotation_about(unit_axis(axis), 0.3) for axis in "xyz")
    angles = {"b_X": 0.3, "b_Y": 0.3, "b_Z": 0.3}
    assert rotations(robot, angles) == pytest.approx(x @ y @ z, abs=1e-12)
    assert "model.sdf:9: <axis> of joint b is left out: it is of type ball" in (
        robot.description.notes
    )
    damped = joint.replace("</xyz>", "</xyz><dynamics><friction>1</friction></dynamics>")
    with pytest.raises(DescriptionError, match="has friction on a ball joint"):
        read(tmp_path, legs(damped))


@pytest.mark.parametrize(
    ("word", "lead"),
    [
        ("<screw_thread_pitch>0.02</screw_thread_pitch>", 0.02),
        ("<thread_pitch>-314.1592653589793</thread_pitch>", 0.02),
    ],
)
def test_a_screw_moves_along_its_axis_as_it_turns(word: str, lead: float, tmp_path: Path) -> None:
    joint = f"""<joint name="b" type="screw"><parent>leg</parent><child>platform</child>
<axis><xyz>0 0 1</xyz></axis>{word}</joint>"""
    robot = read(tmp_path, legs(joint))
    assert robot.active == ("a", "b")
    at_start, turned = (
        robot.forward_kinematics(robot.close([0.0, angle]), "platform").position
        for angle in (0.0, 2.0 * np.pi)
    )
    assert turned - at_start == pytest.approx([0, 0, lead], abs=1e-12)


def test_links_that_no_joint_connects_stand_still_where_they_are_drawn(tmp_path: Path) -> None:
    robot = read(tmp_path, legs(""))
    pose = robot.forward_kinematics(robot.close([0.3]), "platform")
    assert pose.position == pytest.approx([0, 0, 0.4], abs=1e-12)
    words = "platform: not joined to the world; taken as standing still on it"
    assert words in robot.description.notes


NOTED = {  # what is left out, and the note that says so
    "<collision name='v'/>": "<collision> is left out (line 2)",
    "<sensor name='s' type='imu'/>": "<sensor> is left out (line 2)",
    "<others:word>1</others:word>": "<others:word> is left out (line 2)",
}


@pytest.mark.parametrize(("word", "note"), NOTED.items())
def test_what_is_left_out_is_noted_with_its_line(word: str, note: str, tmp_path: Path) -> None:
    text = legs(BACKWARDS).replace('<link name="base">', f'<link name="base">{word}')
    text = text.replace("</model>", "</model><light name='l'/>").replace(
        "<sdf ", '<sdf xmlns:others="urn:o" '
    )
    notes = read(tmp_path, text).description.notes
    assert note in notes
    assert "model.sdf:10: <light> beside the model is left out" in notes


def test_limits_of_a_continuous_joint_are_noted(tmp_path: Path) -> None:
    text = legs(BACKWARDS).replace(
        'type="revolute"><parent>base</parent>', 'type="continuous"><parent>base</parent>'
    )
    limit = "<xyz>0 1 0</xyz><limit><lower>-1</lower><upper>1e16</upper></limit>"
    text = text.replace("<xyz>0 1 0</xyz>", limit, 1)
    notes = read(tmp_path, text).description.notes
    assert "model.sdf:7: <lower> of joint a is left out: it is of type continuous" in notes
    assert not any("<upper>" in note for note in notes)


def test_ties_in_words_of_drake_are_refused(tmp_path: Path) -> None:
    tie = '<drake:ball_constraint xmlns:drake="urn:d"/>'
    with pytest.raises(DescriptionError, match="<drake:ball_constraint> is not covered"):
        read(tmp_path, legs(BACKWARDS + tie))


LEANING = """<joint name="b" type="revolute"><parent>leg</parent><child>platform</child>
<pose>0 0 0 0.5 0 0</pose><axis><xyz>0 0 1</xyz>WORD</axis></joint>"""
IN_THE_JOINT = [0.0, -np.sin(0.7), np.cos(0.7)]  # leant by 0.2 with the platform, 0.5 with itself
FRAMES = {  # version and word, and where the axis stands in the world
    ("1.4", ""): [0.0, 0.0, 1.0],
    ("1.6", ""): IN_THE_JOINT,
    ("1.6", "<use_parent_model_frame>1</use_parent_model_frame>"): [0.0, 0.0, 1.0],
    ("1.6", "<use_parent_model_frame>0</use_parent_model_frame>"): IN_THE_JOINT,
    ("1.7", ""): IN_THE_JOINT,
}


@pytest.mark.parametrize(("case", "axis"), FRAMES.items())
def test_the_version_says_in_what_frame_an_axis_is(
    case: tuple[str, str], axis: list[float], tmp_path: Path
) -> None:
    version, word = case
    text = legs(LEANING.replace("WORD", word)).replace('version="1.9"', f'version="{version}"')
    text = text.replace("<pose>0 0 0.4 0 0 0</pose>", "<pose>0 0 0.4 0.2 0 0</pose>")
    robot = read(tmp_path, text)
    start = rotations(robot, {})
    turned = rotations(robot, {"b": 0.6})
    expected = rotation_about(unit_axis(axis), 0.6) @ start
    assert turned == pytest.approx(expected, abs=1e-12)


def test_a_name_of_a_link_and_a_joint_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match=r"joints\.leg: has the name of a link"):
        read(tmp_path, legs(BACKWARDS.replace('name="b"', 'name="leg"')))


def test_gravity_of_an_older_world_stands_in_its_physics(tmp_path: Path) -> None:
    model = legs(BACKWARDS).replace('version="1.9"', 'version="1.4"')
    world = '<world name="w"><physics type="ode"><gravity>0 0 -3</gravity></physics>'
    text = model.replace("<model ", f"{world}<model ").replace("</model>", "</model></world>")
    assert read(tmp_path, text).description.gravity == pytest.approx([0, 0, -3])


def test_gravity_hangs_down_however_the_model_stands(tmp_path: Path) -> None:
    """A model without a world too: turned by 0.1 as a model, and by 0.2 as its base link."""
    text = legs(BACKWARDS)
    leaning = '<pose>0 0 0 0.1 0 0</pose><link name="base"><pose>0 0 0 0.2 0 0</pose>'
    text = text.replace('<link name="base">', leaning)
    gravity = read(tmp_path, text).description.gravity
    assert gravity == pytest.approx([0.0, -9.81 * np.sin(0.3), -9.81 * np.cos(0.3)])


# Words of the specification, with a value that is not the default:
WORDS = {
    "model": (
        "<static>1</static> <self_collide>1</self_collide> <enable_wind>1</enable_wind>"
        " <allow_auto_disable>0</allow_auto_disable> <pose>1;0;0;0.1;0;0</pose> <include/>"
        " <model/> <frame;name='f'/> <plugin/> <gripper/>"
    ),
    "link": (
        "<gravity>0</gravity> <enable_wind>1</enable_wind> <self_collide>1</self_collide>"
        " <kinematic>1</kinematic> <must_be_base_link>1</must_be_base_link>"
        " <velocity_decay><linear>1</linear></velocity_decay> <collision/> <visual/> <sensor/>"
        " <projector/> <audio_sink/> <audio_source/> <battery/> <light/> <particle_emitter/>"
        " <plugin/> <unknown/>"
    ),
    "inertial": (
        "<density>3</density> <fluid_added_mass><xx>3</xx></fluid_added_mass>"
        " <pose>0.1;0;0;0;0;0</pose> <auto_inertia_params/> <unknown/>"
    ),
    "joint": (
        "<gearbox_ratio>3</gearbox_ratio> <gearbox_reference_body>leg</gearbox_reference_body>"
        " <thread_pitch>3</thread_pitch> <screw_thread_pitch>3</screw_thread_pitch> <axis2/>"
        " <physics/> <sensor/> <plugin/> <pose>0.1;0;0;0.1;0;0</pose> <unknown/>"
    ),
    "axis": (
        "<initial_position>1</initial_position> <limit><lower>-1</lower></limit>"
        " <limit><upper>1</upper></limit> <limit><effort>3</effort></limit>"
        " <limit><velocity>3</velocity></limit> <limit><stiffness>3</stiffness></limit>"
        " <limit><dissipation>3</dissipation></limit> <dynamics><damping>3</damping></dynamics>"
        " <dynamics><friction>3</friction></dynamics> <mimic;joint='b'/>"
        " <dynamics><spring_stiffness>3</spring_stiffness></dynamics>"
        " <use_parent_model_frame>1</use_parent_model_frame> <unknown/>"
    ),
}
CASES = [
    (around, word.replace(";", " ")) for around, words in WORDS.items() for word in words.split()
]


@pytest.mark.parametrize(("around", "word"), CASES)
def test_no_word_is_passed_over_in_silence(around: str, word: str, tmp_path: Path) -> None:
    """It changes the robot, or stands in the notes, or is refused."""
    text = legs(BACKWARDS)
    plain = read(tmp_path, text).description
    position = text.index(">", text.index('<joint name="a"' if around == "joint" else f"<{around}"))
    with_word = text[: position + 1] + word + text[position + 1 :]
    try:
        robot = read(tmp_path, with_word).description
    except DescriptionError:
        return
    is_noted = set(robot.notes) != set(plain.notes)
    parts = ("joints", "links", "frames", "effects", "mimics")
    is_changed = any(not same(vars(robot)[part], vars(plain)[part]) for part in parts)
    assert is_noted or is_changed or not np.array_equal(robot.gravity, plain.gravity)


def same(one: Mapping, other: Mapping) -> bool:
    return {name: str(vars(entry)) for name, entry in one.items()} == {
        name: str(vars(entry)) for name, entry in other.items()
    }


AS_IT_IS = {
    "a kinematic base": (
        f'<link name="base">{BODY}',
        f'<link name="base"><kinematic>1</kinematic>{BODY}',
    ),
    "the link that it has anyway": ("<inertial>", '<inertial><pose relative_to="base"/>'),
    "a frame said twice": (
        "<axis><xyz>0 1 0</xyz>",
        (
            '<axis><xyz expressed_in="__model__">0 1 0</xyz>'
            "<use_parent_model_frame>1</use_parent_model_frame>"
        ),
    ),
    "a link that is the world": ('<link name="base">', '<link name="world"/><link name="base">'),
}


@pytest.mark.parametrize("kind", AS_IT_IS)
def test_words_that_change_nothing_are_read(tmp_path: Path, kind: str) -> None:
    """Words that other programs write, and that say what holds anyway."""
    text = legs("")
    before, after = AS_IT_IS[kind]
    assert before in text
    plain, changed = read(tmp_path, text), read(tmp_path, text.replace(before, after, 1))
    assert changed.coordinates == plain.coordinates
    state = plain.close([0.3], [0.7])
    assert np.array_equal(
        changed.inverse_dynamics(changed.close([0.3], [0.7]), [2.0]),
        plain.inverse_dynamics(state, [2.0]),
    )


def test_a_link_named_world_that_joints_move_is_refused(tmp_path: Path) -> None:
    text = legs("").replace('"leg"', '"world"').replace(">leg<", ">world<")
    with pytest.raises(DescriptionError, match="is a name that SDFormat reserves"):
        read(tmp_path, text)
