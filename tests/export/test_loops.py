"""URDF+ and robot.yaml: read by other programs as what they are, and files of others read."""

from __future__ import annotations

import textwrap
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio
import pytest
import yaml

from hybrid_dynamics_core import DescriptionError, Robot, load, shipped_robots
from hybrid_dynamics_core.export import to_gepetto, to_urdf, to_urdf_plus
from hybrid_dynamics_core.formats.reader import parse_description
from tests.description.test_urdf import body, joint
from tests.export.test_urdf import configuration
from tests.robots import random_states, robot
from tests.sampling import swept


@pytest.mark.parametrize("name", swept(shipped_robots()))
def test_pairs_close_in_pinocchio_where_the_robot_does(name: str) -> None:
    """Frames of the pair meet and stay together in Pinocchio, and leave as much freedom."""
    machine = robot(name)
    pair = to_gepetto(machine.description)
    model, written = pinocchio.buildModelFromXML(pair.urdf), yaml.safe_load(pair.yaml)
    data, state = model.createData(), random_states(name, 1)[0]
    q = configuration(model, dict(zip(machine.coordinates, state.s.tolist(), strict=True)))
    pinocchio.computeJointJacobians(model, data, q)
    pinocchio.updateFramePlacements(model, data)
    rows = []
    for ends, kind in zip(written["closed_loop"], written["type"], strict=True):
        one, other = (model.getFrameId(end) for end in ends)
        assert data.oMf[one].translation == pytest.approx(data.oMf[other].translation, abs=1e-9)
        around = pinocchio.LOCAL_WORLD_ALIGNED
        apart = np.subtract(
            *(pinocchio.getFrameJacobian(model, data, end, around) for end in (one, other))
        )
        rows.append(apart[: 3 if kind == "3d" else 6])
    jacobian = np.vstack(rows)
    sizes = np.linalg.svd(jacobian, compute_uv=False)
    assert int((sizes > 1e-8 * sizes[0]).sum()) == len(machine.coordinates) - len(machine.active)
    v = np.zeros(model.nv)
    for coordinate, rate in zip(machine.coordinates, state.ds, strict=True):
        v[model.joints[model.getJointId(coordinate)].idx_v] = rate
    assert jacobian @ v == pytest.approx(np.zeros(len(jacobian)), abs=1e-9)
    assert written["name_mot"] == list(machine.active)


@pytest.mark.parametrize("name", ["forging_chu2020", "gough"])
def test_urdf_plus_is_a_urdf_to_others(name: str) -> None:
    machine = robot(name)
    plus, plain = (
        pinocchio.buildModelFromXML(f(machine.description)) for f in (to_urdf_plus, to_urdf)
    )
    assert list(plus.names) == list(plain.names)
    assert [i.mass for i in plus.inertias] == [i.mass for i in plain.inertias]


def test_a_plain_urdf_says_what_is_not_in_it() -> None:
    text = to_urdf(robot("forging_chu2020").description)
    written = text[text.index("<!--") : text.index("-->")]
    assert "Loops that are cut: theta_1, theta_2, theta_3, theta_4" in written
    for words in (
        "gravity",
        "types of loops",
        "the active joints",
        "the end effector",
        "the reference configuration",
    ):
        assert words in written


Z = '<axis xyz="0 0 1"/>'
BARS = (
    '<robot name="bars">\n  <link name="ground"/>\n'
    + "".join(body(name, 1, "0.1 0 0") for name in ("crank", "coupler", "rocker", "rotor"))
    + joint("motor", "continuous", ("ground", "crank"), "", Z)
    + joint("knee", "continuous", ("crank", "coupler"), "0.1 0 0 | 0 0 -1", Z)
    + joint("hinge", "continuous", ("ground", "rocker"), "0.3 0 0 | 0 0 2", Z)
    + joint("spin", "continuous", ("ground", "rotor"), "0 0 0.1", Z)
    + '  <loop name="pin" type="revolute">\n'
    + '    <predecessor link="coupler"><origin xyz="0.3 0 0"/></predecessor>\n'
    + '    <successor link="rocker"><origin xyz="0.2 0 0"/></successor>\n'
    + '    <axis xyz="0 0 1"/>\n  </loop>\n'
    + '  <coupling name="gear">\n    <predecessor link="crank"/>\n    <successor link="rotor"/>\n'
    + '    <ratio value="6"/>\n  </coupling>\n</robot>\n'
).replace('name="motor" type', 'name="motor" independent="true" type')
for dependent in ("knee", "hinge", "spin"):
    BARS = BARS.replace(f'name="{dependent}" type', f'name="{dependent}" independent="false" type')


def read(folder: Path, text: str = BARS) -> Robot:
    path = folder / "robot.urdf"
    path.write_text(text, encoding="utf-8")
    return load(path)


def test_loops_and_couplings_of_others_are_read(tmp_path: Path) -> None:
    machine = read(tmp_path)
    assert machine.active == ("motor",)
    state = machine.close([0.9], [0.5])
    values = dict(zip(machine.coordinates, state.s, strict=True))
    assert values["spin"] == pytest.approx(5.4)
    ends = []
    for link, point in (("coupler", [0.3, 0, 0]), ("rocker", [0.2, 0, 0])):
        pose = machine.forward_kinematics(state, link)
        ends.append(pose.position + pose.rotation @ point)
    assert ends[0] == pytest.approx(ends[1], abs=1e-12)


WRONG = {
    "type": (
        'type="revolute">\n    <pred',
        'type="prismatic">\n    <pred',
        "is a loop of type 'prismatic'",
        1,
    ),
    "no end": (
        '    <successor link="rocker"><origin xyz="0.2 0 0"/></successor>\n',
        "",
        "has no <successor link=...>",
        1,
    ),
    "axis": (
        '    <axis xyz="0 0 1"/>\n  </loop>',
        '    <axis xyz="0 0 0"/>\n  </loop>',
        "loops.pin.axis: the axis has no length",
        4,
    ),
    "link": (
        '<predecessor link="coupler">',
        '<predecessor link="copler">',
        "no link 'copler' (did you mean 'coupler'?)",
        2,
    ),
    "ratio": ('<ratio value="6"/>', '<ratio value="six"/>', 'value="six"; expected a number', 9),
    "one link": (
        '<predecessor link="crank"/>',
        '<predecessor link="rotor"/>',
        "has both ends on one link",
        6,
    ),
    "nothing drives": (
        'independent="true"',
        'independent="false"',
        'no joint is independent="true"',
        None,
    ),
}


@pytest.mark.parametrize(("old", "new", "words", "below"), WRONG.values(), ids=WRONG.keys())
def test_wrong_loops_are_reported_with_their_line(
    old: str, new: str, words: str, below: int | None, tmp_path: Path
) -> None:
    assert old in BARS
    text = BARS.replace(old, new, 1)
    first = text[: text.index("<loop")].count("\n")
    with pytest.raises(DescriptionError) as caught:
        read(tmp_path, text)
    assert words in str(caught.value)
    assert below is None or caught.value.line == first + below


def test_a_follower_becomes_a_coupling_where_there_is_a_word_for_it() -> None:
    text = """
        format: 1
        name: gears
        links: {base: {}, one: {mass: 1}, two: {mass: 1}, three: {mass: 1}}
        joints:
          a: {type: revolute, parent: base, child: one, axis: z}
          b: {type: revolute, parent: base, child: two, axis: z, mimic: {joint: a, multiplier: -2}}
          c: {type: revolute, parent: two, child: three, axis: z,
              mimic: {joint: a, multiplier: 3, offset: 0.5}}
        active: [a]
        end_effector: {link: three}
    """
    root = ElementTree.fromstring(
        to_urdf_plus(parse_description(textwrap.dedent(text))).split("?>", 1)[1]
    )
    (coupling,) = root.findall("coupling")
    ends = [coupling.find(tag).get("link") for tag in ("predecessor", "successor")]
    assert (*ends, coupling.find("ratio").get("value")) == ("one", "two", "-2.0")
    mimics = {joint.get("name"): joint.find("mimic") for joint in root.findall("joint")}
    assert mimics["c"].get("offset") == "0.5"
