"""Files that this library wrote, read back: no note of what it wrote itself for other programs."""

from __future__ import annotations

from pathlib import Path

import pytest

from hybrid_dynamics_core import Robot, load, shipped_robots
from hybrid_dynamics_core.export import to_urdf, to_yaml
from tests.export.test_round_trip import FORMS, write
from tests.robots import robot
from tests.sampling import swept


def read_back(text: str, folder: Path, name: str = "robot.urdf") -> Robot:
    """The robot of a text in a file."""
    file = folder / name
    file.write_text(text, encoding="utf-8")
    return load(file)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", swept(shipped_robots(), sample=("ankle", "excavator")))
def test_a_file_of_this_library_needs_no_notes(name: str, form: str, tmp_path: Path) -> None:
    """Slender rods, drawn poses beyond limits: all that the file's entries put right."""
    assert load(write(robot(name), form, tmp_path)).description.notes == ()


def test_neither_does_a_description_file(tmp_path: Path) -> None:
    assert read_back(to_yaml(robot("ankle")), tmp_path, "robot.yaml").description.notes == ()


@pytest.mark.parametrize("name", ["ankle", "forging_chu2020"])
def test_a_plain_urdf_says_which_loops_were_cut(name: str, tmp_path: Path) -> None:
    machine = robot(name)
    first, *others = read_back(to_urdf(machine), tmp_path).description.notes
    assert not any("loop" in note for note in others)
    loops = ", ".join(closure.name for closure in machine.description.closures)
    assert first.startswith(f"robot.urdf:2: loops were cut when this file was written: {loops}.")
    assert "urdf+" in first


def test_what_others_add_to_such_a_file_is_noted(tmp_path: Path) -> None:
    """Only the words that this library writes go without a note, and only in its own files."""
    text = write(robot("ankle"), "mjcf", tmp_path).read_text(encoding="utf-8")
    edited = text.replace("<option ", '<option tolerance="1e-8" ', 1)
    (note,) = read_back(edited, tmp_path, "robot.xml").description.notes
    assert note.startswith("tolerance of <option> is left out")
    foreign = text.replace('name="hybrid_dynamics"', 'name="others"')
    notes = read_back(foreign, tmp_path, "robot.xml").description.notes
    assert any(note.startswith("timestep, integrator of <option> are left out") for note in notes)


def test_a_tree_has_no_loops_that_were_cut(tmp_path: Path) -> None:
    text = to_urdf(robot("ankle"))
    opened = read_back(text, tmp_path)
    assert read_back(to_urdf(opened), tmp_path).description.notes == ()
