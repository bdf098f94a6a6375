"""One place has the name `end_effector`: the link or frame of that name, or the key."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import DescriptionError, load
from hybrid_dynamics_core.export import to_sdf, to_urdf
from tests.description.test_urdf import joint

ARM = (
    '<robot name="arm"><link name="base"/><link name="l1"/><link name="l2"/><link'
    ' name="end_effector"/>'
    + joint("a", "continuous", ("base", "l1"), "", '<axis xyz="0 1 0"/>')
    + joint("b", "continuous", ("l1", "l2"), "1 0 0", '<axis xyz="0 1 0"/>')
    + joint("tool", "fixed", ("l2", "end_effector"), "0.5 0 0")
    + "</robot>"
)
BESIDE_URDF = "format: 1\nname: over\nurdf: arm.urdf\nactive: [a, b]\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "arm.urdf").write_text(ARM)
    return tmp_path


def reach(file: Path) -> list[float]:
    robot = load(file)
    position: list[float] = robot.forward_kinematics(robot.close([0.0, 0.0])).position.tolist()
    return position


def test_a_link_of_that_name_is_the_end_effector(folder: Path) -> None:
    """The link stands 0.5 m beyond l2, whose joint is 1 m out."""
    assert reach(folder / "arm.urdf") == [1.5, 0.0, 0.0]
    robot = load(folder / "arm.urdf")
    assert robot.description.body_of("end_effector") == "l2"
    assert not robot.description.notes  # nothing was guessed


def test_so_is_one_that_moves(folder: Path) -> None:
    moving = ARM.replace('name="tool" type="fixed"', 'name="tool" type="continuous"')
    (folder / "moving.urdf").write_text(
        moving.replace("</robot>", "<link name='more'/></robot>").replace(
            "<link name='more'/>",
            "<link name='more'/>" + joint("c", "continuous", ("end_effector", "more"), "1 0 0"),
        )
    )
    robot = load(folder / "moving.urdf")
    state = robot.close(np.zeros(4))
    assert robot.forward_kinematics(state).position.tolist() == [1.5, 0.0, 0.0]
    assert robot.frames.count("end_effector") == 1


@pytest.mark.parametrize(
    "entry", ["{link: l1}", "{link: l2}", "{link: end_effector, xyz: [0.1, 0, 0]}"]
)
def test_another_place_of_that_name_is_refused(folder: Path, entry: str) -> None:
    file = folder / "over.yaml"
    file.write_text(f"{BESIDE_URDF}end_effector: {entry}\n")
    with pytest.raises(DescriptionError) as caught:
        load(file)
    assert (
        str(caught.value)
        == f"{file}:5: end_effector: a link called 'end_effector' stands at another place, and one"
        " name cannot mean both; write `end_effector: {link: end_effector}` if it is meant"
        " (other places can be named under frames), or rename that link"
    )


def test_a_frame_of_that_name_is_no_other_place_either(folder: Path) -> None:
    (folder / "arm.urdf").write_text(ARM.replace("end_effector", "flange"))
    file = folder / "over.yaml"
    file.write_text(
        f"{BESIDE_URDF}end_effector: {{link: l1}}\nframes: {{end_effector: {{link: flange}}}}\n"
    )
    with pytest.raises(
        DescriptionError, match="a frame called 'end_effector' stands at another place"
    ):
        load(file)


@pytest.mark.parametrize("entry", ["{link: end_effector}", "{link: l2, xyz: [0.5, 0, 0]}"])
def test_the_same_place_said_twice_is_one(folder: Path, entry: str) -> None:
    file = folder / "over.yaml"
    file.write_text(f"{BESIDE_URDF}end_effector: {entry}\n")
    assert reach(file) == [1.5, 0.0, 0.0]


def test_an_exported_tree_keeps_its_end_effector(tmp_path: Path) -> None:
    """The place that the robot has where all of its joints stand as the closed robot has them."""
    robot = load("excavator")
    state = robot.close(robot.reference)
    (tmp_path / "tree.urdf").write_text(to_urdf(robot.description))
    tree = load(tmp_path / "tree.urdf")
    closed = dict(zip(robot.coordinates, state.s.tolist(), strict=True))
    there = tree.close([closed[name] for name in tree.active])
    wanted, actual = robot.forward_kinematics(state), tree.forward_kinematics(there)
    np.testing.assert_allclose(
        actual.position, wanted.position, atol=1e-9
    )  # rounding of angles of about 1e-16, and 10 m


def test_so_does_a_file_without_the_entries_of_this_library(tmp_path: Path) -> None:
    """SDFormat has the end effector as a frame of that name."""
    text = to_sdf(load("staicu2015"))
    assert '<frame name="end_effector"' in text
    tag = "<hybrid_dynamics:hybrid_dynamics>"
    begin, end = text.index(f"{tag}\nsource"), text.rindex(tag.replace("<", "</"))
    (tmp_path / "robot.sdf").write_text(text[:begin] + text[end + len(tag) + 1 :])
    robot = load(tmp_path / "robot.sdf")
    assert robot.description.frames["end_effector"].link == "upper_platform"
