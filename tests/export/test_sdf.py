"""SDFormat: the tree in another engine, the drawn configuration, and files of others."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from hybrid_dynamics_core import DescriptionError, InputError, Robot, load, shipped_robots
from hybrid_dynamics_core.export import to_sdf
from hybrid_dynamics_core.formats.reader import parse_description
from tests.robots import robot
from tests.sampling import swept

# what links of 1e-9 kg, which stand for massless ones, may change of the smallest shipped robot
MASSLESS = 1e-6


def zero_places(root: ElementTree.Element) -> dict[str, float]:
    """Where the file counts coordinates from, by its own words."""
    (extras,) = (element for element in root.iter() if element.tag.endswith("}hybrid_dynamics"))
    lines = (extras.text or "").splitlines()
    actual = next((line for line in lines if line.startswith("zero:")), "zero: {}")
    pairs = [pair.split(": ") for pair in actual[len("zero: {") : -1].split(", ") if pair]
    return {name: float(value) for name, value in pairs}


@pytest.mark.parametrize(
    "name", [name for name in shipped_robots() if name != "staicu2015"]
)  # which has no masses
def test_another_engine_finds_the_same_tree(name: str) -> None:
    """Drake reads no loops: their joints are taken out.

    Poses, masses and weights away from the drawn configuration.
    """
    parsing = pytest.importorskip("pydrake.multibody.parsing")
    from pydrake.multibody.plant import MultibodyPlant

    machine = robot(name)
    root = ElementTree.fromstring(to_sdf(machine))
    (model,) = root.iter("model")
    for joint in list(model.findall("joint")):
        if joint.get("name") in {closure.name for closure in machine.description.closures}:
            model.remove(joint)
    plant = MultibodyPlant(0.0)
    parsing.Parser(plant).AddModelsFromString(ElementTree.tostring(root, encoding="unicode"), "sdf")
    plant.Finalize()
    state = machine.close(machine.reference + 0.01)
    zero, context = zero_places(root), plant.CreateDefaultContext()
    q = plant.GetPositions(context)
    for joint, value in zip(machine.coordinates, state.s, strict=True):
        q[plant.GetJointByName(joint).position_start()] = value - zero.get(joint, 0.0)
    plant.SetPositions(context, q)
    for frame in machine.frames:
        pose, actual = (
            machine.forward_kinematics(state, frame),
            plant.GetFrameByName(frame).CalcPoseInWorld(context),
        )
        assert actual.translation() == pytest.approx(pose.position, abs=1e-12)
        assert actual.rotation().matrix() == pytest.approx(pose.rotation, abs=1e-12)
    order = [plant.GetJointByName(joint).velocity_start() for joint in machine.coordinates]
    expected = machine.spanning_terms(state)
    mass = plant.CalcMassMatrix(context)[np.ix_(order, order)]
    assert np.abs(mass - expected.M).max() < MASSLESS * np.abs(expected.M).max()
    weight = -plant.CalcGravityGeneralizedForces(context)[
        order
    ]  # at 9.81 m/s^2, as every shipped robot
    assert np.abs(weight - expected.g).max() < MASSLESS * max(1.0, float(np.abs(expected.g).max()))


@pytest.mark.parametrize("name", swept(shipped_robots()))
def test_every_loop_joint_is_at_zero_where_the_model_is_drawn(name: str) -> None:
    """Both of its links put its frame at one place: what SDFormat wants of a joint at zero."""
    machine = robot(name)
    state = machine.close(machine.reference)
    (model,) = ElementTree.fromstring(to_sdf(machine)).iter("model")
    for closure in machine.description.closures:
        joint = next(joint for joint in model.findall("joint") if joint.get("name") == closure.name)
        assert {joint.findtext("parent"), joint.findtext("child")} == {
            closure.link_a,
            closure.link_b,
        }
        ends = [
            machine.forward_kinematics(state, link).position
            + machine.forward_kinematics(state, link).rotation @ point
            for link, point in (
                (closure.link_a, closure.point_a),
                (closure.link_b, closure.point_b),
            )
        ]
        assert ends[0] == pytest.approx(ends[1], abs=1e-9)


FOUR_BAR = """<?xml version="1.0"?>
<sdf version="1.9">
  <model name="bars">
    <frame name="floor" attached_to="ground"><pose>0 0 0 0 0 0.3</pose></frame>
    <link name="ground"/>
    <link name="crank"><pose relative_to="motor"/>
      <inertial><mass>2</mass><pose>0.1 0 0 0 0 0</pose>
        <inertia><ixx>0.01</ixx><iyy>0.02</iyy><izz>0.02</izz></inertia></inertial></link>
    <link name="coupler"><pose relative_to="crank" degrees="true">0.2 0.1 0 0 0 -90</pose></link>
    <link name="rocker">
      <pose relative_to="floor" rotation_format="quat_xyzw">0.2 -0.1 0 0 0 0 1</pose></link>
    <joint name="anchor" type="fixed"><parent>world</parent><child>ground</child></joint>
    <joint name="motor" type="revolute">
      <pose relative_to="floor"/><parent>ground</parent><child>crank</child>
      <axis><xyz expressed_in="floor">0 0 2</xyz><limit><lower>-1</lower><upper>inf</upper></limit>
        <dynamics><damping>0.5</damping></dynamics></axis></joint>
    <joint name="knee" type="revolute"><pose relative_to="crank">0.2 0 0 0 0 0</pose>
      <parent>crank</parent><child>coupler</child><axis><xyz>0 0 1</xyz></axis></joint>
    <joint name="hinge" type="revolute"><parent>floor</parent><child>rocker</child>
      <axis><xyz>0 0 -1</xyz></axis></joint>
    <joint name="pin" type="revolute"><pose relative_to="coupler">0.1 0.3 0 0 0 0</pose>
      <parent>coupler</parent><child>rocker</child><axis><xyz>0 0 1</xyz></axis></joint>
  </model>
</sdf>
"""


def read(folder: Path, text: str = FOUR_BAR) -> Robot:
    path = folder / "model.sdf"
    path.write_text(text, encoding="utf-8")
    return load(path)


def test_one_link_is_without_gravity(tmp_path: Path) -> None:
    """The weight of the others stays: less that of the crank, as a force that lifts it."""
    leaning = FOUR_BAR.replace("0 0 0 0 0 0.3", "0 0 0 1 0 0.3")
    plain = read(tmp_path, leaning)
    less = read(tmp_path, leaning.replace(CRANK, f"{CRANK}<gravity>0</gravity>"))
    assert any("<gravity> of crank is off" in note for note in less.description.notes)
    state = plain.close([0.3])
    force = -2.0 * plain.description.gravity
    arm = plain.forward_kinematics(state, "crank").rotation @ [0.1, 0, 0]
    lifted = plain.loads.with_wrench([*force, *np.cross(arm, force)], "crank")
    expected = plain.inverse_dynamics(state, [0.4], lifted)
    assert abs(expected - plain.inverse_dynamics(state, [0.4]))[0] > 0.1
    assert less.inverse_dynamics(less.close([0.3]), [0.4]) == pytest.approx(expected, rel=1e-12)


def test_a_file_of_others_closes_where_it_is_drawn(tmp_path: Path) -> None:
    """Frames, joints off their links' frames, axes given elsewhere, degrees and quaternions."""
    machine = read(tmp_path)
    assert (machine.name, machine.description.base, machine.active) == (
        "bars",
        "ground",
        ("motor",),
    )
    state = machine.close([0.0])
    assert state.s == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    turn = np.array([[np.cos(0.3), -np.sin(0.3), 0], [np.sin(0.3), np.cos(0.3), 0], [0, 0, 1]])
    coupler = machine.forward_kinematics(state, "coupler")
    assert coupler.position == pytest.approx(turn @ [0.2, 0.1, 0.0], abs=1e-12)
    moved = machine.close([0.2])
    knee = machine.forward_kinematics(moved, "coupler")
    knee_axis = (
        knee.rotation @ [0.1, 0.0, 0.0] + knee.position
    )  # the knee's axis, seen from the coupler's frame
    crank = machine.forward_kinematics(moved, "crank")
    assert knee_axis == pytest.approx(crank.rotation @ [0.2, 0, 0] + crank.position, abs=1e-12)
    assert machine.limits[0] == pytest.approx([-1, np.inf])
    assert machine.description.effects["motor"].viscous == 0.5
    assert (
        "coupler: no inertial given; SDFormat takes 1 kg and 1 kg m^2" in machine.description.notes
    )
    assert any("SDFormat does not say what is driven" in note for note in machine.description.notes)


WRONG = {
    "gearbox": (
        'name="hinge" type="revolute"',
        'name="hinge" type="gearbox"',
        "joints.hinge: has no <gearbox_reference_body>",
    ),
    "no such type": (
        'name="hinge" type="revolute"',
        'name="hinge" type="helix"',
        "joints.hinge.type: is 'helix'; expected fixed, revolute",
    ),
    "link": (
        "<child>crank",
        "<child>cranc",
        "there is no link, joint or frame 'cranc' (did you mean 'crank'?)",
    ),
    "number": ("0.1 0.3 0 0 0 0", "0.1 0.3 0 0", "expected 6 numbers"),
    "round": ('<pose relative_to="motor"/>', '<pose relative_to="knee"/>', "its pose goes round"),
    "roots": ("<parent>crank</parent>", "<parent>crank</parent><!--", "not valid XML"),
    "nowhere": ("<link name=", "<include/><link name=", "include: has no <uri>; expected model://"),
}


@pytest.mark.parametrize(("old", "new", "words"), WRONG.values(), ids=WRONG.keys())
def test_what_is_not_covered_is_reported(old: str, new: str, words: str, tmp_path: Path) -> None:
    assert old in FOUR_BAR
    with pytest.raises(DescriptionError) as caught:
        read(tmp_path, FOUR_BAR.replace(old, new, 1))
    assert words in str(caught.value)
    assert str(tmp_path / "model.sdf") in str(caught.value)


MODEL, PIN = '<model name="bars">', '<joint name="pin" type="revolute">'
CRANK, MASS, AXIS = '<link name="crank">', "<mass>2</mass>", '<axis><xyz expressed_in="floor">'
# the robot is another one, or the axes are: (what stands there, what is put behind or before it,
# words)
CHANGED = {
    "version 1.1": ('version="1.9"', 'version="1.1"', "version: is '1.1'; expected 1.2 or later"),
    "no version": (' version="1.9"', "", "version: is ''; expected 1.2 or later"),
    "no number": ('version="1.9"', 'version="new"', "version: is 'new'; expected 1.2 or later"),
    "axis in the model": (
        AXIS,
        f"<axis><use_parent_model_frame>1</use_parent_model_frame>{AXIS[6:]}",
        (
            "joints.motor: <use_parent_model_frame> of <axis> is '1', which is not covered;"
            " expected 'false'"
        ),
    ),
    "static": (MODEL, f"{MODEL}<static>1</static>", "models.bars: <static> of <model> is '1'"),
    "kinematic": (
        CRANK,
        f"{CRANK}<kinematic>true</kinematic>",
        "links.crank: <kinematic> of <link> is 'true', but joints move it; take it out",
    ),
    "floating": (
        CRANK,
        f"{CRANK}<must_be_base_link>true</must_be_base_link>",
        "<must_be_base_link> of <link> is 'true'",
    ),
    "fluid": (
        MASS,
        f"{MASS}<fluid_added_mass><xx>100</xx></fluid_added_mass>",
        "links.crank: <xx> of <fluid_added_mass> is '100', which is not covered; expected '0'",
    ),
    "mass of shapes": (
        "<inertial>",
        '<inertial auto="true">',
        'links.crank: has auto="true" and a <mass>; expected one of them',
    ),
    "place of a mass": (
        f"{MASS}<pose>",
        f'{MASS}<pose relative_to="floor">',
        "links.crank: the <pose> of <inertial> is always in its link; leave out relative_to",
    ),
    "place of the model": (
        MODEL,
        f'{MODEL}<pose relative_to="hill">0 0 0 1 0 0</pose>',
        "relative_to of <pose>",
    ),
    "place of a frame of it": (
        MODEL,
        '<model name="bars" placement_frame="cranck">',
        "there is no link, joint or frame 'cranck' (did you mean 'crank'?)",
    ),
    "no such carrier": (
        MODEL,
        '<model name="bars" canonical_link="grund"><frame name="f"/>',
        "(did you mean 'ground'?)",
    ),
    "unknown": (
        CRANK,
        f"{CRANK}<buoyancy>1</buoyancy>",
        "links.crank: <buoyancy> is not covered; it may change",
    ),
    "welded in the world": (
        MODEL,
        f'<world name="w"><joint name="weld" type="fixed"/>{MODEL}',
        "joints.weld: has no <parent>",
    ),
}


@pytest.mark.parametrize(("old", "new", "words"), CHANGED.values(), ids=CHANGED.keys())
def test_what_would_change_the_robot_is_refused_with_its_line(
    old: str, new: str, words: str, tmp_path: Path
) -> None:
    assert old in FOUR_BAR
    text = FOUR_BAR.replace(old, new, 1)
    if "<world" in new:
        text = text.replace("</model>", "</model></world>")
    with pytest.raises(DescriptionError) as caught:
        read(tmp_path, text)
    assert words in str(caught.value)
    assert caught.value.line == FOUR_BAR[: FOUR_BAR.index(old)].count("\n") + 1


HARMLESS = {  # what others write beside a robot, and words that say what is so anyway
    MODEL: (
        f'{MODEL}<static>0</static><self_collide>true</self_collide><plugin name="p"'
        ' filename="f"><x/></plugin>'
    ),
    '<link name="ground"/>': (
        '<link name="ground"><gravity/><visual name="v"><anything/></visual></link>'
    ),
    CRANK: (
        f"{CRANK}<gravity>true</gravity><kinematic>false</kinematic><others:word>1</others:word><velocity_decay><linear>0.0</linear></velocity_decay><sensor"
        ' name="s" type="imu"/><collision name="c"/>'
    ),
    "<inertial>": (
        '<inertial auto="false"><fluid_added_mass><xx>0</xx><qr>0.0</qr></fluid_added_mass>'
    ),
    "<lower>-1</lower>": "<lower>-1</lower><effort>5</effort><velocity>-1</velocity>",
}


def test_what_changes_no_robot_is_ignored(tmp_path: Path) -> None:
    text = FOUR_BAR
    for old, new in HARMLESS.items():
        assert old in text
        text = text.replace(old, new, 1)
    machine, other = read(tmp_path), read(tmp_path, text)
    state, actual = machine.close([0.2], [0.5]), other.close([0.2], [0.5])
    np.testing.assert_array_equal(actual.s, state.s)
    np.testing.assert_array_equal(
        other.inverse_dynamics(actual, [1.0]), machine.inverse_dynamics(state, [1.0])
    )


def on_the_pin(words: str) -> str:
    """The four-bar with more on the axis of the joint that closes its loop."""
    head, tail = FOUR_BAR.split('name="pin"')
    return f'{head}name="pin"{tail.replace("<axis>", f"<axis>{words}", 1)}'


def test_limits_of_a_joint_that_closes_a_loop_are_noted(tmp_path: Path) -> None:
    machine = read(tmp_path, on_the_pin("<limit><lower>-1</lower><upper>2</upper></limit>"))
    assert "pin: closes a loop; its limits are not kept" in machine.description.notes


def test_a_joint_with_friction_belongs_to_the_tree(tmp_path: Path) -> None:
    """A closure has no friction, so a loop is cut at a joint without."""
    damped = on_the_pin("<dynamics><damping>1</damping></dynamics>")
    machine, plain = read(tmp_path, damped), read(tmp_path)
    (closure,) = machine.description.closures
    assert closure.name != "pin"
    assert machine.description.effects["pin"].viscous == 1.0
    still, same = machine.close([0.2]), plain.close([0.2])
    assert machine.inverse_dynamics(still, [1.0]) == pytest.approx(
        plain.inverse_dynamics(same, [1.0]), rel=1e-9
    )


def test_a_frame_of_the_model_moves_with_its_canonical_link(tmp_path: Path) -> None:
    text = FOUR_BAR.replace(MODEL, '<model name="bars" canonical_link="crank"><frame name="mark"/>')
    assert read(tmp_path, text).description.frames["mark"].link == "crank"
    plain = read(tmp_path, FOUR_BAR.replace(MODEL, f'{MODEL}<frame name="mark"/>'))
    assert plain.description.frames["mark"].link == "ground"


def test_names_that_the_format_keeps_are_refused() -> None:
    text = "format: 1\nname: r\nlinks: {base: {}, world: {mass: 1}}\n"
    text += (
        "joints: {q: {type: revolute, parent: base, child: world, axis: z}}\nactive:"
        " [q]\nend_effector: {link: world}\n"
    )
    with pytest.raises(InputError, match="'world' is a name that SDFormat keeps for itself"):
        to_sdf(Robot(parse_description(text)))


def test_a_name_of_two_things_is_refused_with_both() -> None:
    text = "format: 1\nname: r\nlinks: {base: {}, crank: {mass: 1}}\n"
    text += (
        "joints: {crank: {type: revolute, parent: base, child: crank, axis: z}}\nactive: [crank]\n"
    )
    text += "end_effector: {link: crank}\n"
    said = (
        "'crank' names two things, a link and a joint, which SDFormat refuses; rename one of them"
        " in the robot"
    )
    with pytest.raises(InputError, match=said):
        to_sdf(Robot(parse_description(text)))


@pytest.mark.parametrize("name", ["five_bar", "type_c"])
def test_links_that_sdf_has_words_for_are_not_written_twice(name: str) -> None:
    _, _, extras = to_sdf(load(name)).rpartition("<hybrid_dynamics:hybrid_dynamics>")
    assert "links:\n  base: {}\nzero:" in extras  # only a base without mass is no link of SDF
