"""URDF with closures: poses and masses of an independent engine, and errors in files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from hybrid_dynamics_core import DescriptionError, load
from hybrid_dynamics_core.formats import read_description, read_urdf
from tests.description.oracle import close, frame_pose, freedom, gaps, mass_matrix


def body(name: str, mass: float, com: str = "0 0 0", rpy: str = "0 0 0", more: str = "") -> str:
    """A link of a URDF with a mass and some inertia."""
    values = {"xx": 0.01, "yy": 0.02, "zz": 0.02, "xy": 0.001, "xz": -0.002, "yz": 0.003}
    moments = " ".join(f'i{key}="{value * mass}"' for key, value in values.items())
    inertial = f'<origin xyz="{com}" rpy="{rpy}"/><mass value="{mass}"/><inertia {moments}/>'
    return f'  <link name="{name}"><inertial>{inertial}</inertial>{more}</link>\n'


def joint(name: str, kind: str, ends: tuple[str, str], origin: str = "", more: str = "") -> str:
    """A joint of a URDF; `origin`: 'xyz' or 'xyz | rpy'."""
    xyz, _, rpy = (part.strip() for part in origin.partition("|"))
    where = f'<origin xyz="{xyz}" rpy="{rpy or "0 0 0"}"/>' if origin else ""
    parent, child = ends
    inside = f'<parent link="{parent}"/><child link="{child}"/>{where}{more}'
    return f'  <joint name="{name}" type="{kind}">{inside}</joint>\n'


LIMITS = '<limit lower="-1.5" upper="2" effort="10" velocity="1"/>'
NO_LIMITS = '<limit lower="0" upper="0" effort="10" velocity="1"/>'
ARM = (
    '<?xml version="1.0"?>\n<robot name="invented arm">\n  <material name="grey"/>\n  <link'
    ' name="world"/>\n'
    + body("stand", 30)
    + body("upper-arm", 4, "0.1 0.02 -0.03", "0.3 -0.2 0.7", "<visual><geometry/></visual>")
    + body("plate", 1.5, "0 0 0.1")
    + body("slide", 2)
    + '  <link name="massless"/>\n'
    + body("tool", 0.5)
    + joint("to_stand", "fixed", ("world", "stand"), "0 0 0.4 | 0 0 0.3")
    + joint(
        "shoulder",
        "revolute",
        ("stand", "upper-arm"),
        "0.1 0 0.2 | 0.1 0.2 0.3",
        f'<axis xyz="0 2 0"/>{LIMITS}',
    )
    + joint("to_plate", "fixed", ("upper-arm", "plate"), "0.3 0 0 | 0 1 0")
    + joint("rail", "prismatic", ("plate", "slide"), "0 0.1 0", NO_LIMITS)
    + joint("wrist", "continuous", ("slide", "massless"), "", '<axis xyz="0 0.6 0.8"/>')
    + joint("roll", "continuous", ("massless", "tool"), "0 0 0.05", '<axis xyz="0 0 1"/>')
    + "</robot>\n"
)
JOINTS = ["shoulder", "rail", "wrist", "roll"]


def write(folder: Path, text: str, name: str = "robot.urdf") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def pinocchio_state(text: str, s: dict[str, float]) -> tuple[pin.Model, pin.Data]:
    """Pinocchio's model of a URDF at joint values s."""
    model = pin.buildModelFromXML(text)
    q = pin.neutral(model)
    for name, value in s.items():
        joint = model.joints[model.getJointId(name)]
        q[joint.idx_q : joint.idx_q + joint.nq] = (
            [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
        )
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    pin.crba(model, data, q)
    return model, data


def test_poses_and_masses_are_pinocchios(tmp_path: Path) -> None:
    """Also of links on fixed joints, whose bodies are merged."""
    robot = read_urdf(write(tmp_path, ARM))
    assert list(robot.joints) == JOINTS
    assert list(robot.links) == ["world", "upper-arm", "slide", "massless", "tool"]
    s = {"shoulder": 0.7, "rail": 0.12, "wrist": -1.1, "roll": 2.2}
    model, data = pinocchio_state(ARM, s)
    for link in ("stand", "upper-arm", "plate", "slide", "massless", "tool"):
        expected = data.oMf[model.getFrameId(link)].homogeneous
        assert frame_pose(robot, link, s) == pytest.approx(expected, abs=1e-14)
    matrix = np.triu(data.M) + np.triu(data.M, 1).T
    order = [model.joints[model.getJointId(name)].idx_v for name in JOINTS]
    assert mass_matrix(robot, s, JOINTS) == pytest.approx(matrix[np.ix_(order, order)], abs=1e-8)


def test_what_is_taken_without_being_said(tmp_path: Path) -> None:
    robot = read_urdf(write(tmp_path, ARM))
    assert robot.name == "invented arm"
    assert robot.base == "world"
    assert robot.active == tuple(JOINTS)
    assert robot.frames["end_effector"].link == "tool"
    assert any("taken: 'tool', the link behind the most joints" in note for note in robot.notes)
    assert robot.joints["shoulder"].limits == (-1.5, 2)
    assert robot.joints["rail"].limits == (-np.inf, np.inf)  # exporters write 0, 0 for no limits
    assert robot.joints["wrist"].limits == (-np.inf, np.inf)
    assert robot.joints["rail"].axis == pytest.approx([1, 0, 0])
    assert robot.joints["shoulder"].axis == pytest.approx([0, 1, 0])
    assert read_description(tmp_path / "robot.urdf").active == robot.active


Z = '<axis xyz="0 0 1"/>'
BARS = (
    '<robot name="bars">\n  <link name="ground"/>\n'
    + body("crank", 1, "0.05 0 0")
    + body("coupler", 2, "0.15 0 0")
    + body("rocker", 2, "0.1 0 0")
    + '  <link name="end_A"/>\n  <link name="end_B"/>\n'
    + joint("motor", "continuous", ("ground", "crank"), "", Z)
    + joint("knee", "continuous", ("crank", "coupler"), "0.1 0 0 | 0 0 -1", Z)
    + joint("hinge", "continuous", ("ground", "rocker"), "0.3 0 0 | 0 0 2", Z)
    + joint("A", "fixed", ("coupler", "end_A"), "0.3 0 0")
    + joint("B", "fixed", ("rocker", "end_B"), "0.2 0 0")
    + "</robot>\n"
)
PIN = {"pin": {"kind": "point", "between": {"end_A": [0, 0, 0], "end_B": [0, 0, 0]}}}


def test_closures_on_a_urdf(tmp_path: Path) -> None:
    tip = {"link": "rocker", "xyz": [0.2, 0, 0]}
    robot = read_urdf(write(tmp_path, BARS), PIN, ["motor"], tip, reference={"motor": 1})
    (closure,) = robot.closures
    assert (closure.link_a, closure.link_b) == ("coupler", "rocker")
    assert closure.point_a == pytest.approx([0.3, 0, 0])
    s = close(robot, {"motor": 1.0}, {})
    assert np.abs(gaps(robot, s)).max() < 1e-13
    assert freedom(robot, s) == 1
    assert robot.reference == {"motor": 1}


FORMAT = """\
format: 1
name: bars
urdf: robot.urdf
closures:
  pin: {kind: planar, between: {end_A: [0, 0, 0], rocker: [0.2, 0, 0]}, assembly: counterclockwise}
links: {flag: {mass: 0.1}}
joints: {extra: {type: fixed, parent: end_B, child: flag, origin: {xyz: [0, 0, 0.1]}}}
active: [motor]
end_effector: {link: flag}
reference: {motor: 1, knee: 0.3}
"""


def test_a_description_names_its_urdf_and_adds_to_it(tmp_path: Path) -> None:
    write(tmp_path, BARS)
    robot = read_description(write(tmp_path, FORMAT, "bars.yaml"))
    assert robot.base == "ground"
    assert robot.links["rocker"].mass == pytest.approx(2.1)
    assert robot.frames["end_effector"].link == "rocker"
    assert robot.frames["end_effector"].translation == pytest.approx([0.2, 0, 0.1])
    assert robot.error("closures.pin", "x").line == 5
    error = robot.error("joints.motor", "does not turn")
    assert str(error).startswith(f"{tmp_path / 'robot.urdf'}:8: joints.motor")


def test_mimic_joints_follow(tmp_path: Path) -> None:
    mimic = '<mimic joint="motor" multiplier="-2" offset="0.1"/>'
    text = BARS.replace('<child link="rocker"/>', f'<child link="rocker"/>{mimic}')
    robot = read_urdf(write(tmp_path, text))
    assert robot.active == ("motor", "knee")
    follower = robot.mimics["hinge"]
    assert (follower.multipliers, follower.offset) == ({"motor": -2}, 0.1)
    with pytest.raises(
        DescriptionError, match=r"active\[1\]: 'hinge' follows 'motor', which is active too"
    ):
        read_urdf(tmp_path / "robot.urdf", active=["motor", "hinge"])
    write(tmp_path, text.replace('mimic joint="motor"', 'mimic joint="moter"'))
    with pytest.raises(
        DescriptionError, match=r"robot\.urdf:10: joints\.hinge\.mimic\.joint: .* mean 'motor'"
    ):
        read_urdf(tmp_path / "robot.urdf")
    write(tmp_path, text.replace('mimic joint="motor"', 'mimic joint="hinge"'))
    with pytest.raises(DescriptionError, match="'hinge' follows itself"):
        read_urdf(tmp_path / "robot.urdf")


def test_spherical_universal_and_fixed_in_place_of_joints(tmp_path: Path) -> None:
    write(tmp_path, BARS)
    replace = "{file: robot.urdf, replace: {knee: SPHERICAL, hinge: UJOINT_ZX, motor: fixed}}"
    text = FORMAT.replace("urdf: robot.urdf", f"urdf: {replace}").replace("[motor]", "[knee_X]")
    robot = read_description(
        write(tmp_path, text.replace("{motor: 1, knee: 0.3}", "{}"), "bars.yaml")
    )
    assert list(robot.joints) == ["knee_X", "knee_Y", "knee_Z", "hinge_Z", "hinge_X"]
    assert [robot.joints[f"knee_{axis}"].child for axis in "XYZ"] == ["knee_X", "knee_Y", "coupler"]
    assert "crank" not in robot.links
    x, y, z = (np.array([np.cos(a), np.sin(a)]) for a in (0.3, -0.4, 0.5))
    s = {"knee_X": 0.3, "knee_Y": -0.4, "knee_Z": 0.5}
    rx = np.array([[1, 0, 0], [0, x[0], -x[1]], [0, x[1], x[0]]])
    ry = np.array([[y[0], 0, y[1]], [0, 1, 0], [-y[1], 0, y[0]]])
    rz = np.array([[z[0], -z[1], 0], [z[1], z[0], 0], [0, 0, 1]])
    still = frame_pose(robot, "coupler", {})
    moved = frame_pose(robot, "coupler", s)
    assert moved[:3, :3] == pytest.approx(still[:3, :3] @ rx @ ry @ rz, abs=1e-15)
    assert moved[:3, 3] == pytest.approx(still[:3, 3], abs=1e-15)


CASES = {
    "entity bomb": (
        '<robot name="bars">',
        '<!DOCTYPE r [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><robot name="&b;">',
        1,
        "has a document type",
    ),
    "not closed": ("</robot>", "", 13, "not valid XML: no element found"),
    "ball": (
        '"motor" type="continuous"',
        '"motor" type="ball"',
        8,
        "joints.motor.type: is 'ball'; expected one of",
    ),
    "no parent": ('<parent link="crank"/>', "", 9, "joints.knee.parent: has no <parent link=...>"),
    "no such parent": (
        '<parent link="crank"/>',
        '<parent link="cranc"/>',
        9,
        "no link 'cranc' (did you mean 'crank'?)",
    ),
    "no such child": (
        '<child link="end_A"/>',
        '<child link="end_C"/>',
        11,
        "no link 'end_C' (did you mean 'end_B'?)",
    ),
    "two parents": (
        '<child link="end_A"/>',
        '<child link="end_B"/>',
        None,
        "link 'end_B' already hangs on joint",
    ),
    "name used twice": (
        '<link name="end_A"/>',
        '<link name="crank"/>',
        6,
        "'crank' is given twice in links (first in",
    ),
    "joint twice": (
        'joint name="hinge"',
        'joint name="knee"',
        10,
        "'knee' is given twice in joints",
    ),
    "no name": ('<link name="end_A"/>', "<link/>", 6, "a <link> has no name"),
    "negative mass": ('<mass value="1"/>', '<mass value="-1"/>', 3, "links.crank.mass: is -1 kg"),
    "no mass": ('<mass value="1"/>', "", 3, "<inertial> has no <mass>"),
    "mass of text": (
        '<mass value="1"/>',
        '<mass value="one"/>',
        3,
        '<mass> value="one"; expected a number',
    ),
    "two numbers": (
        'xyz="0.05 0 0"',
        'xyz="0.05 0"',
        3,
        '<origin> xyz="0.05 0"; expected 3 numbers',
    ),
    "not finite": ('xyz="0.05 0 0"', 'xyz="0.05 0 nan"', 3, "which is not finite"),
    "axis without length": (
        '<axis xyz="0 0 1"/>',
        '<axis xyz="0 0 0"/>',
        8,
        "motor.axis: the axis has no length",
    ),
    "xacro": (
        '<robot name="bars">',
        '<robot xmlns:xacro="x"><xacro:p/>',
        1,
        "run it through xacro first",
    ),
    "loop joint": (
        "</robot>",
        '<loop_joint name="l"/></robot>',
        13,
        "give the loop as <loop>, or under closures",
    ),
    "cycle": (
        '<parent link="ground"/><child link="crank"/>',
        '<parent link="end_A"/><child link="crank"/>',
        None,
        "cycle",
    ),
}


@pytest.mark.parametrize(("old", "new", "line", "words"), CASES.values(), ids=CASES.keys())
def test_wrong_urdf(tmp_path: Path, old: str, new: str, line: int | None, words: str) -> None:
    assert old in BARS
    path = write(tmp_path, BARS.replace(old, new, 1))
    with pytest.raises(DescriptionError) as caught:
        read_urdf(path)
    assert words in str(caught.value)
    assert str(path) in str(caught.value)
    if line is not None:
        assert abs((caught.value.line or 0) - line) <= 1


def test_unknown_root_and_too_deep(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match="is SDFormat, not URDF"):
        read_urdf(write(tmp_path, "<sdf/>"))
    with pytest.raises(DescriptionError, match="<model> is not a URDF"):
        read_urdf(write(tmp_path, "<model/>"))
    with pytest.raises(DescriptionError, match="too many elements"):
        read_urdf(write(tmp_path, "<robot>" + "<a>" * 100))
    with pytest.raises(DescriptionError, match="there is no such file or folder"):
        read_description(tmp_path / "none.urdf")


def test_wrong_names_beside_a_urdf(tmp_path: Path) -> None:
    path = write(tmp_path, BARS)
    with pytest.raises(
        DescriptionError, match=r"closures\.pin\.between\.end_a: .* \(did you mean 'end_A'"
    ):
        read_urdf(
            path,
            {"pin": {"kind": "point", "between": {"end_a": [0, 0, 0], "end_B": [0, 0, 0]}}},
            ["motor"],
        )
    with pytest.raises(
        DescriptionError, match=r"active\[0\]: there is no joint 'moter' \(did you mean 'motor'"
    ):
        read_urdf(path, PIN, ["moter"])
    with pytest.raises(DescriptionError, match="active: with closures, name the driven joints"):
        read_urdf(path, PIN)
    with pytest.raises(DescriptionError, match=r"end_effector\.link: there is no link 'tip'"):
        read_urdf(path, PIN, ["motor"], "tip")
    with pytest.raises(DescriptionError, match="unknown key"):
        read_urdf(path, PIN, ["motor"], referense={"motor": 1})
    with pytest.raises(
        DescriptionError, match=r"bars\.yaml:3: urdf: there is no file .*robt\.urdf"
    ):
        read_description(write(tmp_path, FORMAT.replace("robot.urdf", "robt.urdf"), "bars.yaml"))
    wrong = FORMAT.replace(
        "urdf: robot.urdf", "urdf: {file: robot.urdf, replace: {kne: SPHERICAL}}"
    )
    with pytest.raises(
        DescriptionError, match=r"urdf\.replace\.kne: there is no joint 'kne' .*mean 'knee'"
    ):
        read_description(write(tmp_path, wrong, "bars.yaml"))
    wrong = wrong.replace("kne: SPHERICAL", "knee: BALL")
    with pytest.raises(
        DescriptionError,
        match=r"urdf\.replace\.knee: is 'BALL'; expected SPHERICAL, FIXED, UJOINT_XY",
    ):
        read_description(write(tmp_path, wrong, "bars.yaml"))


def test_rounded_inertia_of_drawing_programs_passes(tmp_path: Path) -> None:
    plate = '<inertia ixx="0.0010" iyy="0.0010" izz="0.0020001"/>'
    rounded = BARS.replace(
        BARS[BARS.index("<inertia ixx") : BARS.index("/>", BARS.index("<inertia ixx")) + 2], plate
    )
    assert read_urdf(write(tmp_path, rounded)).links["crank"].inertia[0, 1] == 0


def test_links_without_a_parent_stand_on_the_world(tmp_path: Path) -> None:
    """At the origin, where Drake and Gazebo put them; a base that only joints name is one too."""
    inertial = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
    joint = '<joint name="{0}" type="continuous"><parent link="{1}"/><child link="{0}"/></joint>'
    links = "".join(f'<link name="{name}">{inertial}</link>' for name in ("p", "q"))
    joints = joint.format("p", "one") + joint.format("q", "two")
    file = tmp_path / "roots.urdf"
    file.write_text(f'<robot name="r"><link name="one"/><link name="two"/>{links}{joints}</robot>')
    robot = load(file)
    assert (robot.description.base, robot.coordinates) == ("world", ("p", "q"))
    assert robot.minimal_form(robot.close([0, 0]))[0] == pytest.approx(np.eye(2))
    assert any("2 links are without a parent (one, two)" in n for n in robot.description.notes)
    file.write_text(f'<robot name="r">{links}{joints.replace("two", "one")}</robot>')
    robot = load(file)
    assert robot.description.base == "one"
    assert any("there is no <link> 'one'" in note for note in robot.description.notes)
