"""An exported robot comes back the same: names, limits, states, minimal form, assembly modes."""

from __future__ import annotations

import pickle
import re
import textwrap
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hybrid_dynamics_core import DescriptionError, Payload, Robot, load, shipped_robots
from hybrid_dynamics_core.export import to_gepetto, to_mjcf, to_sdf, to_urdf_plus
from hybrid_dynamics_core.formats.reader import parse_description
from tests.export.bars import LIMITED, PAIR
from tests.generated.robots import shuffled
from tests.robots import random_states, robot
from tests.sampling import examples, swept
from tests.spinning import Spinning, spinning

FORMS = ["urdf+", "robot.yaml", "sdf", "mjcf"]
# relative: poses become angles or quaternions of 17 digits and back, in SDFormat through the whole
# tree
NEAR = 1e-11


def write(machine: Robot, form: str, folder: Path) -> Path:
    """The file of a robot in a format, under a name that does not tell the format."""
    file = folder / ("robot.yaml" if form == "robot.yaml" else "robot.xml")
    if form == "robot.yaml":
        pair = to_gepetto(machine.description)
        file.with_suffix(".urdf").write_text(pair.urdf, encoding="utf-8")
        text = pair.yaml
    else:
        made = {"urdf+": lambda: to_urdf_plus(machine.description), "sdf": lambda: to_sdf(machine)}
        text = made.get(form, lambda: to_mjcf(machine))()
    file.write_text(text, encoding="utf-8")
    return file


def assert_the_same(machine: Robot, back: Robot) -> None:
    """Everything that a description says."""
    one, other = machine.description, back.description
    assert (other.name, other.base, other.active, other.active_set) == (
        one.name,
        one.base,
        one.active,
        one.active_set,
    )
    assert set(other.joints) == set(one.joints)
    assert set(one.frames) <= set(other.frames)
    for name, joint in one.joints.items():
        assert (other.joints[name].parent, other.joints[name].child) == (joint.parent, joint.child)
        assert other.joints[name].limits == pytest.approx(
            joint.limits, abs=1e-14
        )  # of SDFormat from the reference
        assert other.joints[name].effort_limit == joint.effort_limit
        assert other.joints[name].velocity_limit == joint.velocity_limit
        assert other.joints[name].power_limit == joint.power_limit
    assert [(c.name, c.kind, c.assembly) for c in sorted(other.closures, key=lambda c: c.name)] == [
        (c.name, c.kind, c.assembly) for c in sorted(one.closures, key=lambda c: c.name)
    ]
    assert {name: vars(loop) for name, loop in other.loops.items()} == {
        n: vars(loop) for n, loop in one.loops.items()
    }
    assert other.reference == one.reference
    np.testing.assert_array_equal(other.gravity, one.gravity)


def assert_they_move_alike(machine: Robot, back: Robot, states: tuple) -> None:
    """On random closed states: coordinates, minimal form, efforts, end effector and modes."""
    order = [back.coordinates.index(name) for name in machine.coordinates]
    for state in states:
        restored = back.close(state.u, state.du)
        assert restored.s[order] == pytest.approx(state.s, abs=NEAR)
        assert restored.ds[order] == pytest.approx(
            state.ds, rel=1e-9, abs=1e-9
        )  # over the distance to a singularity
        assert dict(restored.branch) == dict(state.branch)
        for one, other in zip(
            machine.minimal_form(state), back.minimal_form(restored), strict=True
        ):
            assert other == pytest.approx(
                one, rel=1e-8, abs=1e-8 * max(1.0, float(np.abs(one).max()))
            )
        pose = machine.forward_kinematics(state)
        assert back.forward_kinematics(restored).position == pytest.approx(pose.position, abs=1e-9)
        assert back.forward_kinematics(restored).rotation == pytest.approx(pose.rotation, abs=1e-9)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", swept(shipped_robots()))
def test_a_shipped_robot_comes_back(name: str, form: str, tmp_path: Path) -> None:
    machine = load(name)
    back = load(write(machine, form, tmp_path))
    assert_the_same(machine, back)
    assert_they_move_alike(machine, back, random_states(name, 2) if name != "staicu2015" else ())


SPATIAL = """
    format: 1
    name: everything
    source: a small file with one of each
    gravity: [0.3, -0.2, -3.7]
    base: floor
    links:
      floor: {mass: 7}
      crank: {mass: 2, com: [0.1, 0, 0], inertia: {box: {size: [0.2, 0.05, 0.04]}}}
      bar: {mass: 1, com: [0.2, 0.01, 0], inertia: {box: {size: [0.4, 0.03, 0.02]}}}
      rocker: {mass: 1.5, com: [0.15, 0, 0.01], inertia: {box: {size: [0.3, 0.03, 0.02]}}}
      carrier: {}
      tip: {mass: 0.4, com: [0, 0, 0.05], inertia: {sphere: {radius: 0.03}}}
    joints:
      a: {type: revolute, parent: floor, child: crank, axis: z,
          origin: {xyz: [0, 0, 0.3], rpy: [0.3, -0.4, 0.2]},
          friction: {viscous: 0.4, coulomb: 0.2, smoothing: 0.01},
          drive: {rotor_inertia: 0.001, gear_ratio: 20}, limits: [-1, .inf], effort_limit: 61.5}
      b: {type: revolute, parent: crank, child: bar, origin: {xyz: [0.2, 0, 0]}, axis: z,
          velocity_limit: 12.25, power_limit: 150.5}
      c: {type: revolute, parent: floor, child: rocker,
          origin: [{xyz: [0, 0, 0.3], rpy: [0.3, -0.4, 0.2]}, {xyz: [0.35, 0, 0]}], axis: z,
          spring: {stiffness: 3, rest: 0.4, preload: 0.7}}
      d: {type: revolute, parent: rocker, child: carrier, axis: [0, 0.6, 0.8],
          origin: {rpy: [0, pi/2, 0]}}
      e: {type: prismatic, parent: carrier, child: tip, axis: x,
          mimic: {joint: d, multiplier: 0.1, offset: 0.02}}
    closures:
      hinge: {kind: axis, assembly: MODE,
              between: {bar: {xyz: [0.4, 0, 0.02]}, rocker: {xyz: [0.3, 0, 0.02]}}}
    frames:
      mark: {link: tip, xyz: [0.1, 0.2, 0.3], rpy: [0.1, 0.2, 0.3]}
    payloads:
      load: {on: mark, mass: 3, com: [0, 0, 0.1], inertia: {sphere: {radius: 0.05}}}
    active: [d, a]
    end_effector: {link: mark, xyz: [0, 0, 0.02], rpy: [0.5, 0, 0]}
    reference: {d: 0.1, a: 0.8, b: -0.5, c: 1.2}
"""


@cache
def everything() -> Robot:
    """A robot with a tied axis, a follower, a payload, springs and limits on one side."""
    return Robot(parse_description(textwrap.dedent(SPATIAL.replace("MODE", "counterclockwise"))))


@pytest.mark.parametrize("form", FORMS)
def test_nothing_that_a_file_says_is_lost(form: str, tmp_path: Path) -> None:
    machine = everything()
    back = load(write(machine, form, tmp_path))
    assert_the_same(machine, back)
    states = [machine.close([0.1, 0.8], [0.3, -0.5]), machine.close([-0.4, 1.1], [1.0, 0.2])]
    assert_they_move_alike(machine, back, tuple(states))
    for state in states:
        expected = machine.inverse_dynamics(state, [0.7, -0.3])  # with all loads of the file
        restored = back.inverse_dynamics(back.close(state.u, state.du), [0.7, -0.3])
        assert restored == pytest.approx(expected, rel=1e-8, abs=1e-8)
    on, payload = back.description.payloads["load"]
    assert (on, payload.mass) == ("mark", 3)
    assert isinstance(payload, Payload)
    assert back.description.source == machine.description.source


@pytest.mark.parametrize("form", FORMS)
def test_a_second_round_changes_nothing(form: str, tmp_path: Path) -> None:
    machine = everything()
    once = load(write(machine, form, tmp_path))
    assert_the_same(once, load(write(once, form, tmp_path)))


@pytest.mark.parametrize("form", FORMS)
def test_files_without_what_their_format_cannot_say_are_read_too(form: str, tmp_path: Path) -> None:
    """Only words of the format: the same mechanism, with independent coordinates in its order."""
    machine = robot("five_bar")
    file = write(machine, form, tmp_path)
    text = file.read_text(encoding="utf-8")
    cut = {
        "urdf+": "<hybrid_dynamics>",
        "sdf": "<hybrid_dynamics:hybrid_dynamics>",
        "mjcf": "<custom>",
    }
    if form == "robot.yaml":
        text = text[: text.index("hybrid_dynamics:\n")]
    else:
        end = cut[form].replace("<", "</")
        text = text[: text.rindex(cut[form])] + text[text.index(end) + len(end) :]
    file.write_text(text, encoding="utf-8")
    back = load(file)
    assert len(back.active) == 3
    state = back.close(back.reference)
    assert state.residual < 1e-12
    assert set(back.coordinates) == set(machine.coordinates)


@pytest.mark.parametrize("form", FORMS)
def test_a_robot_that_closes_beyond_a_limit_only_comes_back(form: str, tmp_path: Path) -> None:
    """Its reference was looked for from its motors: what is read says so again."""
    (tmp_path / "first.urdf").write_text(LIMITED, encoding="utf-8")
    (tmp_path / "first.yaml").write_text(PAIR, encoding="utf-8")
    machine = load(tmp_path / "first.yaml")
    folder = tmp_path / "out"
    folder.mkdir()
    back = load(write(machine, form, folder))
    assert back.close(back.reference).s == pytest.approx(
        machine.close(machine.reference).s, abs=NEAR
    )
    assert any("hinge: the loops close at" in note for note in back.description.notes)


WRONG = {
    "unknown key": ("active_set: exact", "activ: 3", "unknown key"),
    "no such joint": ("active:\n- q_L", "active:\n- q_X", "there is no joint 'q_X'"),
    "no such closure": (
        "tip: {kind: planar}",
        "top: {kind: planar}",
        "there is no closure 'top' (did you mean 'tip'?)",
    ),
}


@pytest.mark.parametrize(("old", "new", "words"), WRONG.values(), ids=WRONG.keys())
def test_wrong_entries_are_reported_with_their_line(
    old: str, new: str, words: str, tmp_path: Path
) -> None:
    file = write(robot("five_bar"), "urdf+", tmp_path)
    text = file.read_text(encoding="utf-8").replace(
        "active: [q_L, q_R, q_T]", "active:\n- q_L\n- q_R\n- q_T"
    )
    assert old in text
    file.write_text(text.replace(old, new), encoding="utf-8")
    line = (
        file.read_text(encoding="utf-8").splitlines().index(new.splitlines()[-1]) + 1
        if new[:3] != "top"
        else None
    )
    with pytest.raises(DescriptionError) as caught:
        load(file)
    assert words in str(caught.value)
    assert line is None or caught.value.line == line


CART = """
format: 1
name: cartpole
active_set: motors
links:
  base: {}
  cart: {mass: 1}
  pole: {mass: 0.2, com: [0, 0, 0.5], inertia: {rod: {axis: z, length: 1}}}
joints:
  x: {type: prismatic, parent: base, child: cart, axis: x, limits: [-1, 1]}
  th: {type: revolute, parent: cart, child: pole, axis: y}
active: [x]
end_effector: {link: pole, xyz: [0, 0, 1]}
"""


def assert_idle_as_before(machine: Robot, form: str, folder: Path) -> None:
    """No motor is written for idle coordinates, and they come back idle."""
    file = write(machine, form, folder)
    back = load(file)
    assert (back.active, back.idle, back.drives) == (machine.active, machine.idle, machine.drives)
    assert set(back.drives).isdisjoint(back.idle)
    text = file.read_text(encoding="utf-8")
    motors = re.findall(r'<motor [^>]*joint="(\w+)"', text)
    motors += re.findall(r'<joint name="(\w+)"[^>]*independent="true"', text)
    for listed in re.findall(r"name_mot: \[(.*)\]", text):
        motors += listed.split(", ")
    assert set(motors) == (set() if form == "sdf" else set(machine.drives))


@pytest.mark.parametrize("form", FORMS)
def test_an_idle_pole_comes_back_idle(form: str, tmp_path: Path) -> None:
    assert_idle_as_before(Robot(parse_description(CART)), form, tmp_path)


@pytest.mark.parametrize("form", FORMS)
@examples(12)
@given(spinning(), st.integers(0, 100))
def test_idle_coordinates_of_random_robots_come_back_idle(
    form: str, linkage: Spinning, seed: int
) -> None:
    """In whatever order the joints stand, so that others could be chosen."""
    try:
        machine = Robot(shuffled(linkage.description(), seed))
    except DescriptionError:
        assume(False)
    with TemporaryDirectory() as folder:
        assert_idle_as_before(machine, form, Path(folder))


def test_a_copy_of_an_idle_robot_is_idle() -> None:
    machine = Robot(parse_description(CART))
    for other in (Robot(machine.description), pickle.loads(pickle.dumps(machine))):  # noqa: S301
        assert (other.idle, other.drives) == (("th",), ("x",))


def test_idle_joints_may_be_named() -> None:
    """Of a set of coordinates that is complete with them."""
    text = CART.replace("active_set: motors", "idle: [th]")
    machine = Robot(parse_description(text))
    assert (machine.active, machine.idle, machine.drives) == (("x", "th"), ("th",), ("x",))
    with pytest.raises(DescriptionError, match="'x' is active too; an idle joint is one that"):
        parse_description(text.replace("idle: [th]", "idle: [x]"))
