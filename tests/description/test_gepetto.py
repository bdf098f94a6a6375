"""A robot.yaml with closed_loop pairs beside its URDF."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import DescriptionError, load
from hybrid_dynamics_core.closure.constraints.from_description import loop_equations
from hybrid_dynamics_core.closure.numeric_closure import close_numerically
from hybrid_dynamics_core.description import RobotDescription
from hybrid_dynamics_core.formats import read_description
from hybrid_dynamics_core.mechanism.configuration import configuration_at
from hybrid_dynamics_core.mechanism.tree import build_tree
from tests.description.oracle import close, freedom, gaps
from tests.description.test_urdf import BARS, body, joint, write

PAIR = "closed_loop: [['end_A', 'end_B']]\ntype: ['3d']\nname_mot: ['motor']\n"


def read(folder: Path, text: str = PAIR, urdf: str = BARS) -> RobotDescription:
    write(folder, urdf)
    return read_description(write(folder, text, "robot.yaml"))


def test_a_pair_is_a_closure_and_a_motor_an_active_joint(tmp_path: Path) -> None:
    robot = read(tmp_path)
    (closure,) = robot.closures
    assert (closure.name, closure.kind) == ("loop_1", "point")
    assert (closure.link_a, closure.link_b) == ("coupler", "rocker")
    assert robot.name == "bars"
    assert robot.active == ("motor",)
    assert robot.reference == {"motor": 0, "knee": 0, "hinge": 0}
    assert robot.frames["end_effector"].link == "coupler"
    s = close(robot, {"motor": 1.0}, {})
    assert np.abs(gaps(robot, s)).max() < 1e-13
    assert freedom(robot, s) == 1
    assert robot.error("closures.loop_1", "x").line == 1
    assert robot.error("joints.motor", "x").file == tmp_path / "robot.urdf"


def test_tied_frames_on_a_planar_loop_need_a_free_end(tmp_path: Path) -> None:
    """As exporters write it: the coupler ends in a hinge of its own, then 6d has rank 3 of 6."""
    hinged = BARS.replace('name="A" type="fixed"', 'name="A" type="continuous"').replace(
        '<child link="end_A"/>', '<child link="end_A"/><axis xyz="0 0 1"/>'
    )
    robot = read(tmp_path, PAIR.replace("3d", "6D"), hinged)
    assert robot.closures[0].kind == "frame"
    s = close(robot, {"motor": 1.0}, {})
    assert np.abs(gaps(robot, s)).max() < 1e-13
    assert freedom(robot, s) == 1


@pytest.mark.parametrize(
    "text", ["closed_loop: [[end_A, end_B]]\nname_mot: [motor]\n", PAIR.replace("3d", "6d")]
)
def test_without_a_type_a_pair_is_6d(tmp_path: Path, text: str) -> None:
    assert read(tmp_path, text).closures[0].kind == "frame"


def test_joints_of_other_types(tmp_path: Path) -> None:
    robot = read(
        tmp_path, PAIR + "joint_name: ['knee', 'hinge']\njoint_type: ['SPHERICAL', 'UJOINT_YZ']\n"
    )
    assert list(robot.joints) == ["motor", "knee_X", "knee_Y", "knee_Z", "hinge_Y", "hinge_Z"]
    s = close(robot, {"motor": 1.0}, {})
    assert np.abs(gaps(robot, s)).max() < 1e-13
    fixed = read(tmp_path, PAIR + "joint_name: ['knee']\njoint_type: ['FIXED']\n")
    assert list(fixed.joints) == ["motor", "hinge"]
    assert fixed.frames["coupler"].link == "crank"


def test_empty_lists_and_other_keys(tmp_path: Path) -> None:
    robot = read(tmp_path, PAIR + "joint_name: []\njoint_type: []\nrotor: [1]\n")
    assert "rotor: not used" in robot.notes


def test_a_joint_where_a_frame_is_meant(tmp_path: Path) -> None:
    robot = read(tmp_path, PAIR.replace("'end_A', 'end_B'", "'A', 'B'"))
    assert robot.closures[0].point_a == pytest.approx([0.3, 0, 0])
    assert "A: a joint where a frame is meant; taken as its child link" in robot.notes


def test_a_mimic_that_is_a_motor_is_driven(tmp_path: Path) -> None:
    text = BARS.replace('<child link="rocker"/>', '<child link="rocker"/><mimic joint="motor"/>')
    robot = read(tmp_path, PAIR, text)
    assert list(robot.mimics) == ["hinge"]
    robot = read(tmp_path, PAIR.replace("['motor']", "['motor', 'hinge']"), text)
    assert not robot.mimics
    assert "hinge: named as a motor, so it does not follow 'motor'" in robot.notes


def test_the_only_urdf_of_the_folder_is_taken(tmp_path: Path) -> None:
    write(tmp_path, BARS, "model.urdf")
    path = write(tmp_path, PAIR, "robot.yaml")
    assert read_description(path).name == "bars"
    write(tmp_path, BARS, "other.urdf")
    with pytest.raises(
        DescriptionError,
        match=r"no robot\.urdf beside it, and 2 others \(model\.urdf, other\.urdf\)",
    ):
        read_description(path)


WRONG = {
    "unicode slip": (
        "'end_A', ",
        "'end_Á', ",
        "closed_loop[0][0]",
        1,
        "no frame 'end_Á' (did you mean 'end_A'?)",
    ),
    "one twice": ("'end_A', ", "'end_B', ", "closed_loop[0]", 1, "names one frame twice"),
    "three": ("'end_A', ", "'end_A', 'end_A', ", "closed_loop[0]", 1, "3 entries; expected 2"),
    "type": ("'3d'", "'4d'", "type[0]", 2, "is '4d'; expected one of 3d, 6d"),
    "types": ("['3d']", "['3d', '6d']", "type", 2, "has 2 entries for 1 pair of"),
    "motor": ("['motor']", "['motr']", "name_mot[0]", 3, "no joint 'motr' (did you mean 'motor'?)"),
    "fixed motor": (
        "['motor']",
        "['A']",
        "name_mot[0]",
        3,
        "'A' is a fixed joint; a motor moves one",
    ),
    "motor twice": ("['motor']", "['motor', 'motor']", "name_mot[1]", 3, "named twice"),
    "no such joint": (
        "name_mot",
        "joint_name: [kne]\njoint_type: [FIXED]\nname_mot",
        "joint_name[0]",
        3,
        "mean 'knee'",
    ),
    "no such type": (
        "name_mot",
        "joint_name: [knee]\njoint_type: [UJOINT_XX]\nname_mot",
        "joint_name[0]",
        3,
        "is 'UJOINT_XX'",
    ),
    "joint types": (
        "name_mot",
        "joint_name: [knee]\njoint_type: []\nname_mot",
        "joint_type",
        4,
        "0 entries for 1",
    ),
    "joint twice": (
        "name_mot",
        "joint_name: [knee, knee]\njoint_type: [FIXED, FIXED]\nname_mot",
        "joint_name[1]",
        3,
        "named twice",
    ),
    "replaced motor": (
        "name_mot",
        "joint_name: [motor]\njoint_type: [UJOINT_XZ]\nname_mot",
        "name_mot[0]",
        5,
        "no joint 'motor'; it is replaced by motor_X, motor_Z",
    ),
    "text for a list": ("['motor']", "motor", "name_mot", 3, "is 'motor'; expected a list"),
}


@pytest.mark.parametrize(("old", "new", "key", "line", "words"), WRONG.values(), ids=WRONG.keys())
def test_wrong_pairs(tmp_path: Path, old: str, new: str, key: str, line: int, words: str) -> None:
    assert old in PAIR
    with pytest.raises(DescriptionError) as caught:
        read(tmp_path, PAIR.replace(old, new, 1))
    assert words in str(caught.value)
    assert (caught.value.key, caught.value.line) == (key, line)


def test_frames_that_start_half_a_turn_apart_are_turned_together(tmp_path: Path) -> None:
    """Where all joints are zero the frames face away from each other: no single axis turns them."""
    hinged = BARS.replace('name="A" type="fixed"', 'name="A" type="continuous"').replace(
        '<child link="end_A"/>', '<child link="end_A"/><axis xyz="0 0 1"/>'
    )
    turned = hinged.replace(
        'xyz="0.2 0 0" rpy="0 0 0"', 'xyz="0.2 0 0" rpy="0 3.141592653589793 0"'
    )
    assert turned != hinged
    write(tmp_path, turned)
    text = PAIR.replace("3d", "6d") + "joint_name: [A]\njoint_type: [SPHERICAL]\n"
    machine = load(write(tmp_path, text, "robot.yaml"))
    state = machine.close(machine.reference)
    assert state.residual < 1e-12
    assert "motor" in machine.active


HINGED = BARS.replace('name="A" type="fixed"', 'name="A" type="continuous"').replace(
    '<child link="end_A"/>', '<child link="end_A"/><axis xyz="0 0 1"/>'
)
LIMITED = BARS.replace('name="hinge" type="continuous"', 'name="hinge" type="revolute"').replace(
    '<child link="rocker"/>',
    '<child link="rocker"/><limit lower="-0.01" upper="0.01" effort="1" velocity="1"/>',
)


def test_a_search_from_opposed_frames_ends_with_frames_that_face_alike(tmp_path: Path) -> None:
    """At zero the pair's frames are half a turn apart, where the sine of the angle is zero."""
    opposed = HINGED.replace('xyz="0.2 0 0" rpy="0 0 0"', f'xyz="0.2 0 0" rpy="0 0 {np.pi - 3.0}"')
    robot = read(tmp_path, PAIR.replace("3d", "6d"), opposed)
    tree = build_tree(robot)
    free = range(len(tree.coordinates))
    loops = loop_equations(tree, robot, frozenset(free))
    s, residual = close_numerically(tree, loops, np.zeros(len(free)), free)
    assert max(residual.values()) < 1e-12
    assert (
        min(float(guard) for loop in loops for guard in loop.guards(configuration_at(tree, s)))
        > 0.0
    )


def test_loops_that_close_beyond_a_limit_only_are_noted(tmp_path: Path) -> None:
    """The file names no reference: what is found is told, and the motion can be worked with."""
    machine = load(_pair(tmp_path, LIMITED, PAIR))
    assert machine.close(machine.reference).residual < 1e-12
    (note,) = [note for note in machine.description.notes if note.startswith("hinge")]
    assert (
        "outside its limits [-0.01, 0.01]; within all limits no closed configuration was found"
        in note
    )


def test_joints_outside_all_loops_stay_where_they_are(tmp_path: Path) -> None:
    """Only joints in loops are moved in the search for a closed configuration within limits."""
    limit = '<limit lower="-0.1" upper="0.2" effort="1" velocity="1"/>'
    arm = body("hand", 1) + joint("wrist", "revolute", ("ground", "hand"), "", limit)
    text = PAIR.replace("['motor']", "['motor', 'wrist']")
    assert (
        load(_pair(tmp_path, LIMITED.replace("</robot>", f"{arm}</robot>"), text)).reference[1]
        == 0.0
    )


def _pair(folder: Path, urdf: str, text: str) -> Path:
    write(folder, urdf)
    return write(folder, text, "robot.yaml")
