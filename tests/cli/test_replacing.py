"""Which files verbs replace: their own with a note, others with --overwrite alone, inputs never."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.cli.calling import call, call_line, shipped_text
from tests.sampling import swept

Figure = pytest.importorskip("matplotlib.figure").Figure
WRITERS = {
    "check": ("check own.yaml --draw {}", ("a.svg", "a.png", "a.pdf")),
    "branches": ("branches own.yaml --draw {}", ("a.svg",)),
    "workspace": ("workspace own.yaml --samples 200 --draw {}", ("a.png",)),
    "motion": ("simulate own.yaml --seconds 0.02 -o {}", ("a.csv", "a.npz")),
    "figure": ("simulate own.yaml --seconds 0.02 --draw {}", ("a.svg",)),
    "report": ("bag report bag --output {}", ("a.html",)),
    "identify": ("bag identify bag --output {}", ("a.csv",)),
}


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A robot of one's own."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HYBRID_DYNAMICS_KERNELS", "python")
    (tmp_path / "own.yaml").write_text(shipped_text("five_bar"), encoding="utf-8")
    return tmp_path


LONG = ("branches", "check", "figure", "identify", "report", "workspace")


@pytest.mark.parametrize("name", swept(WRITERS, [name for name in WRITERS if name not in LONG]))
def test_results_are_replaced_and_what_is_of_another_origin_is_not(name: str, folder: Path) -> None:
    line, files = WRITERS[name]
    if line.startswith("bag"):
        pytest.importorskip("rosbags")
        made = "bag make bag --robot own.yaml --seconds 2 --rate 100 --noise effort=1"
        assert call_line(made).exit_code == 0
    for file in files:
        arguments = line.format(file).split()
        first = call(*arguments)
        assert first.exit_code == 0, first.output
        assert "replaced" not in first.output
        second = call(*arguments)
        assert second.exit_code == 0
        assert f"replaced: {file}\n" in second.stderr
        (folder / file).write_bytes(b"time,q1\n1,2\n")
        refused = call(*arguments)
        assert refused.exit_code == 2
        assert "not of this command; name another file, or give --overwrite" in refused.stderr
        assert (folder / file).read_bytes() == b"time,q1\n1,2\n"
        assert call(*arguments, "--overwrite").exit_code == 0
        assert (folder / file).read_bytes() != b"time,q1\n1,2\n"


@pytest.mark.parametrize("file", ["a.svg", "a.png", "a.pdf"])
def test_a_picture_that_others_made_with_matplotlib_is_not_replaced(
    file: str, folder: Path
) -> None:
    figure = Figure()
    figure.add_subplot().plot([1.0, 2.0])
    figure.savefig(folder / file)
    before = (folder / file).read_bytes()
    refused = call("check", "own.yaml", "--draw", file)
    assert refused.exit_code == 2
    assert "not of this command" in refused.stderr
    assert (folder / file).read_bytes() == before


def test_what_a_call_reads_is_never_replaced(folder: Path) -> None:
    text = (folder / "own.yaml").read_bytes()
    for link in ("a.svg", "a.csv"):
        (folder / link).symlink_to(folder / "own.yaml")
    for line in ("check own.yaml --draw a.svg", "simulate own.yaml --seconds 0.02 -o a.csv"):
        for more in ((), ("--overwrite",)):
            result = call(*line.split(), *more)
            assert result.exit_code == 2
            assert "is read by this call, and is not replaced; name another file" in result.stderr
    assert (folder / "own.yaml").read_bytes() == text


def test_other_endings_and_folders_are_refused_before_anything_is_done(folder: Path) -> None:
    (folder / "a.svg").mkdir()
    assert "is a folder; name a file in it" in call("check", "own.yaml", "--draw", "a.svg").stderr
    said = call("check", "own.yaml", "--draw", "own.yaml").stderr
    assert "own.yaml: expected a name that ends in .svg, .png or .pdf" in said


def test_nothing_is_named_as_replaced_before_it_is(tmp_path: Path) -> None:
    picture = tmp_path / "modes.svg"
    assert call("branches", "type_c", "--draw", str(picture)).exit_code == 0
    before = picture.read_bytes()
    failed = call("branches", "type_c", "-u", "q2=5", "--draw", str(picture))
    assert failed.exit_code == 1
    assert "replaced" not in failed.output
    assert picture.read_bytes() == before
    assert f"replaced: {picture}" in call("branches", "type_c", "--draw", str(picture)).stderr


def test_a_pipe_is_no_place_for_a_picture(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.svg"
    os.mkfifo(pipe)
    refused = call("check", "five_bar", "--draw", str(pipe))
    assert refused.exit_code == 2
    assert "no regular file" in refused.stderr
