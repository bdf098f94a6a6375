"""Visuals of links in the verbs that draw and write robots."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.calling import call
from tests.mesh_files import write_mesh

PENDULUM = """\
format: 1
name: r
links: {a: {mass: 1, visuals: [{mesh: {file: MESH}}]}}
joints: {q: {type: revolute, parent: base, child: a, axis: z}}
active: [q]
end_effector: {link: a}
"""


@pytest.fixture(autouse=True)
def _python_kernels(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each robot is asked once: compiling would take longer."""
    monkeypatch.setenv("HYBRID_DYNAMICS_KERNELS", "python")


def test_a_picture_shows_the_skeleton_where_it_is_asked_for(tmp_path: Path) -> None:
    file = tmp_path / "r.yaml"
    file.write_text(PENDULUM.replace("mesh: {file: MESH}", "box: {size: [1, 1, 1]}"))
    visuals = call("check", str(file), "--draw", str(tmp_path / "visuals.svg"))
    skeleton = call("check", str(file), "--skeleton", "--draw", str(tmp_path / "skeleton.svg"))
    assert (visuals.exit_code, skeleton.exit_code) == (0, 0)
    assert "<image" in (tmp_path / "visuals.svg").read_text()
    assert "<image" not in (tmp_path / "skeleton.svg").read_text()
    alone = call("check", str(file), "--skeleton")
    assert "--skeleton is of the picture; give --draw FILE too" in alone.output


def test_a_mesh_that_is_not_read_is_a_note_beside_the_picture(tmp_path: Path) -> None:
    (tmp_path / "r.yaml").write_text(PENDULUM.replace("MESH", "m.stl"))
    (tmp_path / "m.stl").write_bytes(b"nothing")
    answer = call("check", str(tmp_path / "r.yaml"), "--draw", str(tmp_path / "r.svg"))
    assert answer.exit_code == 0
    assert "note: r: mesh m.stl is not shown: it has no triangles" in answer.stderr
    assert (tmp_path / "r.svg").exists()


def test_meshes_are_named_from_the_folder_of_the_export(tmp_path: Path) -> None:
    (tmp_path / "r.yaml").write_text(PENDULUM.replace("MESH", "in/m.stl"))
    mesh = write_mesh(tmp_path / "in" / "m.stl")
    (tmp_path / "out").mkdir()
    for folder, expected in ((tmp_path, "in/m.stl"), (tmp_path / "out", f"file://{mesh}")):
        file = folder / "r.urdf"
        answer = call("export", str(tmp_path / "r.yaml"), "--output", str(file))
        assert answer.exit_code == 0, answer.output
        assert f'filename="{expected}"' in file.read_text()
    imported = tmp_path / "written.yaml"
    call("import", str(tmp_path / "r.yaml"), "--output", str(imported))
    assert "file: in/m.stl" in imported.read_text()
