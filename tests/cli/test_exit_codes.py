"""One rule for all verbs: 2 where the call is wrong, 1 where it is right and the answer is no."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.calling import call, call_line
from tests.cli.test_help import ALL, options_of

pytest.importorskip("rosbags")
OPEN = ("-u", "q12=0.9")  # of the forging robot: its first loop does not close there


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A recording, and what is no recording; kernels that need no compiling."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HYBRID_DYNAMICS_KERNELS", "python")
    return tmp_path


NEEDING = {  # further options of verbs that take ROBOT
    "ik": ["--position", "0", "0.3", "0"],
    "sweep": ["--vary", "crank=0.17:0.19:2", "-o", "sweep"],
    "tolerances": ["--tolerance", "crank=0.1*mm"],
    "size": ["--cycle", "cycle.csv", "--catalogue", "drives.csv", "--drive", "q1"],
}
DESIGNED = ["--class", "II", "--modules", "delta: base_radius=0.2 platform_radius=0.1 arm=1 rod=2"]
DESIGNED += ["--links", "1", "-o", "out"]
ESTIMATED = {  # further options of verbs that take DATA and --robot
    "weigh": [],
    "calibrate": ["--free", "bar"],
    "estimate": ["--sensors", "sensors.yaml"],
}


def given(words: tuple[str, ...], robot: str, bag: str) -> list[str]:
    """The least that a verb has to be given."""
    verb = words[0]
    if verb == "bag":
        return [*words, *given_to_bag(words[1], robot, bag)]
    if verb == "benchmark":
        return list(words)
    if verb in NEEDING:
        return [*words, robot, *NEEDING[verb]]
    if verb == "design":
        return [*words, *DESIGNED, "--cycle", robot]
    if verb in ESTIMATED:
        return [*words, bag, "--robot", robot, *ESTIMATED[verb]]
    return [*words, robot]


def given_to_bag(verb: str, robot: str, bag: str) -> list[str]:
    """The same for a verb of `bag`."""
    if verb == "make":
        return ["out", "--robot", robot]
    if verb == "export":
        return [bag, "out"]
    if verb == "process":
        return [bag, "out", "--robot", robot]
    return [bag, "--robot", robot]


@pytest.mark.parametrize("words", ALL, ids="-".join)
def test_an_option_that_there_is_not_ends_with_2(words: tuple[str, ...]) -> None:
    assert call(*given(words, "five_bar", "bag"), "--no-such-option").exit_code == 2


@pytest.mark.parametrize("words", [words for words in ALL if words != ("benchmark",)], ids="-".join)
def test_a_robot_or_bag_that_is_not_there_ends_with_2(words: tuple[str, ...]) -> None:
    if words == ("view",):
        pytest.importorskip("viser")
    result = call(*given(words, "nowhere.yaml", "nowhere"))
    assert result.exit_code == 2
    assert "there is no such file or folder" in result.stderr
    assert "Traceback" not in result.stderr


@pytest.mark.parametrize(
    "words",
    [words for words in ALL if "-o" in options_of(words)],
    ids="-".join,
)
def test_a_place_that_there_is_not_ends_with_2(words: tuple[str, ...], folder: Path) -> None:
    assert call_line("bag make bag --robot five_bar --seconds 0.05").exit_code == 0
    for spelling in ("-o", "--output"):
        result = call(*given(words, "five_bar", "bag"), spelling, "nowhere/file.csv")
        assert result.exit_code == 2
        assert "nowhere/file.csv: there is no folder nowhere" in result.stderr
    assert [entry.name for entry in folder.iterdir()] == ["bag"]


@pytest.mark.parametrize(
    "line",
    [
        "fk five_bar -u q_Z=1",
        "fk five_bar -u 1,2",
        "fk five_bar --frame nothing",
        "id five_bar --ddu 1e400,0,0",
        "fd five_bar --tau q_Z=1",
        "ik five_bar --position 0 0.3 0 --seed q_Z=1",
        "ik five_bar --position 0 0.3 0 --axes x,w",
        "simulate five_bar -u q_L=99",
        "simulate five_bar --tau weigth",
        "workspace five_bar --range q_L=-9:9",
        "branches five_bar -u q_Z=1",
        "check five_bar --modes",
        "check five_bar --draw five_bar.gif",
        "simulate five_bar -o motion.txt",
        "export five_bar --format robot.yaml",
        "bag make out --robot five_bar --noise 5",
        "bag make out --robot five_bar --noise positon=5",
        "bag make out --robot five_bar --noise position=-1",
    ],
)
def test_a_wrong_name_or_value_ends_with_2(line: str, folder: Path) -> None:
    result = call_line(line)
    assert result.exit_code == 2, result.output
    assert "Traceback" not in result.output
    assert not list(folder.iterdir())


@pytest.mark.parametrize(
    "arguments",
    [
        ("fk", "forging_chu2020", *OPEN),
        ("id", "forging_chu2020", *OPEN),
        ("fd", "forging_chu2020", *OPEN),
        ("simulate", "forging_chu2020", *OPEN),
        ("branches", "forging_chu2020", *OPEN),
        ("ik", "forging_chu2020", "--position", "9", "0", "0"),
    ],
    ids=lambda arguments: arguments[0],
)
def test_a_right_call_whose_answer_is_no_ends_with_1(arguments: tuple[str, ...]) -> None:
    assert call(*arguments).exit_code == 1


def test_so_do_faults_inside_files(folder: Path) -> None:
    (folder / "own.yaml").write_text("format: 1\nlinks: {}\n", encoding="utf-8")
    (folder / "dig.csv").write_text("time,q_L\n0,1\n1,1\n", encoding="utf-8")
    (folder / "bag.mcap").write_bytes(b"no recording")
    for line in (
        "check own.yaml",
        "export own.yaml",
        "bag make out --robot five_bar --trajectory dig.csv",
        "bag process bag.mcap out --robot five_bar",
    ):
        assert call_line(line).exit_code == 1, line


def test_a_wrong_topic_ends_with_2_in_every_verb_of_bags(folder: Path) -> None:
    assert call_line("bag make bag --robot five_bar --seconds 0.05").exit_code == 0
    for verb in ("process", "report", "identify", "export"):
        topic = "/hybrid_dynamics/active_joint_state"
        result = call(*given(("bag", verb), "five_bar", "bag"), "--topic", topic)
        assert result.exit_code == 2, verb
        assert "(did you mean '/hybrid_dynamics/active_joint_states'?)" in result.stderr
    assert [entry.name for entry in folder.iterdir()] == ["bag"]
