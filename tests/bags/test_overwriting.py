"""Nothing that is there is lost, whatever folder is named as OUT."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("click")

from tests.cli.calling import call

MAKE = ["bag", "make", "--robot", "five_bar", "--seconds", "0.05"]
PROCESS = ["bag", "process", "--robot", "five_bar"]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with two recordings and notes."""
    monkeypatch.chdir(tmp_path)
    for name in ("a", "b"):
        assert call(*MAKE, name).exit_code == 0
    (tmp_path / "work").mkdir()
    for name in ("work/notes.txt", "page.html", "table.csv"):
        (tmp_path / name).write_text("mine", encoding="utf-8")
    return tmp_path


@pytest.mark.sweep(sample="test_what_is_there_stays")
def test_a_page_is_replaced_where_asked_for(folder: Path) -> None:
    pytest.importorskip("matplotlib")
    assert call("bag", "report", "a", "--output", "page.html", "--overwrite").exit_code == 0
    assert (folder / "page.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


def test_times_of_a_trajectory_are_its_own(folder: Path) -> None:
    (folder / "swing.csv").write_text("time,q_A,q_X\n", encoding="utf-8")
    done = call(*MAKE, "c", "--trajectory", "swing.csv")
    assert done.exit_code == 2
    assert "a trajectory has its own times" in done.output


def contents(folder: Path) -> dict[str, bytes]:
    return {
        str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()
    }


@pytest.mark.parametrize(
    "words",
    [
        [*PROCESS, "a", "work"],
        [*PROCESS, "a", "."],
        [*PROCESS, "a", "b"],  # OUT forgotten
        [*PROCESS, "a", "a"],
        [*PROCESS, "a/a.mcap", "a"],
        [*PROCESS, "--overwrite", "a/a.mcap", "a"],
        [*PROCESS, "--overwrite", "a", "work"],
        [*PROCESS, "a", "b", "b"],
        [*MAKE, "a"],
        [*MAKE, "work"],
        [*MAKE, "--overwrite", "work"],
        [*MAKE, "--overwrite", "."],
        [*MAKE, "work/notes.txt"],
        ["bag", "report", "a", "--output", "work/notes.txt"],
        ["bag", "report", "a", "--output", "a/a.mcap", "--overwrite"],
        ["bag", "report", "a", "--output", "page.html"],
        ["bag", "identify", "a", "--output", "a/a.mcap", "--overwrite"],
        ["bag", "identify", "a", "--output", "table.csv"],
    ],
    ids=" ".join,
)
def test_what_is_there_stays(folder: Path, words: list[str]) -> None:
    before = contents(folder)
    done = call(*words)
    assert done.exit_code != 0
    assert contents(folder) == before


def test_a_bag_is_replaced_where_that_is_said(folder: Path) -> None:
    before = contents(folder / "b")
    assert call(*MAKE, "--overwrite", "--seed", "3", "b").exit_code == 0
    assert contents(folder / "b") != before
    assert call(*PROCESS, "--overwrite", "a", "b").exit_code == 0
    (folder / "new").mkdir()
    assert call(*PROCESS, "a", "new").exit_code == 0
    assert set(contents(folder / "new")) == {"metadata.yaml", "new.mcap"}


@pytest.mark.usefixtures("folder")
def test_a_forgotten_out_is_told() -> None:
    done = call(*PROCESS, "a", "b")
    words = " ".join(done.output.split())
    assert "b: there is a bag already; name a new folder, or give --overwrite" in words
    assert "(read as IN: a, as OUT: b; is OUT missing?)" in words
    assert call(*MAKE, "c").exit_code == 0
    words = " ".join(call(*PROCESS, "a", "c", "b").output.split())
    assert (
        "b: is a bag, and expected is a folder for the new bags (read as IN: a, c, as OUT: b; is"
        " OUT miss" in words
    )


def test_a_second_run_into_the_same_folder_says_what_to_do(folder: Path) -> None:
    assert call(*PROCESS, "a", "results").exit_code == 0
    before = contents(folder)
    done = call(*PROCESS, "a", "results")
    assert done.exit_code == 2
    assert "results: holds the results of an earlier `bag process`; give --overwrite" in done.output
    assert contents(folder) == before
    assert call(*PROCESS, "a", "results", "--overwrite").exit_code == 0
