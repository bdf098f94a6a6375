"""Exported robots: read back, and never written over what the robot is read from."""

from __future__ import annotations

from pathlib import Path

import pytest

from hybrid_dynamics_core import load
from tests.cli.calling import call, shipped_text

COMPLETED = """\
format: 1
name: completed
urdf: tree.urdf
active: [{active}]
end_effector: {{link: end_effector}}
"""


def test_export_is_read_by_another_engine(tmp_path: Path) -> None:
    pinocchio = pytest.importorskip("pinocchio")
    place = tmp_path / "excavator.urdf"
    assert call("export", "excavator", "--output", str(place)).exit_code == 0
    assert pinocchio.buildModelFromUrdf(str(place)).nv == len(load("excavator").coordinates)
    assert call("export", "excavator").stdout == place.read_text(encoding="utf-8")


@pytest.mark.parametrize("form", ["urdf+", "mjcf", "sdf", "robot.yaml"])
def test_export_is_taken_back(form: str, tmp_path: Path) -> None:
    """By `load`, whatever the file is called."""
    place = tmp_path / "excavator.yaml"
    assert call("export", "excavator", "--format", form, "-o", str(place)).exit_code == 0
    assert load(place).active == load("excavator").active


@pytest.mark.parametrize("more", [(), ("--overwrite",)])
def test_export_never_replaces_what_the_robot_is_read_from(
    tmp_path: Path, more: tuple[str, ...]
) -> None:
    """A user's file, the URDF that it names, and the URDF that is written beside a robot.yaml."""
    robot = tmp_path / "robot.yaml"
    tree = tmp_path / "tree.urdf"
    completed = tmp_path / "completed.yaml"  # of the tree
    robot.write_text(shipped_text("five_bar"), encoding="utf-8")
    assert call("export", str(robot), "-o", str(tree)).exit_code == 0
    active = ", ".join(load(tree).active)
    completed.write_text(COMPLETED.format(active=active), encoding="utf-8")
    before = [file.read_text(encoding="utf-8") for file in (robot, tree, completed)]
    (tmp_path / "link.yaml").symlink_to(robot)
    for source, form, output in (
        (robot, "robot.yaml", robot),
        (robot, "sdf", tmp_path / "link.yaml"),
        (completed, "mjcf", tree),
        (completed, "robot.yaml", tmp_path / "tree.yaml"),
    ):
        result = call("export", str(source), "--format", form, "-o", str(output), *more)
        assert result.exit_code == 2
        reason = "the robot is read from this file, which is not replaced; name another one"
        assert reason in result.output
    assert before == [file.read_text(encoding="utf-8") for file in (robot, tree, completed)]
    assert not (tmp_path / "tree.yaml").exists()  # all files, or none


def test_export_replaces_files_where_that_is_asked_for(tmp_path: Path) -> None:
    urdf = tmp_path / "a.urdf"
    pair = tmp_path / "a.yaml"
    written = call("export", "excavator", "--format", "urdf+", "-o", str(urdf))
    assert written.output == f"written: {urdf} (URDF+)\n"
    text = urdf.read_text(encoding="utf-8")
    arguments = ("export", "excavator", "--format", "robot.yaml", "-o", str(pair))
    refused = call(*arguments)
    assert refused.exit_code == 2
    reason = f"{urdf}: there is a file already; name another one, or give --overwrite"
    assert reason in refused.output
    assert urdf.read_text(encoding="utf-8") == text
    assert not pair.exists()
    replaced = call(*arguments, "--overwrite")
    assert replaced.output == f"written: {pair} (pairs of frames)\nwritten: {urdf} (URDF)\n"
    assert "<loop" not in urdf.read_text(encoding="utf-8")


def test_a_pair_of_files_needs_a_place(tmp_path: Path) -> None:
    arguments = ("export", "excavator", "--format", "robot.yaml")
    assert "comes with a URDF beside it" in call(*arguments).output
    wrong = call(*arguments, "-o", str(tmp_path / "robot.urdf"))
    assert "expected a name that ends in .yaml" in wrong.output
    assert not list(tmp_path.iterdir())
