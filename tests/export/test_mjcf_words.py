"""No word of MJCF is passed over in silence: it changes the robot, or is noted, or is refused."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
import pytest

from hybrid_dynamics_core import DescriptionError
from hybrid_dynamics_core.description.model import RobotDescription
from hybrid_dynamics_core.formats.mjcf.vocabulary import DRIVES
from hybrid_dynamics_core.formats.reader import read_description
from tests.sampling import swept

mujoco = pytest.importorskip("mujoco")

# One of each element that is looked into; what stands in it is changed word by word.
MODEL = """<mujoco model="all">
  <compiler angle="radian" autolimits="true"/>
  <option gravity="0 0 -9"><flag contact="disable"/></option>
  <default><joint/><geom/><site/><equality/><general/></default>
  <worldbody>
    <site name="mark"/>
    <body name="one">
      <inertial pos="0.1 0 0" mass="1" diaginertia="0.01 0.02 0.02" quat="1 0 0 0.5"/>
      <joint name="a" range="-1 1" stiffness="2"/>
      <frame><body name="two"><joint name="b"/><site name="tip"/><geom size="0.1"/></body></frame>
    </body>
    <body name="three"><freejoint name="f"/><geom size="0.2" mass="2" pos="1 0 0"/></body>
  </worldbody>
  <tendon>
    <fixed name="t"><joint joint="a" coef="1"/></fixed>
    <spatial name="s"><site site="mark"/><site site="tip"/></spatial>
  </tendon>
  <equality>
    <connect body1="two" anchor="1 0 0"/>
    <weld body1="two" body2="three"/>
    <joint joint1="a" joint2="b"/>
  </equality>
  <actuator>
    <general joint="a"/><motor joint="a"/><position joint="a"/><velocity joint="a"/>
    <intvelocity joint="a"/><pid joint="a"/><damper joint="a" ctrlrange="0 1"/><cylinder joint="a"/>
    <muscle joint="a"/>
  </actuator>
  <keyframe><key qpos="0 0 0 0 0 1 0 0 0"/></keyframe>
  <custom><text name="t" data="x"/></custom>
</mujoco>
"""
# What says nothing more than is said anyway: inertias are balanced, the class is main.
WITHOUT_MEANING = {("compiler", "balanceinertia"), ("default", "class")}
# Names that nothing but other words refers to:
NAMES = {"frame", "key", "text", "freejoint", "fixed", "spatial", "joint", *DRIVES.split()}
# Of a value that no word has by itself; some words take certain values only.
VALUE = "0.37"
VALUES = {
    "alignfree": "true",
    "size": "0.1 0.2",
    "inertiagrouprange": "4 5",
    "boundmass": "3",
    "boundinertia": "3",
    "balanceinertia": "true",
    "springref": "0.37",
}


def schema() -> Iterator[tuple[tuple[str, ...], list[str]]]:
    """Every element of MuJoCo's own schema, by the tags around it, with its attributes."""
    path: list[str] = []
    attributes: list[str] = []
    for line in mujoco.mj_printSchema(False, False).splitlines():
        opening = re.match(r"( *)(\S+) \(.\) *(.*)", line)
        if opening is None:
            attributes.extend(line.split())
            continue
        if path:
            yield tuple(path), attributes
        depth = len(opening[1]) // 3
        path = [*path[:depth], opening[2].removeprefix("(world)")]
        attributes = opening[3].split()
    yield tuple(path), attributes


def words() -> list[tuple[str, str, str]]:
    """Attributes of all elements that stand in the model, with the element around each."""
    root = ElementTree.fromstring(MODEL)
    pairs = {(parent.tag, child.tag) for parent in root.iter() for child in parent}
    pairs.add(("body", "body"))
    cases = []
    for path, attributes in schema():
        parent, tag = ("", *path)[-2:]
        if (parent, tag) in pairs or (parent, tag) == ("mujoco", "body"):
            cases.extend((parent, tag, name) for name in attributes)
    return cases


def said(description: RobotDescription) -> list:
    """Everything that a description says of the robot but its notes."""
    parts = [vars(description)[name] for name in ("links", "joints", "frames", "effects", "mimics")]
    values: list = [description.name, description.gravity, description.active]
    values += [dict(description.reference), [list(part) for part in parts]]
    for entry in [entry for part in parts for entry in part.values()] + [*description.closures]:
        values.append(sorted(vars(entry).items()))
    return values


def same(one, other) -> bool:
    if isinstance(one, np.ndarray):
        return np.array_equal(one, other)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    return bool(one == other)


def place(root: Element, parent: str, tag: str) -> Element:
    """The first element of a tag in another one."""
    if tag == "body":
        return root.find(".//body")
    for element in root.iter(parent):
        if element.find(tag) is not None:
            return element.find(tag)
    raise LookupError(f"{parent}/{tag}")


@pytest.mark.parametrize("step", swept([4, 1], [4]))
def test_no_word_of_mujocos_schema_is_passed_over_in_silence(tmp_path: Path, step: int) -> None:
    """Of so many words one."""
    file = tmp_path / "model.xml"
    file.write_text(MODEL, encoding="utf-8")
    plain = read_description(file)
    cases = words()
    assert len(cases) > 250
    silent = []
    for parent, tag, name in cases[::step]:
        root = ElementTree.fromstring(MODEL)
        place(root, parent, tag).set(name, VALUES.get(name, VALUE))
        file.write_text(ElementTree.tostring(root, encoding="unicode"), encoding="utf-8")
        try:
            description = read_description(file)
        except DescriptionError:
            continue
        shown = rf"\b{name}\b|<{tag}>|<{parent}>"
        mentioned = any(re.search(shown, note) for note in description.notes)
        changed = not same(said(description), said(plain)) or description.notes != plain.notes
        is_name = name == "name" and tag in NAMES
        if not (mentioned or changed or is_name or (tag, name) in WITHOUT_MEANING):
            silent.append(f"{parent}/{tag} {name}")
    assert silent == [], "; ".join(silent)
