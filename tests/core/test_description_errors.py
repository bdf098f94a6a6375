"""A wrong file gets one message: file, line, key, what was expected."""

from __future__ import annotations

import re
from importlib import resources
from pathlib import Path

import pytest

from hybrid_dynamics_core import DescriptionError, InputError, load
from hybrid_dynamics_core.ground.file_kinds import NoDescriptionError

GOOD = (
    resources.files("hybrid_dynamics_core")
    .joinpath("robots/forging_chu2020.yaml")
    .read_text(encoding="utf-8")
)


def load_text(folder: Path, text: str) -> object:
    path = folder / "robot.yaml"
    path.write_text(text, encoding="utf-8")
    return load(path)


CASES = {
    "unknown key": ("l2:  {mass:", "l2:  {masss:", "links.l2.masss", "did you mean 'mass'"),
    "missing key": ("active: [q1, q12, q22, q4]\n", "", "", "missing 'active'"),
    "wrong type": ("gravity: [0, 0, -9.81]", "gravity: down", "gravity", "expected a list"),
    "vector of two": (
        "gravity: [0, 0, -9.81]",
        "gravity: [0, -9.81]",
        "gravity",
        "2 entries; expected 3",
    ),
    "negative mass": ("mass: 50.6", "mass: -50.6", "links.l2.mass", "zero or positive"),
    "no such parameter": (
        "com: [L11/2, 0, 0]",
        "com: [L1x/2, 0, 0]",
        "links.l11.com[0]",
        "'L1x' is not one of the",
    ),
    "not an expression": (
        "L1: 0.7",
        "L1: 0.7 +",
        "parameters.L1",
        "neither a number nor an expression",
    ),
    "a unit": (
        "L1: 0.7",
        "L1: 0.7 m",
        "parameters.L1",
        "(did you mean '0.7*m'?)",
    ),
    "code is no expression": (
        "L1: 0.7",
        "L1: __import__('os').getpid()",
        "parameters.L1",
        "something else than numbers",
    ),
    "missing link": (
        "parent: l42, child: l4,",
        "parent: l43, child: l4,",
        "joints.q4.parent",
        "no link 'l43'",
    ),
    "two parents": (
        "parent: l42, child: l4,",
        "parent: l42, child: l3,",
        "joints.q4.child",
        "already hangs on joint 'q3'",
    ),
    "cycle": (
        "q1:  {type: revolute, parent: base",
        "q1:  {type: revolute, parent: l2",
        "joints.q",
        "cycle",
    ),
    "unknown joint": ("active: [q1, q12", "active: [q1, q13", "active[1]", "did you mean"),
    "wrong number of active joints": (
        "active: [q1, q12, q22, q4]",
        "active: [q1, q12, q22]",
        "active",
        "name 4",
    ),
    "undetermined": (
        "active: [q1, q12, q22, q4]",
        "active: [q1, q12, q22, q2]",
        "active",
        "do not determine",
    ),
    "wrong joint type": (
        "q1:  {type: revolute",
        "q1:  {type: spherical",
        "joints.q1.type",
        "expected one of revolute",
    ),
    "wrong letter": ("type: A, base: l1", "type: B, base: l1", "loops.theta_1.k2", "Type B"),
    "unknown mode": (
        "assembly: counterclockwise}\n  theta_2",
        "assembly: up}\n  theta_2",
        "assembly",
        "is 'up'",
    ),
    "not a parallelogram": (
        "pin: {l31: [L2, 0, 0]",
        "pin: {l31: [L2 + 0.01, 0, 0]",
        "loops.theta_3.assembly",
        "0.71 m",
    ),
    "given twice": ("  q2:  {type", "  q1:  {type", "joints.q1", "given twice"),
    "does not close": (
        "reference: {q1: 0, q12: 0.1",
        "reference: {q1: 0, q12: 0.9",
        "loops.theta_1",
        "does not close",
    ),
    "reference of nobody": (
        "reference: {q1: 0",
        "reference: {q9: 0",
        "reference.q9",
        "no joint 'q9'",
    ),
    "skew loop": (
        "q21: {type: revolute, parent: l2, child: l21, origin: {xyz: [c2, 0, 0]}, axis: z}",
        (
            "q21: {type: revolute, parent: l2, child: l21, origin: {xyz: [c2, 0, 0]}, axis: [0,"
            " 0.1, 1]}"
        ),
        "loops.theta_2",
        (
            "'q21' about [0, 0.0995, 0.995] and 'q3' about [0, 0, 1]; mend the rpy of one's origin,"
            " or its axis"
        ),
    ),
    "axis without length": (
        "child: l1, axis: z",
        "child: l1, axis: [0, 0, 0]",
        "joints.q1.axis",
        "no length",
    ),
    "limits in the wrong order": (
        "child: l1, axis: z",
        "child: l1, axis: z, limits: [1, -1]",
        "joints.q1.limits",
        "not below",
    ),
    "not YAML": ("links: ", "links: [", "", "not valid YAML"),
    "bad name": ("name: forging_chu2020", "name: forging robot", "name", "not a valid name"),
    "weight is mass": ("l2:  {mass:", "l2:  {weight:", "links.l2.weight", "did you mean 'mass'"),
    "actuated is active": ("active: [q1,", "actuated: [q1,", "actuated", "did you mean 'active'"),
    "a closure among the loops": (
        "type: A, base: l1",
        "kind: planar, base: l1",
        "loops.theta_1.kind",
        "'closures'",
    ),
    "no sign before pi": ("L1: 0.7", "L1: 0.7pi", "parameters.L1", "did you mean '0.7*pi'"),
    "gravity as a number": (
        "gravity: [0, 0, -9.81]",
        "gravity: 9.81",
        "gravity",
        "a list; as in gravity: [0, 0, -9.81]",
    ),
    "end effector as a name": (
        "end_effector: {link: l4",
        "end_effector: l4 #",
        "end_effector",
        "is 'l4'; expected a mapping; as in end_effector: {link: l4}",
    ),
    "com as an expression": (
        "com: [L11/2, 0, 0]",
        "com: L11/2",
        "links.l11.com",
        "is 'L11/2'; expected a list; as in com: [L11/2, 0, 0]",
    ),
    "place on a link as a number": (
        "pin: {l31: [L2, 0, 0]",
        "pin: {l31: 0.71",
        "loops.theta_3.pin.l31",
        "is 0.71; expected a list; as in l31: [0.71, 0, 0]",
    ),
    "other format": ("format: 1", "format: 2", "format", "expected 1"),
}


@pytest.mark.parametrize(("old", "new", "key", "words"), CASES.values(), ids=CASES.keys())
def test_message_names_file_line_key_and_expectation(
    tmp_path: Path, old: str, new: str, key: str, words: str
) -> None:
    assert old in GOOD
    with pytest.raises(DescriptionError) as caught:
        load_text(tmp_path, GOOD.replace(old, new, 1))
    error = caught.value
    assert words in str(error)
    assert str(tmp_path / "robot.yaml") in str(error)
    assert key in error.key
    assert error.line is not None
    if "\n" not in old and key and new in GOOD.replace(old, new, 1):
        changed = GOOD.replace(old, new, 1)[: GOOD.index(old) + len(new)].count("\n") + 1
        same_entry = (
            key.split(".", maxsplit=1)[0]
            in ("links", "joints", "gravity", "parameters", "name", "format")
            and key != "joints.q"
        )
        assert not same_entry or error.line == changed


CLOSING = {"{": "}", "[": "]"}
# what is changed, the bracket that stays open, and the lines after it in which reading ends
OPEN = {
    "brace": (
        "inertia: {rod: {axis: z, length: b1}}}",
        "inertia: {rod: {axis: z, length: b1}}",
        "{mass: 81.3",
        1,
    ),
    "inner brace": (
        "inertia: {rod: {axis: z, length: b1}}}",
        "inertia: {rod: {axis: z, length: b1",
        "{axis: z",
        1,
    ),
    "bracket": ("gravity: [0, 0, -9.81]", "gravity: [0, 0, -9.81", "[0, 0, -9.81 ", 2),
    "bracket in a brace": ("com: [L11/2, 0, 0]", "com: [L11/2, 0, 0", "[L11/2, 0, 0", 0),
}


@pytest.mark.parametrize(("old", "new", "opened", "after"), OPEN.values(), ids=OPEN.keys())
def test_an_open_bracket_is_told_where_it_stands(
    tmp_path: Path, old: str, new: str, opened: str, after: int
) -> None:
    text = GOOD.replace(old, new, 1)
    before = text[: text.index(opened)]
    line, column = before.count("\n") + 1, len(before) - before.rfind("\n")
    with pytest.raises(DescriptionError) as caught:
        load_text(tmp_path, text)
    assert caught.value.line == line
    assert f"'{opened[0]}' in column {column} is still open in line {line + after}, column " in str(
        caught.value
    )
    place = re.search(r"open in line (\d+), column (\d+)", str(caught.value))
    assert place is not None
    row, at = text.splitlines()[int(place[1]) - 1], int(place[2]) - 1
    assert row[at] in "]}:" or row[:at].strip() == ""  # what stands in the way begins there
    end = f"a '{CLOSING[opened[0]]}' is missing, probably at the end of line "
    assert (end in str(caught.value)) == (
        after > 0
    )  # on one line it is a comma, or a bracket of the other kind
    assert "<scalar>" not in str(caught.value)


def test_a_missing_brace_is_told_at_the_end_of_its_line(tmp_path: Path) -> None:
    """Where the mapping goes over lines, at the last of them that says something."""
    text = "format: 1\nlinks:\n  arm: {mass: 2,\n    com: [0, 0, 1]\n\n  # next\n  rod: {mass: 1}\n"
    with pytest.raises(DescriptionError, match=r"a '}' is missing, probably at the end of line 4$"):
        load_text(tmp_path, text)


def test_an_open_quote_is_told_where_it_stands(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match="in column 7 is still open in line") as caught:
        load_text(tmp_path, "format: 1\nname: 'crane\nlinks: {}\n")
    assert caught.value.line == 2


def test_unreadable_files(tmp_path: Path) -> None:
    with pytest.raises(
        NoDescriptionError, match="there is no such file or folder; expected a robot description"
    ):
        load(tmp_path / "none.yaml")
    (tmp_path / "latin.yaml").write_bytes(b"name: \xe9")
    with pytest.raises(DescriptionError, match="not UTF-8"):
        load(tmp_path / "latin.yaml")
    with pytest.raises(
        NoDescriptionError, match="seems to be an empty file; expected a robot description"
    ):
        load_text(tmp_path, "")


def test_alias_bomb_is_refused(tmp_path: Path) -> None:
    levels = "".join(f"b{k}: &b{k} [{', '.join([f'*b{k - 1}'] * 10)}]\n" for k in range(1, 8))
    with pytest.raises(DescriptionError, match="too many entries"):
        load_text(tmp_path, "b0: &b0 [1, 1]\n" + levels)


def test_yaml_objects_are_refused(tmp_path: Path) -> None:
    with pytest.raises(DescriptionError, match="not allowed"):
        load_text(tmp_path, "name: !!python/object/apply:os.getcwd []\n")


def test_unknown_robot_names_the_nearest() -> None:
    with pytest.raises(InputError, match="did you mean 'forging_chu2020'"):
        load("forging_chu2002")
