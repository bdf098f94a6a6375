"""Mistakes on the command line: hints, forms of values, errors for programs."""

from __future__ import annotations

import json
import sys
from importlib.abc import MetaPathFinder
from pathlib import Path
from typing import Any

import pytest

from hybrid_dynamics_cli.__main__ import main
from tests.cli.calling import Answer, call


def test_a_verb_that_is_not_there_gets_a_hint() -> None:
    result = call("chek", "excavator")
    assert result.exit_code == 2
    assert "No such command 'chek' (did you mean 'check'?); known: check, info, " in result.output


def test_so_does_a_verb_of_bag() -> None:
    pytest.importorskip("rosbags")
    assert "No such command 'procss' (did you mean 'process'?)" in call("bag", "procss").output


@pytest.mark.parametrize(
    ("arguments", "code", "kind"),
    [
        (("fk", "forging_chu2020", "-u", "q12=0.9"), 1, "ClosureError"),
        (("fk", "forging_chu2020", "-u", "0,1"), 2, "InputError"),
        (("check", "missing.yaml"), 2, "NoDescriptionError"),
        (("fk", "forging_chu2020", "-u", "q12=much"), 2, "UsageError"),
        (("ik", "forging_chu2020"), 2, "UsageError"),
        (("chek", "forging_chu2020"), 2, "UsageError"),
    ],
)
def test_errors_are_json_where_json_is_asked_for(
    arguments: tuple[str, ...], code: int, kind: str
) -> None:
    asked = call(*arguments, "--json")
    plain = call(*arguments)
    error: dict[str, Any] = json.loads(asked.stdout)["error"]
    assert asked.exit_code == plain.exit_code == code
    assert error["kind"] == kind
    assert error["text"] in asked.stderr
    assert asked.stderr == plain.stderr
    assert not plain.stdout


def test_stdout_holds_one_document() -> None:
    """Where an answer stands already, what is wrong beside it goes to stderr alone."""
    answer = call("branches", "forging_chu2020", "-u", "q12=0.9", "--json")
    assert json.loads(answer.stdout)["modes"] == []


@pytest.mark.parametrize("place", [("--position", "-0.05,0.3,0"), ("--position=-0.05, 0.3, 0",)])
def test_places_are_taken_with_commas_too(place: tuple[str, ...]) -> None:
    spaced = call("ik", "five_bar", "--position", "-0.05", "0.3", "0", "--axes", "x,y", "--json")
    assert spaced.exit_code == 0
    assert call("ik", "five_bar", *place, "--axes", "x,y", "--json").stdout == spaced.stdout


def test_a_term_with_a_comma_in_brackets_is_one() -> None:
    assert "'min(0.38,1)'" in call("ik", "five_bar", "--position", "min(0.38,1)", "0", "0").output


def test_what_is_no_number_is_reported_before_their_number() -> None:
    result = call("fk", "excavator", "-u", "abc")
    assert result.exit_code == 2
    assert "'abc' of slew" in result.output
    assert "-u: 1 value; expected 4, for slew" in call("fk", "excavator", "-u", "1").output


def test_an_interrupt_while_python_imports_leaves_no_trace(monkeypatch: pytest.MonkeyPatch) -> None:
    class Interrupt(MetaPathFinder):
        def find_spec(self, name: str, *_: Any) -> None:
            if name == "hybrid_dynamics_cli.app":
                raise KeyboardInterrupt

    monkeypatch.delitem(sys.modules, "hybrid_dynamics_cli.app")
    monkeypatch.setattr(sys, "meta_path", [Interrupt(), *sys.meta_path])
    with pytest.raises(SystemExit, match="Aborted!"):
        main()


def flat(result: Answer) -> str:
    """The message in one line, whatever its exit code; it is not 0."""
    assert result.exit_code != 0
    return " ".join(result.output.split())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            ("fk", "palletizer", "-u", "Q1=1"),
            "-u: 'Q1' is not an active joint (did you mean 'q1'?)",
        ),
        (
            ("simulate", "excavator", "--tau", "weigth"),
            "'weigth' (did you mean 'weight'?); expected efforts",
        ),
        (
            ("workspace", "excavator", "--range", "slew=0"),
            "'slew=0': expected NAME=LOW:HIGH, as q12=0.1:0.5",
        ),
        (
            ("workspace", "excavator", "--range", "slew"),
            "'slew': expected NAME=LOW:HIGH, as q12=0.1:0.5",
        ),
        (
            ("workspace", "excavator", "--range", "slew=0:x"),
            "'x' is not a number, pi or a unit; expected NAME=LOW:HIGH",
        ),
        (
            ("workspace", "excavator", "--range", "boom_cylindr=0:1"),
            "--range: 'boom_cylindr' is not an active joint (did you mean 'boom_cylinder'",
        ),
        (
            ("fk", "excavator", "-u", "boom_cylinder=70mm"),
            "(did you mean '70*mm'?)",
        ),
        (("fk", "excavator", "-u", "boom_cylinder=0.7 m"), "(did you mean '0.7*m'?)"),
        (("fk", "excavator", "-u", "boom_cylinder=much"), "'much' is not a number, pi or a unit"),
        (
            ("fk", "five_bar", "-u", "0 -0.06*pi"),
            "-u: 1 value; expected 3, for q_L, q_R, q_T; values are parted by commas: 0,-0.06*pi",
        ),
        (("fk", "five_bar", "-u", "0.1 2"), "units); values are parted by commas: 0.1,2"),
        (("fk", "five_bar", "-u", "0.1;2"), "units); values are parted by commas: 0.1,2"),
        (
            ("fk", "excavator", "-u", "slew=1 boom_cylinder=2"),
            "'slew=1 boom_cylinder=2'; values are parted by commas: slew=1,boom_cylinder=2",
        ),
        (
            ("simulate", "excavator", "--tau", "weight,stick_cylinder=2100"),
            "a word such as 'weight' is taken, it stands alone",
        ),
        (
            ("fk", "excavator", "-u", "boom_cylinder=1;2"),
            "numbers, pi and units); values are parted by commas",
        ),
        (
            ("fk", "excavator", "-u", "boom_cylinder=1;2"),
            "neither a number nor an expression (+ - * / over numbers, pi and units)",
        ),
    ],
)
def test_slips_are_reported_with_what_was_expected(arguments: tuple[str, ...], words: str) -> None:
    text = flat(call(*arguments))
    assert words in text
    assert "unpack" not in text
    assert "parameters" not in text  # of which a command line has none


def test_a_map_names_its_option(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    arguments = ("workspace", "five_bar", "--samples", "100", "--draw", str(tmp_path / "map.svg"))
    assert "Error: --over: 'q_X' is not an active joint (did you mean" in flat(
        call(*arguments, "--over", "q_X,q_T")
    )


@pytest.mark.parametrize("words", ["view excavator", "bag make made --robot excavator"])
def test_a_picture_is_no_trajectory(
    words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("rosbags" if words.startswith("bag") else "viser")
    monkeypatch.chdir(tmp_path)
    Path("reach.png").write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR")
    text = flat(call(*words.split(), "--trajectory", "reach.png"))
    assert (
        "reach.png: seems to be a PNG picture; expected a trajectory (CSV with the columns time and"
        " JOINT" in text
    )
    assert "codec" not in text


def test_a_port_beyond_the_last_is_refused_as_such() -> None:
    result = call("view", "five_bar", "--port", "65536", "--trajectory", "a", "--bag", "b")
    assert result.exit_code == 2
    assert "65536 is not in the range 0<=x<=65535" in flat(result)


TWICE = {
    "coordinates": ("id excavator -u slew=0.1,stick_cylinder=0.5,slew=0.2", "-u: slew"),
    "rates": ("id excavator --du slew=0.1,slew=0.1", "--du: slew"),
    "efforts": ("fd excavator --tau slew=1,slew=2", "--tau: slew"),
    "held": ("workspace five_bar --samples 9 --hold q_R=1 --hold q_R=2", "--hold: q_R"),
    "range": ("workspace five_bar --samples 9 --range q_R=0:1 --range q_R=0:2", "--range: q_R"),
    "noise": ("bag make no_bag --robot five_bar --noise effort=1,effort=2", "--noise: effort"),
    "limit": ("capability excavator --limit slew=1 --limit slew=2", "--limit: slew"),
}


@pytest.mark.parametrize(("line", "what"), TWICE.values(), ids=TWICE.keys())
def test_what_is_given_twice_is_refused(line: str, what: str) -> None:
    """Otherwise one of the two would count, and nobody knows which."""
    pytest.importorskip("rosbags")
    answer = call(*line.split())
    assert answer.exit_code == 2
    assert f"{what} is given twice" in flat(answer)


@pytest.mark.parametrize("option", ["-u", "--du", "--ddu"])
def test_an_empty_text_is_no_default(option: str) -> None:
    """As a variable of the shell leaves it that is not set."""
    answer = call("id", "excavator", option, "")
    assert answer.exit_code == 2
    assert f"{option}: no values; expected those of slew" in flat(answer)
