"""Mistakes on the command line: hints, forms of values, errors for programs."""

from __future__ import annotations

import json
import sys
from importlib.abc import MetaPathFinder
from typing import Any

import pytest

from hybrid_dynamics_cli.__main__ import main
from tests.cli.calling import call


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
        (("fk", "forging_chu2020", "-u", "0,1"), 1, "InputError"),
        (("check", "missing.yaml"), 1, "DescriptionError"),
        (("fk", "forging_chu2020", "-u", "q12=much"), 2, "UsageError"),
        (("ik", "forging_chu2020"), 2, "UsageError"),
        (("chek", "forging_chu2020"), 2, "UsageError"),
    ],
)
def test_errors_are_json_where_json_is_asked_for(arguments: tuple[str, ...], code: int, kind: str) -> None:
    asked, plain = call(*arguments, "--json"), call(*arguments)
    told: dict[str, Any] = json.loads(asked.stdout)["error"]
    assert asked.exit_code == plain.exit_code == code
    assert told["kind"] == kind
    assert told["text"] in asked.stderr
    assert asked.stderr == plain.stderr
    assert not plain.stdout


def test_stdout_holds_one_document() -> None:
    """Where an answer stands already, what is wrong beside it goes to stderr alone."""
    answer = call("branches", "forging_chu2020", "-u", "q12=0.9", "--json")
    assert json.loads(answer.stdout) == {"modes": []}


@pytest.mark.parametrize("place", [("--position", "-0.05,0.3,0"), ("--position=-0.05, 0.3, 0",)])
def test_places_are_taken_with_commas_too(place: tuple[str, ...]) -> None:
    spaced = call("ik", "five_bar", "--position", "-0.05", "0.3", "0", "--axes", "x,y", "--json")
    assert spaced.exit_code == 0
    assert call("ik", "five_bar", *place, "--axes", "x,y", "--json").stdout == spaced.stdout


def test_a_term_with_a_comma_in_brackets_is_one() -> None:
    assert "'min(0.38,1)'" in call("ik", "five_bar", "--position", "min(0.38,1)", "0", "0").output


def test_what_is_no_number_is_told_before_how_many_there_are() -> None:
    result = call("fk", "excavator", "-u", "abc")
    assert result.exit_code == 2
    assert "'abc' of q1" in result.output
    assert "-u: 1 value; expected 4, for q1" in call("fk", "excavator", "-u", "1").output


def test_an_interrupt_while_python_imports_leaves_no_trace(monkeypatch: pytest.MonkeyPatch) -> None:
    class Interrupt(MetaPathFinder):
        def find_spec(self, name: str, *_: Any) -> None:
            if name == "hybrid_dynamics_cli.app":
                raise KeyboardInterrupt

    monkeypatch.delitem(sys.modules, "hybrid_dynamics_cli.app")
    monkeypatch.setattr(sys, "meta_path", [Interrupt(), *sys.meta_path])
    with pytest.raises(SystemExit, match="Aborted!"):
        main()
