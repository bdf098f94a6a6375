"""Slips in a file: what is told is where they are, what was expected, and in the words of the file."""

from __future__ import annotations

import re

import pytest

from hybrid_dynamics_core import DescriptionError
from tests.description.robots import four_bar, parse


def told(text: str) -> str:
    with pytest.raises(DescriptionError) as caught:
        parse(text)
    return str(caught.value)


@pytest.mark.parametrize(("name", "hint"), [("ground", "base"), ("bsae", "base")])
def test_a_base_that_is_no_link_is_told_at_its_key(name: str, hint: str) -> None:
    text = told(four_bar("A") + f"base: {name}\n")
    assert re.search(rf": base: there is no link '{name}' \(did you mean '{hint}'\?\); known: base, ", text)


def test_a_base_that_only_joints_name_is_a_link() -> None:
    text = four_bar("A").replace("  base: {}\n", "").replace("base: base", "base: ground")
    assert parse(text.replace("parent: base", "parent: ground") + "base: ground\n").base == "ground"


@pytest.mark.parametrize(
    ("text", "line", "column", "above"),
    [
        ("a:\n   x: {}\n  y: {}\n", 3, 3, (2, 4)),
        ("a:\n  x: {}\n   y: {}\n", 3, 4, (2, 3)),
        ("a:\n  x: 1\n   y: 2\n", 3, 4, (2, 3)),
        ("a:\n  x: {p: 1,\n    q: 2}\n # note\n   y: {}\n", 5, 4, (2, 3)),
        ("a:\n  - {x: 1}\n b: 2\n", 3, 2, (2, 3)),
    ],
)
def test_indentation_is_told_with_both_lines(text: str, line: int, column: int, above: tuple[int, int]) -> None:
    assert told(text) == (
        f"small.yaml:{line}: not valid YAML: the indentation does not fit: this line begins in column {column}, the "
        f"entry above it (line {above[0]}) in column {above[1]}; entries that belong together begin in one column, "
        "parts of an entry further right"
    )


def test_tabs_and_second_colons_are_told_as_such() -> None:
    assert "small.yaml:2: not valid YAML: a line is indented with a tab; indent with spaces" in told("a:\n\tx: 1\n")
    assert "a second ':' in one line; put text that has one in quotes" in told("a: 1\nsource: of: somebody\n")


def test_a_file_without_its_format_is_told_how_to_write_it() -> None:
    assert "missing 'format'; write `format: 1`" in told(four_bar("A").replace("format: 1\n", ""))


@pytest.mark.parametrize("value", ["18 kg", "70mm", "70 mm", "0.5 kg m^2", "1e3 N", "90°"])
def test_units_are_fixed(value: str) -> None:
    text = told(four_bar("A").replace("tool: {mass: 0.5}", f"tool: {{mass: {value}}}"))
    assert f"tool.mass: '{value}' has a unit; units are fixed: m, kg, s, N, rad (30*deg): write" in text


def test_a_type_that_does_not_fit_is_told_in_words_of_the_file() -> None:
    text = told(four_bar("A").replace("type: A", "type: B"))
    assert re.search(
        r"in a loop of Type B the link of `k2` hangs on that of `arm`, but here '\w+' hangs on '\w+', not on '\w+'",
        text,
    )
    assert "l_" not in text
    assert "the links as given form Type A" in text
