"""MJCF comes back as this library writes it; everything else is refused with its line."""

from __future__ import annotations

from pathlib import Path

import pytest

from hybrid_dynamics_core import DescriptionError, load

PENDULUM = """<mujoco model="pendulum">
  <compiler angle="radian"/>
  <option gravity="0 0 -3.7"/>
  <worldbody>
    <site name="mark" pos="1 2 3"/>
    <body name="bob" pos="0 0 1" quat="0.7071067811865476 0.7071067811865476 0 0">
      <inertial pos="0.5 0 0" mass="2" diaginertia="0.1 0.2 0.2"/>
      <joint name="q" type="hinge" axis="0 0 2" range="-1 2" limited="true" damping="0.3" armature="0.5"/>
      <geom type="sphere" size="0.1" mass="0"/>
      <body name="tip" pos="1 0 0"/>
    </body>
  </worldbody>
  <actuator><motor name="q" joint="q"/></actuator>
</mujoco>
"""


def read(folder: Path, text: str) -> object:
    path = folder / "model.xml"
    path.write_text(text, encoding="utf-8")
    return load(path)


def test_its_own_words_are_enough(tmp_path: Path) -> None:
    machine = read(tmp_path, PENDULUM)
    assert (machine.name, machine.active, machine.description.base) == ("pendulum", ("q",), "world")
    assert machine.limits[0] == pytest.approx([-1, 2])
    assert machine.description.gravity == pytest.approx([0, 0, -3.7])
    state = machine.close([0.4])
    held = machine.inverse_dynamics(state, [0.0])
    assert held == pytest.approx([2 * 3.7 * 0.5 * 0.9210609940028851])  # m g r cos(0.4): the hinge lies level
    pushed = machine.inverse_dynamics(state, [1.0])
    assert pushed - held == pytest.approx([0.2 + 2 * 0.25 + 0.5])  # the bob about its hinge, and the rotor
    assert machine.forward_kinematics(state, "tip").position == pytest.approx([0.921061, 0, 1.389418], abs=1e-6)
    assert machine.forward_kinematics(state, "mark").position == pytest.approx([1, 2, 3])


WRONG = {
    "degrees": ('angle="radian"', 'angle="degree"', "counts angles in degrees", 1),
    "defaults": ("<worldbody>", "<default/><worldbody>", "<default> is not covered", 4),
    "free": ('<joint name="q" type="hinge"', '<joint name="q" type="free"', "is 'free'; expected hinge or slide", 8),
    "mass of shapes": ('size="0.1" mass="0"', 'size="0.1"', "a <geom> makes up mass", 9),
    "angles": (
        '<body name="tip" pos="1 0 0"/>',
        '<body name="tip" euler="1 0 0"/>',
        "is turned by euler; expected quat",
        10,
    ),
    "offset": ('damping="0.3"', 'ref="0.3"', "ref is not covered", 8),
    "two joints": ("<geom ", '<joint name="p"/><geom ', "body 'bob' has 2 joints", 9),
    "position drive": ("<motor ", "<position ", "<position> is not covered; expected <motor joint=...>", 13),
    "tied to nothing": (
        "  <actuator>",
        '  <equality><connect name="c" site1="mark" site2="mork"/></equality>\n  <actuator>',
        "ties the site 'mork', which is not there",
        13,
    ),
    "tied to itself": (
        "  <actuator>",
        '  <equality><connect name="c" site1="mark" site2="mark"/></equality>\n  <actuator>',
        "ties two sites of one body",
        13,
    ),
    "number": ('mass="2"', 'mass="two"', 'mass="two"; expected a number', 7),
}


@pytest.mark.parametrize(("old", "new", "words", "line"), WRONG.values(), ids=WRONG.keys())
def test_what_is_not_covered_is_told(old: str, new: str, words: str, line: int, tmp_path: Path) -> None:
    assert old in PENDULUM
    with pytest.raises(DescriptionError) as caught:
        read(tmp_path, PENDULUM.replace(old, new, 1))
    assert words in str(caught.value)
    assert caught.value.line == line
