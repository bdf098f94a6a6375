"""One robot written as Denavit-Hartenberg rows and as joints is the same robot."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import DescriptionError
from hybrid_dynamics_core.description import RobotDescription
from hybrid_dynamics_core.mechanism.tree import build_tree
from tests.description.oracle import frame_pose, link_pose, matrix
from tests.description.robots import HEAD, parse

ROWS = [  # type, a, alpha, d, theta: nothing special about them
    ("revolute", 0.1, math.pi / 2, 0.4, 0.3),
    ("revolute", 0.5, 0.2, 0.0, -0.7),
    ("prismatic", 0.05, -math.pi / 2, 0.25, math.pi / 2),
    ("revolute", 0.0, 1.1, 0.3, 0.0),
]
NAMES = [f"q{k}" for k in range(1, len(ROWS) + 1)]
LINKS = "".join(
    f"  l{k}: {{mass: {k}, com: [0.1, -0.02, 0.03], inertia: {{xx: 0.2, yy: 0.3, zz: 0.35, xy:"
    " 0.01, yz: -0.02}}\n"
    for k in range(1, len(ROWS) + 1)
)


def chain(convention: str, rows: list[tuple[str, float, float, float, float]] = ROWS) -> str:
    text = HEAD + "links:\n" + LINKS + f"chain:\n  convention: {convention}\n  rows:\n"
    for k, (kind, a, alpha, d, theta) in enumerate(rows, 1):
        numbers = f"a: {a!r}, alpha: {alpha!r}, d: {d!r}, theta: {theta!r}"
        text += f"    - {{joint: q{k}, child: l{k}, type: {kind}, {numbers}}}\n"
    return text + f"active: [{', '.join(NAMES)}]\nend_effector: {{link: l{len(rows)}}}\n"


def rx(angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    return matrix(np.array([[1, 0, 0], [0, c, -s], [0, s, c]]), np.zeros(3))


def rz(angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    return matrix(np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]), np.zeros(3))


def t(x: float, z: float) -> np.ndarray:
    return matrix(np.eye(3), np.array([x, 0.0, z]))


def textbook(convention: str, q: list[float]) -> list[np.ndarray]:
    """Poses of the links as the conventions define them."""
    pose, poses = np.eye(4), []
    for (kind, a, alpha, d, theta), value in zip(ROWS, q, strict=True):
        theta, d = (theta + value, d) if kind == "revolute" else (theta, d + value)  # noqa: PLW2901
        about_z, about_x = rz(theta) @ t(0, d), t(a, 0) @ rx(alpha)
        pose = pose @ (about_z @ about_x if convention == "standard" else about_x @ about_z)
        poses.append(pose)
    return poses


ROBOTS = {convention: parse(chain(convention)) for convention in ("standard", "modified")}


@pytest.mark.parametrize("convention", ROBOTS)
@given(q=st.lists(st.floats(-3, 3), min_size=len(ROWS), max_size=len(ROWS)))
def test_frames_are_the_textbooks(convention: str, q: list[float]) -> None:
    robot = ROBOTS[convention]
    s = dict(zip(NAMES, q, strict=True))
    for k, expected in enumerate(textbook(convention, q), 1):
        assert frame_pose(robot, f"l{k}", s) == pytest.approx(expected, abs=1e-14)
    assert frame_pose(robot, "end_effector", s) == pytest.approx(
        textbook(convention, q)[-1], abs=1e-14
    )


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_joints_turn_about_or_slide_along_z(convention: str) -> None:
    robot = parse(chain(convention))
    assert [j.type for j in robot.joints.values()] == [row[0] for row in ROWS]
    assert all(np.array_equal(j.axis, [0, 0, 1]) for j in robot.joints.values())


def bodies(
    robot: RobotDescription, s: dict[str, float]
) -> list[tuple[float, np.ndarray, np.ndarray]]:
    """Mass, centre of mass and inertia of every body in base axes."""
    result = []
    for name, link in robot.links.items():
        pose = link_pose(robot, name, s)
        turn = pose[:3, :3]
        result.append((link.mass, pose @ [*link.com, 1.0], turn @ link.inertia @ turn.T))
    return result


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_masses_stand_in_the_denavit_hartenberg_frames(convention: str) -> None:
    q = [0.3, -0.8, 0.15, 2.0]
    s = dict(zip(NAMES, q, strict=True))
    moved_bodies = bodies(parse(chain(convention)), s)
    local = np.array([[0.2, 0.01, 0], [0.01, 0.3, -0.02], [0, -0.02, 0.35]])
    for k, (pose, (mass, com, inertia)) in enumerate(
        zip(textbook(convention, q), moved_bodies, strict=True), 1
    ):
        assert mass == k
        assert com == pytest.approx(pose @ [0.1, -0.02, 0.03, 1.0], abs=1e-14)
        assert inertia == pytest.approx(pose[:3, :3] @ local @ pose[:3, :3].T, abs=1e-14)


AS_JOINTS = """\
joints:
  q1: {type: revolute, parent: base, child: l1, axis: z, origin: {xyz: [0, 0, 0.4]}}
  q2: {type: revolute, parent: l1, child: l2, axis: z,
       origin: {xyz: [0.1, 0, 0], rpy: [pi/2, 0, 0]}}
  q3: {type: revolute, parent: l2, child: l3, axis: z, origin: {xyz: [0.5, 0, 0]}, limits: [-1, 1]}
"""
AS_STANDARD = """\
chain:
  convention: standard
  rows:
    - {joint: q1, child: l1, d: 0.4, a: 0.1, alpha: pi/2}
    - {joint: q2, child: l2, a: 0.5}
    - {joint: q3, child: l3, a: 0.3, limits: [-1, 1]}
"""
AS_MODIFIED = """\
chain:
  convention: modified
  rows:
    - {joint: q1, child: l1, d: 0.4}
    - {joint: q2, child: l2, a: 0.1, alpha: pi/2}
    - {joint: q3, child: l3, a: 0.5, limits: [-1, 1]}
"""
MIXED = AS_MODIFIED.replace(
    "    - {joint: q2", "    # q2 is given below\n    - {joint: q2"
).replace(
    "    # q2 is given below\n    - {joint: q2, child: l2, a: 0.1, alpha: pi/2}\n", ""
).replace("{joint: q3,", "{joint: q3, parent: l2,") + AS_JOINTS.replace("  q1:", "  #").replace(
    "  q3:", "  #"
)


@pytest.mark.parametrize(
    "way", [AS_STANDARD, AS_MODIFIED, MIXED], ids=["standard", "modified", "mixed"]
)
def test_same_robot_in_every_way_of_writing(way: str) -> None:
    """Also as the tree that the solver takes: its poses at zero are those of the joint form."""
    links = "links: {l1: {}, l2: {}, l3: {mass: 1}}\n"
    tail = "active: [q1, q2, q3]\nend_effector: {link: l3%s}\n"
    joints = parse(HEAD + links + AS_JOINTS + tail % ", xyz: [0.3, 0, 0]")
    other = parse(HEAD + links + way + tail % ("" if way == AS_STANDARD else ", xyz: [0.3, 0, 0]"))
    ours, theirs = build_tree(other), build_tree(joints)
    for name in ("l1", "l2", "l3"):
        a, b = ours.zero_pose(ours.body_index(name)), theirs.zero_pose(theirs.body_index(name))
        assert a[0] == pytest.approx(b[0], abs=1e-15)
        assert a[1] == pytest.approx(b[1], abs=1e-15)
    s = {"q1": 0.4, "q2": 0.9, "q3": -0.7}
    assert frame_pose(other, "end_effector", s) == pytest.approx(
        frame_pose(joints, "end_effector", s), abs=1e-15
    )
    assert other.joints["q3"].limits == joints.joints["q3"].limits == (-1, 1)


def test_joints_loops_and_frames_stand_on_denavit_hartenberg_frames() -> None:
    """Whatever is put on a link of a standard row is put on its Denavit-Hartenberg frame."""
    text = HEAD + "links: {l1: {}, l2: {}, l3: {mass: 1}, side: {}}\n" + AS_STANDARD
    text += (
        "joints:\n  p: {type: prismatic, parent: l2, child: side, axis: x, origin: {xyz: [0, 0.2,"
        " 0]}}\n"
    )
    text += "closures:\n  c: {kind: point, between: {l3: [0, 0.1, 0], side: [0, 0, 0]}}\n"
    text += "frames: {eye: {link: l2, xyz: [0, 0, 0.6]}}\n"
    text += "active: [q1, q2, q3]\nend_effector: {link: l3}\n"
    robot = parse(text)
    s = {"q1": 0.2, "q2": 0.5, "q3": -0.3, "p": 0.0}
    l2 = frame_pose(robot, "l2", s)
    assert link_pose(robot, "side", s) == pytest.approx(
        l2 @ matrix(np.eye(3), np.array([0, 0.2, 0]))
    )
    assert frame_pose(robot, "eye", s) == pytest.approx(
        l2 @ matrix(np.eye(3), np.array([0, 0, 0.6]))
    )
    assert robot.closures[0].point_a == pytest.approx([0.3, 0.1, 0])  # in the frame at the joint


WRONG = {
    "convention": (
        "convention: standard",
        "convention: dh",
        "chain.convention",
        "is 'dh'; expected one of standard",
    ),
    "missing child": (", child: l2", "", "chain.rows[1]", "missing 'child'"),
    "no such link": ("child: l2", "child: l9", "chain.rows[1].child", "no link 'l9'"),
    "no such base": ("  rows:", "  base: bas\n  rows:", "chain.base", "did you mean 'base'"),
    "no such parent": (
        "child: l3",
        "parent: l22, child: l3",
        "chain.rows[2].parent",
        "did you mean 'l2'",
    ),
    "slip in a": ("a: 0.5", "a: L2", "chain.rows[1].a", "'L2' is not one of the parameters"),
    "slip in alpha": ("alpha: pi/2", "alpha: 90 deg", "chain.rows[0].alpha", "neither a number"),
    "slip in d": ("d: 0.4", "d: .inf", "chain.rows[0].d", "expected a finite number"),
    "name used twice": (
        "joint: q3",
        "joint: q1",
        "chain.rows[2]",
        "the name 'q1' is given twice in joints",
    ),
    "limits": ("[-1, 1]", "[1, -1]", "chain.rows[2].limits", "not below"),
    "unknown key": ("a: 0.5", "A: 0.5", "chain.rows[1].A", "known keys"),
}


@pytest.mark.parametrize(("old", "new", "key", "words"), WRONG.values(), ids=WRONG.keys())
def test_wrong_rows(old: str, new: str, key: str, words: str) -> None:
    text = HEAD + "links: {l1: {}, l2: {}, l3: {mass: 1}}\n" + AS_STANDARD
    text += "active: [q1, q2, q3]\nend_effector: {link: l3}\n"
    changed = text.replace(old, new, 1)
    assert changed != text
    with pytest.raises(DescriptionError) as caught:
        parse(changed)
    assert re.search(re.escape(words), str(caught.value))
    assert caught.value.key == key
    assert caught.value.line == changed[: text.index(old)].count("\n") + 1


def test_no_joints_at_all() -> None:
    with pytest.raises(DescriptionError, match="there are no joints; give joints, chain"):
        parse(HEAD + "active: [q1]\nend_effector: {link: base}\n")
