"""Slips in a file: where they are, what was expected, in the words of the file."""

from __future__ import annotations

import re

import pytest

from hybrid_dynamics_core import DescriptionError, Robot
from tests.description.robots import HEAD, four_bar, parse

LIFT = (
    HEAD
    + """\
links:
  base: {}
  crank: {mass: 10}
  barrel: {mass: 4}
  rod: {mass: 2}
joints:
  q1: {type: revolute, parent: base, child: crank, axis: z,
       origin: {xyz: [0.3, 0, 0.5], rpy: [pi/2, 0, 0]}}
  q2: {type: revolute, parent: base, child: barrel, origin: {rpy: [pi/2, 0, 0]}, axis: z}
  stroke: {type: prismatic, parent: barrel, child: rod, origin: {xyz: [0.4, 0, 0]}, axis: x}
loops:
  lift: {type: A, base: base, arm: crank, k1: barrel, k2: rod,
         pin: {rod: [0, 0, 0], crank: [0.6, 0, 0]}, assembly: clockwise}
active: [stroke]
end_effector: {link: crank}
"""
)


def message_of(text: str) -> str:
    with pytest.raises(DescriptionError) as caught:
        Robot(parse(text))
    return str(caught.value)


@pytest.mark.parametrize(("name", "hint"), [("ground", "base"), ("bsae", "base")])
def test_a_base_that_is_no_link_is_reported_at_its_key(name: str, hint: str) -> None:
    text = message_of(four_bar("A") + f"base: {name}\n")
    assert re.search(
        rf": base: there is no link '{name}' \(did you mean '{hint}'\?\); known: base, ", text
    )


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
def test_indentation_is_reported_with_both_lines(
    text: str, line: int, column: int, above: tuple[int, int]
) -> None:
    assert (
        message_of(text)
        == f"small.yaml:{line}: not valid YAML: the indentation does not fit: this line begins in"
        f" column {column}, the entry above it (line {above[0]}) in column {above[1]}; entries"
        " that belong together begin in one column, parts of an entry further right"
    )


def test_tabs_and_second_colons_are_reported_as_such() -> None:
    assert (
        "small.yaml:2: not valid YAML: a line is indented with a tab; indent with spaces"
        in message_of("a:\n\tx: 1\n")
    )
    assert "a second ':' in one line; put text that has one in quotes" in message_of(
        "a: 1\nsource: of: somebody\n"
    )


@pytest.mark.parametrize("text", ["a: 1\nb: \tc: 2\n", "a:\n  - x\n  -\t\ty: 1\n"])
def test_a_tab_after_a_sign_is_not_called_an_indentation(text: str) -> None:
    message = message_of(text)
    assert r"found character '\t' that cannot start any token" in message
    assert "indented" not in message


def test_a_file_without_its_format_says_how_to_write_it() -> None:
    assert "missing 'format'; write `format: 1`" in message_of(
        four_bar("A").replace("format: 1\n", "")
    )


UNITS = {
    "18 kg": "18*kg",
    "70mm": "70*mm",
    "70 mm": "70*mm",
    "0.5 kg m^2": "0.5*kg*m*m",
    "0.5 kg m²": "0.5*kg*m*m",
    "1e3 N": "1e3*N",
    "3 N m": "3*N*m",
    "90°": "90*deg",
}


@pytest.mark.parametrize(("value", "meant"), UNITS.items())
def test_units_without_a_sign_are_told_with_it(value: str, meant: str) -> None:
    text = message_of(four_bar("A").replace("tool: {mass: 0.5}", f"tool: {{mass: {value}}}"))
    assert f"tool.mass: '{value}' is neither a number nor an expression" in text
    assert f"(did you mean '{meant}'?)" in text


@pytest.mark.parametrize("value", ["3 lb", "5 in", "7 furlongs"])
def test_units_that_are_not_known_are_told(value: str) -> None:
    text = message_of(four_bar("A").replace("tool: {mass: 0.5}", f"tool: {{mass: {value}}}"))
    assert f"tool.mass: '{value}' has a unit that is not known here; units are factors, as" in text


def test_a_type_that_does_not_fit_is_reported_in_words_of_the_file() -> None:
    text = message_of(four_bar("A").replace("type: A", "type: B"))
    assert re.search(
        r"in a loop of Type B the link of `k2` hangs on that of `arm`, but here '\w+' hangs on"
        r" '\w+', not on '\w+'",
        text,
    )
    assert "l_" not in text
    assert "the links as given form Type A" in text


@pytest.mark.parametrize(
    ("right", "wrong", "words"),
    [
        (
            "tool: {mass: 0.5}",
            "tool: {mass: 3,2}",
            r"links\.tool\.2: unknown key; .* \(did you mean 'mass: 3\.2'\?\)",
        ),
        (
            "tool: {mass: 0.5}",
            "tool: {mass: '3,2'}",
            r"tool\.mass: '3,2' is no number; .* \(did you mean '3\.2'\?\)",
        ),
        (
            "tool: {mass: 0.5}",
            "tool: {mass: 1, com: [0,8, 0,1, 0]}",
            r"com: has 5 entries; expected 3; decimals are",
        ),
        (
            "format: 1\n",
            "format: 1\nparameters: {a: 0,65}\n",
            r"parameters: '65' is not a valid name.* as 0\.65",
        ),
    ],
    ids=["mapping", "text", "list", "parameter"],
)
def test_decimal_commas_are_reported_as_such(right: str, wrong: str, words: str) -> None:
    text = four_bar("A")
    assert right in text
    assert re.search(words, message_of(text.replace(right, wrong)))


def test_keys_and_lists_that_are_no_decimals_are_not_taken_for_some() -> None:
    text = four_bar("A")
    assert "decimals" not in message_of(text.replace("tool: {mass: 0.5}", "tool: {mass: 3, 2: 1}"))
    assert "decimals" not in message_of(
        text.replace("tool: {mass: 0.5}", "tool: {mass: 1, com: [0.8, 0.1, 0, 0]}")
    )


def test_a_link_among_the_active_joints_is_reported_with_its_joint() -> None:
    text = message_of(re.sub(r"active: \[.*\]", "active: [tool]", four_bar("A")))
    assert re.search(
        r"active\[0\]: 'tool' is a link; name the joint that moves it \(did you mean '\w+'\?\)",
        text,
    )


@pytest.mark.parametrize(
    ("key", "as_in"), [("active", "active: [q1, q2]"), ("end_effector", "end_effector: {link: ")]
)
def test_what_is_missing_is_reported_as_it_is_written(key: str, as_in: str) -> None:
    text = re.sub(rf"^{key}: .*\n", "", four_bar("A"), flags=re.MULTILINE)
    assert re.search(rf"missing '{key}'; name .*, as in `{re.escape(as_in)}", message_of(text))


def test_a_point_with_two_numbers_and_a_list_of_moments_are_reported_with_the_form() -> None:
    text = four_bar("A")
    assert "has 2 entries; expected 3, as in [x, y, z]" in message_of(
        re.sub(r"com: \[[^]]*\]", "com: [0.1, 0]", text)
    )
    moments = message_of(
        text.replace("tool: {mass: 0.5}", "tool: {mass: 0.5, inertia: [0.1, 0.1, 0.2]}")
    )
    assert "as in inertia: {xx: 0.1, yy: 0.1, zz: 0.1}" in moments


def test_two_pivots_about_different_axes_are_both_reported() -> None:
    """Nothing tells which of the two is wrong."""
    text = message_of(LIFT.replace("barrel, origin: {rpy: [pi/2, 0, 0]}", "barrel, origin: {}"))
    assert (
        "joints turn about different axes, 'q2' about [0, 0, 1] and 'q1' about [0, -1, 0]; mend"
        " the rpy" in text
    )


def test_a_loop_that_was_forgotten_is_thought_of() -> None:
    text = message_of(re.sub(r"loops:\n(  .*\n)+", "", LIFT))
    assert (
        "name 3: besides those named, q1, q2; or a loop is missing: nothing is tied to 'rod'"
        in text
    )
