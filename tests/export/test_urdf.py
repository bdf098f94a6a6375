"""The URDF of every robot in an independent parser: the same poses, masses and gravity forces."""

from __future__ import annotations

import subprocess
import sys
import textwrap
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio
import pytest

from hybrid_dynamics_core import load, shipped_robots
from hybrid_dynamics_core.description.geometry import rotation_from_rpy, rpy_of
from hybrid_dynamics_core.export.__main__ import main
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.formats.urdf.plus_writer import to_urdf_plus
from hybrid_dynamics_core.formats.urdf.writer import to_urdf
from tests.sampling import swept


def configuration(model: pinocchio.Model, values: dict[str, float]) -> np.ndarray:
    """q of Pinocchio, which keeps joints without limits as cosine and sine."""
    q = pinocchio.neutral(model)
    for name, value in values.items():
        joint = model.joints[model.getJointId(name)]
        q[joint.idx_q : joint.idx_q + joint.nq] = (
            [value] if joint.nq == 1 else [np.cos(value), np.sin(value)]
        )
    return q


@pytest.mark.parametrize("name", swept(shipped_robots()))
def test_an_independent_parser_finds_every_frame_where_it_is(name: str) -> None:
    robot = load(name)
    model = pinocchio.buildModelFromXML(to_urdf(robot.description))
    data = model.createData()
    assert set(model.names[1:]) == set(robot.coordinates)
    state = robot.close(robot.reference)
    pinocchio.framesForwardKinematics(
        model,
        data,
        configuration(model, dict(zip(robot.coordinates, state.s.tolist(), strict=True))),
    )
    for frame in robot.frames:
        pose, actual = robot.forward_kinematics(state, frame), data.oMf[model.getFrameId(frame)]
        np.testing.assert_allclose(actual.translation, pose.position, atol=1e-9)
        np.testing.assert_allclose(actual.rotation, pose.rotation, atol=1e-9)


@pytest.mark.parametrize("name", swept(shipped_robots()))
def test_an_independent_parser_finds_the_same_weight_along_every_joint(name: str) -> None:
    robot = load(name)
    model = pinocchio.buildModelFromXML(to_urdf(robot.description))
    model.gravity.linear = robot.description.gravity
    state = robot.close(robot.reference)
    q = configuration(model, dict(zip(robot.coordinates, state.s.tolist(), strict=True)))
    along = pinocchio.computeGeneralizedGravity(model, model.createData(), q)
    actual = [along[model.joints[model.getJointId(joint)].idx_v] for joint in robot.coordinates]
    np.testing.assert_allclose(actual, robot.spanning_terms(state).g, rtol=1e-9, atol=1e-6)


@pytest.mark.parametrize("name", swept(shipped_robots()))
def test_the_tree_is_read_back(name: str, tmp_path: Path) -> None:
    """Every joint of the tree is driven; its reference is zero, or the limit nearest to it."""
    robot = load(name)
    file = tmp_path / "tree.urdf"
    file.write_text(to_urdf(robot.description))
    tree = load(file)
    assert set(tree.active) == set(robot.coordinates) - set(robot.description.mimics)
    expected = [min(max(0.0, lower), upper) for lower, upper in tree.limits.tolist()]
    np.testing.assert_array_equal(tree.reference, expected)
    far = [name for name, value in zip(tree.active, expected, strict=True) if value]
    notes = [note for note in tree.description.notes if "loops were cut" not in note]
    assert len(notes) == len(far)
    assert all(
        f"{name}: no reference is given; taken: " in note
        for name, note in zip(far, notes, strict=True)
    )


@pytest.mark.parametrize("pitch", [0.0, 0.3, -1.2, np.pi / 2, -np.pi / 2, np.pi / 2 - 1e-7])
def test_rotations_come_back_from_their_angles(pitch: float) -> None:
    rotation = rotation_from_rpy(0.4, pitch, -2.1)
    np.testing.assert_allclose(rotation_from_rpy(*rpy_of(rotation)), rotation, atol=1e-9)


@pytest.mark.parametrize("hyphens", ["-", "--", "---", "----", "- -- ---"])
def test_names_with_hyphens_leave_the_comment_valid(hyphens: str) -> None:
    """XML forbids two hyphens side by side in a comment: in the name there they are set apart."""
    description = load("five_bar").description
    first, *others = description.closures
    machine = replace(
        description, closures=(replace(first, name=f"tip{hyphens}x{hyphens}"), *others)
    )
    builder = ElementTree.TreeBuilder(insert_comments=True)
    root = ElementTree.fromstring(to_urdf(machine), ElementTree.XMLParser(target=builder))
    (comment,) = (element.text or "" for element in root if element.tag is ElementTree.Comment)
    assert root[0].text == comment  # it stands first
    assert "--" not in comment
    assert f"tip{hyphens}x{hyphens}".replace(" ", "") in comment.replace(" ", "")


LIMITS = {
    ("revolute", (-1.0, 2e4)): "",
    ("revolute", (-np.inf, np.inf)): "",
    ("revolute", (-1.0, np.inf)): "q1 has -1 to inf, written as continuous",
    ("prismatic", (-3e3, 0.5)): "",
    ("prismatic", (-np.inf, np.inf)): "q1 has -inf to inf, written as -1000 to 1000 m",
    ("prismatic", (2e3, np.inf)): "q1 has 2000 to inf, written as 2000 to 3000 m",
    ("prismatic", (-np.inf, -0.2)): "q1 has -inf to -0.2, written as -1000.2 to -0.2 m",
}


ONE_JOINT = """
    format: 1
    name: one_joint
    source: made up
    gravity: [0, 0, -9.81]
    base: floor
    links: {bar: {mass: 1, com: [0.1, 0, 0], inertia: {sphere: {radius: 0.1}}}}
    joints: {q1: {type: TYPE, parent: floor, child: bar, axis: x, limits: [LOWER, UPPER]}}
    active: [q1]
    end_effector: {link: bar}
"""


@pytest.mark.parametrize("write", [to_urdf, to_urdf_plus])
@pytest.mark.parametrize(("given", "comment"), LIMITS.items())
def test_limits_come_back_or_the_comment_names_the_joint(write, given, comment, tmp_path) -> None:
    joint_type, limits = given
    lower, upper = (str(limit).replace("inf", ".inf") for limit in limits)
    text = ONE_JOINT.replace("TYPE", joint_type).replace("LOWER", lower).replace("UPPER", upper)
    written = write(parse_description(textwrap.dedent(text)))
    assert comment in written
    assert bool(comment) == ("Limits that are written otherwise" in written)
    file = tmp_path / "one_joint.urdf"
    file.write_text(written)
    back = load(file).description.joints["q1"].limits
    if not comment or write is to_urdf_plus:
        assert back == limits


def test_the_command_writes_what_the_function_gives(tmp_path, capsys) -> None:
    file = tmp_path / "robot.urdf"
    command = [sys.executable, "-m", "hybrid_dynamics_core.export", "excavator", file]
    assert subprocess.run(command, check=False).returncode == 0
    assert file.read_text(encoding="utf-8") == to_urdf(load("excavator").description)
    assert main(["delta", str(file)]) == 1
    assert "there is a file already" in capsys.readouterr().err
    assert main(["delta", str(file), "--overwrite"]) == 0
    assert file.read_text(encoding="utf-8") == to_urdf(load("delta").description)
    assert main(["no_such_robot"]) == 1
    assert "no_such_robot" in capsys.readouterr().err
