"""Files of another kind: every verb says what there is, what it expected, and what takes it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hybrid_dynamics_core import shipped_robots
from hybrid_dynamics_core.ground.file_kinds import FileKind, classify_path
from tests.cli.calling import call, call_line, shipped_text

pytest.importorskip("rosbags")
PNG = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"
CSV = "time,q_L\r\n0.0,1.5\r\n0.1,1.6\r\n"
METADATA = "rosbag2_bagfile_information:\n  version: 9\n"
ROBOT = "a robot description (YAML, URDF, SDFormat or MJCF)"
BAG = "a recording (a rosbag2 folder, a .mcap or .db3 file, or one of them with .zstd behind)"


FILES: dict[str, tuple[bytes | str, FileKind, str]] = {
    "reach.png": (PNG, FileKind.PICTURE, "a PNG picture"),
    "drawing.svg": (
        '<?xml version="1.0"?>\n<!DOCTYPE svg>\n<svg/>',
        FileKind.PICTURE,
        "an SVG picture",
    ),
    "page.html": ("<!DOCTYPE html>\n<html></html>", FileKind.PAGE, "an HTML page"),
    "empty.yaml": ("\n", FileKind.OTHER, "an empty file"),
    "some.bin": (bytes(range(256)), FileKind.OTHER, "a binary file"),
    "dig.csv": (CSV, FileKind.TRAJECTORY, "a table (CSV)"),
    "run.py": ("import math\n\nprint(math.pi)\n", FileKind.TEXT, "a program"),
    "notes.txt": (
        "Look here: this is mine.\n",
        FileKind.TEXT,
        "a text file that describes no robot",
    ),
    "log.txt": (
        "Look at active:\nactive: none\n",
        FileKind.TEXT,
        "a text file that describes no robot",
    ),
    "node.yaml": (
        "/**:\n  ros__parameters:\n    rates: {tf: 1.0}\n",
        FileKind.SETTINGS,
        "a parameter file of the node",
    ),
    "metadata.yaml": (METADATA, FileKind.BAG_PART, "the metadata of a recording"),
    "arm.urdf": (
        '<?xml version="1.0"?>\n<!-- mine -->\n<robot name="a"/>',
        FileKind.ROBOT,
        "a robot description (XML)",
    ),
    "old.bag": (b"#ROSBAG V2.0\n", FileKind.OTHER, "a recording of ROS 1"),
    "packed.mcap.zstd": (b"\x28\xb5\x2f\xfd", FileKind.BAG, "a recording"),
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a file of each kind, and folders of them."""
    monkeypatch.chdir(tmp_path)
    for name, (content, _, _) in FILES.items():
        (tmp_path / name).write_bytes(content.encode() if isinstance(content, str) else content)
    (tmp_path / "own.yaml").write_text(shipped_text("five_bar"), encoding="utf-8")
    np.savez(tmp_path / "dig.npz", time=np.arange(3.0))
    for name, inside in (
        ("bag", "metadata.yaml"),
        ("night/one", "metadata.yaml"),
        ("tables", "a.csv"),
        ("void", ""),
    ):
        (tmp_path / name).mkdir(parents=True)
        if inside:
            (tmp_path / name / inside).write_text(METADATA, encoding="utf-8")
    return tmp_path


@pytest.mark.parametrize("name", FILES)
def test_a_file_is_classified_by_what_is_in_it(folder: Path, name: str) -> None:
    content = classify_path(folder / name)
    assert (content.kind, content.words) == FILES[name][1:]


def test_so_are_robots_archives_and_folders(folder: Path) -> None:
    wanted = {
        "own.yaml": FileKind.ROBOT,
        "dig.npz": FileKind.TRAJECTORY,
        "bag": FileKind.BAG,
        "night": FileKind.BAGS,
        "tables": FileKind.TABLES,
        "void": FileKind.OTHER,
        "nothing": FileKind.MISSING,
    }
    assert {name: classify_path(folder / name).kind for name in wanted} == wanted


def test_every_shipped_robot_is_classified_as_one(tmp_path: Path) -> None:
    file = tmp_path / "robot.yaml"
    for name in shipped_robots():
        file.write_text(shipped_text(name), encoding="utf-8")
        assert classify_path(file).kind is FileKind.ROBOT, name


OF_A_ROBOT = (
    "check {}",
    "info {}",
    "fk {}",
    "export {}",
    "simulate {}",
    "bag make made --robot {}",
)
OF_A_BAG = (
    "bag report {} --robot own.yaml",
    "bag identify {}",
    "bag export {} out",
    "bag process {} out --robot own.yaml",
)
HINTS = {
    "bag": "try: hybrid-dynamics bag report bag",
    "night": "try: hybrid-dynamics bag process night OUT --robot ROBOT",
    "metadata.yaml": "try: hybrid-dynamics bag report .",
    "dig.csv": "try: hybrid-dynamics view ROBOT --trajectory dig.csv",
    "own.yaml": "try: hybrid-dynamics check own.yaml",
    "tables": "name the recording that these tables were exported from",
}


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("lines", "expected", "names"),
    [
        (
            OF_A_ROBOT,
            ROBOT,
            (
                "reach.png",
                "empty.yaml",
                "some.bin",
                "dig.csv",
                "tables",
                "bag",
                "night",
                "metadata.yaml",
            ),
        ),
        (OF_A_BAG, BAG, ("reach.png", "empty.yaml", "own.yaml", "tables", "void", "dig.csv")),
    ],
)
def test_another_kind_is_reported_with_what_was_expected_and_what_takes_it(
    lines: tuple[str, ...], expected: str, names: tuple[str, ...]
) -> None:
    for name in names:
        words = classify_path(Path(name)).words
        for line in lines:
            result = call_line(line.format(name))
            assert result.exit_code == 2, (line, name)
            assert f"{name}: seems to be {words}; expected {expected}" in result.stderr, line
            assert HINTS.get(name, "Error") in result.stderr
            assert "Traceback" not in result.stderr


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("check owm.yaml", "owm.yaml: there is no such file or folder (did you mean 'own.yaml'?)"),
        ("bag report bog", "bog: there is no such file or folder (did you mean 'bag'?)"),
        (
            "bag make made --robot own.yaml --trajectory own.yaml",
            "own.yaml: seems to be a robot description (YAML)",
        ),
        (
            "bag make made --robot own.yaml --trajectory bag",
            "bag: seems to be a recording (rosbag2)",
        ),
        ("bag report bag --robot own.yaml --params dig.csv", "dig.csv: seems to be a table (CSV)"),
    ],
)
def test_names_and_other_files_are_reported_in_the_same_way(line: str, words: str) -> None:
    result = call_line(line)
    assert result.exit_code == 2
    assert words in result.stderr


@pytest.mark.parametrize(
    "make", [lambda text: text.replace("joints:", "joint:"), lambda text: text + "\n  - ["]
)
def test_a_fault_inside_a_robot_is_no_wrong_kind(
    tmp_path: Path, make: Callable[[str], str]
) -> None:
    place = tmp_path / "own.yaml"
    place.write_text(make(shipped_text("five_bar")), encoding="utf-8")
    result = call("check", str(place))
    assert result.exit_code == 1
    assert "seems to be" not in result.stderr


def test_a_long_comment_is_read_in_one_pass(tmp_path: Path) -> None:
    """Each line more must not double the work: a licence before a robot has dozens of them."""
    file = tmp_path / "a.xml"
    licence = "<!-- a line of a licence -->\n" * 400
    for content, kind in (
        ("<robot name='a'/>", FileKind.ROBOT),
        ("<launch/><!-- b --><robot/>", FileKind.TEXT),
    ):
        file.write_text(f"<?xml version='1.0'?>\n{licence}{content}", encoding="utf-8")
        assert classify_path(file).kind is kind
