"""No word of a URDF is passed over: each is read, noted with its line, or refused.

The table of docs/exchange.md says which; here it is walked.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import DescriptionError, Robot
from hybrid_dynamics_core.description.model import RobotDescription
from hybrid_dynamics_core.formats import read_urdf
from hybrid_dynamics_core.formats.urdf.words import OMITTED, REFUSED, URDF
from tests.docs.blocks import ROOT
from tests.sampling import examples

# Every word that is read, once; two loops, so that independent joints have a meaning.
ROBOT = """\
<robot name="words" version="1.1">
<link name="base"/>
<link name="a"><inertial><origin xyz="0.1 0 0" rpy="0.1 0 0"/><mass value="1"/>
<inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0.001" ixz="0.002" iyz="0.003"/></inertial></link>
<link name="b"><inertial><mass value="1"/>
<inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="c"/><link name="d"/><link name="plate"/>
<joint name="j" type="revolute" independent="true"><parent link="base"/><child link="a"/>
<origin xyz="0 0 0.1" rpy="0 0 0.2"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" effort="5" velocity="6"/><dynamics damping="0.3" friction="0.4"/>
</joint>
<joint name="k" type="continuous" independent="false"><parent link="a"/><child link="b"/>
<origin xyz="0.3 0 0" quat_xyzw="0 0 0.6 0.8"/><axis xyz="0 0 1"/></joint>
<joint name="m" type="continuous" independent="false"><parent link="base"/><child link="c"/>
<axis xyz="0 0 1"/><mimic joint="j" multiplier="2" offset="0.1"/></joint>
<joint name="n" type="continuous" independent="false"><parent link="base"/><child link="d"/>
<axis xyz="0 0 1"/></joint>
<joint name="bolt" type="fixed"><parent link="b"/><child link="plate"/></joint>
<coupling name="gear"><predecessor link="a"/><successor link="d"/><ratio value="3"/></coupling>
</robot>
"""
LOOP = """\
<robot name="loop">
<link name="base"/><link name="p"/><link name="q"/><link name="r"/>
<joint name="jp" type="continuous" independent="true"><parent link="base"/><child link="p"/>
<axis xyz="0 0 1"/></joint>
<joint name="jq" type="continuous" independent="false"><parent link="p"/><child link="q"/>
<origin xyz="0.2 0 0" rpy="0 0 1"/><axis xyz="0 0 1"/></joint>
<joint name="jr" type="continuous" independent="false"><parent link="base"/><child link="r"/>
<origin xyz="0.4 0 0" rpy="0 0 2"/><axis xyz="0 0 1"/></joint>
TIE
</robot>
"""
# The ends of `q` and `r` meet with all joints at zero.
MEETING = np.array([0.2 + 0.3 * np.cos(1) - 0.4, 0.3 * np.sin(1)])
TURN = np.array([[np.cos(2), np.sin(2)], [-np.sin(2), np.cos(2)]])
END = " ".join(map(repr, [*(TURN @ MEETING).tolist(), 0.0]))
TIES = {
    "loop": '<loop name="t" type="revolute"><predecessor link="q"><origin xyz="0.3 0 0"/>'
    '</predecessor><successor link="r"><origin xyz="END"/></successor>'
    '<axis xyz="0 0 1"/></loop>',
    "constraint": '<constraint name="t" type="revolute"><parent link="q"/>'
    '<parent_origin xyz="0.3 0 0"/><parent_axis xyz="0 0 1"/><child link="r"/>'
    '<child_origin xyz="END"/><child_axis xyz="0 0 1"/></constraint>',
    "gazebo": '<gazebo><joint name="t" type="revolute"><parent>q</parent><child>r</child>'
    "<pose>END 0 0 0</pose><axis><xyz>0 0 1</xyz></axis></joint></gazebo>",
}
TIES = {name: tie.replace("END", END) for name, tie in TIES.items()}


def read(folder: Path, text: str) -> RobotDescription:
    file = folder / "words.urdf"
    file.write_text(text, encoding="utf-8")
    return read_urdf(file)


def verdict(folder: Path, text: str, line: int) -> str:
    """What becomes of a file with one more word in a line."""
    try:
        notes = read(folder, text).notes
    except DescriptionError as error:
        return "refused" if abs((error.line or 0) - line) <= 1 else f"refused elsewhere: {error}"
    before = read(folder, ROBOT).notes
    new = [note for note in notes if note not in before]
    at_line = [note for note in new if f":{line}:" in note or f"(line {line})" in note]
    return "noted" if at_line else "silent"


def test_nothing_of_the_sample_is_noted(tmp_path: Path) -> None:
    robot = read(tmp_path, ROBOT)
    (note,) = robot.notes
    assert "no end effector is given" in note
    for name, tie in TIES.items():
        notes = read(tmp_path, LOOP.replace("TIE", tie)).notes
        assert not any("left out" in note for note in notes), name


# -- the table of the page


def rows_of_the_page() -> list[tuple[str, str]]:
    """Words, as `<limit effort>` or `<link><visual>`, and what becomes of them."""
    page = (ROOT / "docs" / "exchange.md").read_text(encoding="utf-8")
    table = page.partition("### URDF, word by word")[2].partition("\n### ")[0]
    rows = []
    for line in table.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 2 and cells[1] in ("read", "noted", "refused"):
            rows += [(word, cells[1]) for word in re.findall(r"`([^`]+)`", cells[0])]
    return rows


def sample(word: str) -> tuple[str, int]:
    """The sample robot with a word in it, and the word's line."""
    lines = ROBOT.splitlines(keepends=True)
    of_attribute = re.fullmatch(r"<([a-z]+) ([a-z_]+)>", word)
    if of_attribute:
        tag, attribute = of_attribute.groups()
        opened = f"<{tag} "
        k = next(k for k, line in enumerate(lines) if opened in line)
        lines[k] = lines[k].replace(opened, f'{opened}{attribute}="1" ', 1)
        return "".join(lines), k + 1
    parent, tag = re.fullmatch(r"<([a-z ]+)><([a-z_:]+)>", word).groups()
    kind = "fixed" if parent == "fixed joint" else ""
    parent = parent.removeprefix("fixed ")
    k = next(k for k, line in enumerate(lines) if f"<{parent} " in line and kind in line)
    end = lines[k].index(">", lines[k].index(f"<{parent} ")) + 1
    head, tail = lines[k][:end], lines[k][end:]
    if head.endswith("/>"):
        head = f"{head[:-2]}>"
        tail = f"</{parent}>{tail}"
    lines[k] = f"{head}<{tag}/>{tail}"
    return "".join(lines), k + 1


ROWS = rows_of_the_page()
OTHER_ROOMS = re.compile("gazebo|transmission|ros2_control")  # test_urdf_gazebo.py
SHORT_ROWS = [row for row in ROWS if row[1] != "read" and not OTHER_ROOMS.search(row[0])]


@pytest.mark.parametrize(("word", "said"), SHORT_ROWS)
def test_the_table_says_what_becomes_of_a_word(word: str, said: str, tmp_path: Path) -> None:
    text, line = sample(word)
    assert verdict(tmp_path, text, line) == said


def test_the_table_has_every_word_that_the_reader_knows() -> None:
    known: set[str] = set()
    for kind, words in URDF.items():
        known |= {f"<{kind} {name}>" for name in words.attributes}
        known |= {f"<{kind}><{tag}>" for tag in words.elements or ()}
    left_out: set[str] = set()
    for kind, words in OMITTED.items():
        left_out |= {f"<{kind} {name}>" for name in words.attributes}
        left_out |= {f"<{kind}><{tag}>" for tag in words.elements or ()}
    assert {word for word, said in ROWS if said == "noted" and "gazebo" not in word} >= left_out
    refused = {word for word, said in ROWS if said == "refused"}
    assert {name for name in REFUSED if not any(f"{name}>" in word for word in refused)} == set()
    assert {word for word, said in ROWS if said == "read"} >= known


# -- laws


WORDS = st.from_regex(r"[a-z]{4}[a-z_]{0,12}", fullmatch=True)


@examples(60)
@given(word=WORDS, place=st.integers(0, 10_000), is_attribute=st.booleans())
def test_a_word_put_in_anywhere_is_noted_or_refused(
    word: str, place: int, is_attribute: bool, tmp_path_factory: pytest.TempPathFactory
) -> None:
    opened = list(re.finditer(r"<[a-z]+", ROBOT))
    match = opened[place % len(opened)]
    line = ROBOT[: match.start()].count("\n") + 1
    if is_attribute:
        text = f'{ROBOT[: match.end()]} {word}="1"{ROBOT[match.end() :]}'
    else:
        end = ROBOT.index(">", match.end())
        if ROBOT[end - 1] == "/":
            tag = match.group()[1:]
            text = f"{ROBOT[: end - 1]}><{word}/></{tag}>{ROBOT[end + 1 :]}"
        else:
            text = f"{ROBOT[: end + 1]}<{word}/>{ROBOT[end + 1 :]}"
    known = URDF.get(match.group()[1:])
    if known and word in {*known.attributes, *(known.elements or ())}:
        return
    assert verdict(tmp_path_factory.mktemp("words"), text, line) in ("noted", "refused")


# Names of couplings serve messages; a follower is not independent, whatever stands there.
WITHOUT_EFFECT = ('name="gear"', 'name="m" type="continuous" ', 'name="n" type="continuous" ')
ATTRIBUTES = [
    match
    for match in re.finditer(r'([a-z_]+)="([^"]*)"', ROBOT)
    if match.group() != WITHOUT_EFFECT[0] and not ROBOT[: match.start()].endswith(WITHOUT_EFFECT)
]


@pytest.mark.parametrize("k", range(len(ATTRIBUTES)))
def test_every_attribute_has_an_effect(k: int, tmp_path: Path) -> None:
    """What is read is used: with another value the robot is another one, or the file is wrong."""
    _, value = ATTRIBUTES[k].groups()
    start, end = ATTRIBUTES[k].span(2)
    first, *others = value.split()
    try:
        changed = " ".join([str(float(first) + 0.37), *others])
    except ValueError:
        changed = {"true": "false", "false": "true"}.get(value, f"{value}x")
    text = f"{ROBOT[:start]}{changed}{ROBOT[end:]}"
    try:
        robot = read(tmp_path, text)
    except DescriptionError:
        return
    with np.printoptions(threshold=10_000, precision=17):
        assert repr(robot) != repr(read(tmp_path, ROBOT))


@examples(40)
@given(
    word=st.sampled_from(["inertial", "origin", "limit", "dynamics", "axis", "mimic", "effort"]),
    place=st.integers(0, 100),
    letter=st.sampled_from("abcdxyz"),
)
def test_a_slip_of_one_letter_is_refused_with_what_was_meant(
    word: str, place: int, letter: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    k = place % len(word)
    for wrong in (word[:k] + word[k + 1 :], word[:k] + letter + word[k:]):
        if wrong == word:
            continue
        text = re.sub(rf"(</?|\s){word}(?=[ >=/])", rf"\1{wrong}", ROBOT)
        with pytest.raises(DescriptionError, match=rf"{wrong}>? is not known \(did you mean"):
            read(tmp_path_factory.mktemp("slip"), text)


@examples(30)
@given(
    xyzw=st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4).filter(
        lambda q: np.linalg.norm(q) > 0.1
    )
)
def test_a_quaternion_is_the_rotation_that_scipy_makes_of_it(
    xyzw: list[float], tmp_path_factory: pytest.TempPathFactory
) -> None:
    rotation = pytest.importorskip("scipy.spatial.transform").Rotation.from_quat(xyzw).as_matrix()
    numbers = " ".join(map(repr, xyzw))
    text = ROBOT.replace('quat_xyzw="0 0 0.6 0.8"', f'quat_xyzw="{numbers}"')
    robot = read(tmp_path_factory.mktemp("quat"), text)
    assert robot.joints["k"].rotation == pytest.approx(rotation, abs=1e-14)


def test_an_upright_axis_needs_no_effort(tmp_path: Path) -> None:
    text = """<robot name="r" version="1.2"><link name="base"/><link name="l"><inertial>
    <origin xyz="0.1 0 0"/><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01"/></inertial>
    </link><joint name="a" type="continuous"><parent link="base"/><child link="l"/>
    <origin quat_xyzw="0.70710678 0 0 0.70710678"/><axis xyz="0 1 0"/></joint></robot>"""
    machine = Robot(read(tmp_path, text))
    assert machine.inverse_dynamics(machine.close([0.3]), [0.0]) == pytest.approx([0.0], abs=1e-12)
    for wrong, words in (
        ('quat_xyzw="0 0 0 0"', "is zero, which is no rotation"),
        ('rpy="0 0 0" quat_xyzw="0 0 0 1"', "has rpy and quat_xyzw"),
        ('quat_wxyz="1 0 0 0"', "write it as quat_xyzw"),
    ):
        with pytest.raises(DescriptionError, match=words):
            read(tmp_path, text.replace('quat_xyzw="0.70710678 0 0 0.70710678"', wrong))


def test_a_second_element_is_refused(tmp_path: Path) -> None:
    text = ROBOT.replace("<mass value", '<mass value="2"/><mass value', 1)
    with pytest.raises(DescriptionError, match="has a second <mass>; leave one out"):
        read(tmp_path, text)


def test_a_base_needs_no_mass(tmp_path: Path) -> None:
    text = ROBOT.replace('<link name="base"/>', '<link name="base"><inertial/></link>')
    assert any(
        "<inertial> of the base has no <mass>" in note for note in read(tmp_path, text).notes
    )
    text = ROBOT.replace('<mass value="1"/>', "", 1)
    with pytest.raises(DescriptionError, match="<inertial> has no <mass>"):
        read(tmp_path, text)
