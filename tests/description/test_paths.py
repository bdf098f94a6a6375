"""Numbers of a description by name or path: listed, read and changed as if the file had them."""

from __future__ import annotations

import copy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import DescriptionError, InputError, Robot, load, shipped_robots
from hybrid_dynamics_core.calibration import AdjustableRobot
from hybrid_dynamics_core.description.parameters import (
    parameter_paths,
    parameter_value,
    with_parameters,
)
from hybrid_dynamics_core.errors import UnknownNameError
from tests.sampling import examples, swept

FOUR_BAR = """\
format: 1
name: four_bar
parameters: {L2: 0.7}
links:
  base: {}
  boom: {mass: 20, com: [L2/2, 0, 0]}
  rod: {mass: 3}
  lever: {mass: 4}
  hand: {mass: 1}
joints:
  q1: {type: revolute, parent: base, child: boom, axis: y}
  q2: {type: revolute, parent: base, child: lever, axis: y, origin: {xyz: [0.9, 0, 0]}}
  q3: {type: revolute, parent: lever, child: rod, axis: y, origin: {xyz: [0.4, 0, 0.1]}}
  wrist.roll: {type: revolute, parent: boom, child: hand, axis: x, origin: {xyz: [L2, 0, 0]}}
loops:
  lift:
    {type: A, base: base, arm: boom, k1: lever, k2: rod, pin: {rod: [0.8, 0, 0], boom: [0.5, 0, 0]}}
active: [q1, wrist.roll]
end_effector: {link: hand}
reference: {q1: -1.2, q2: -1.4, q3: -1.5}
"""


@pytest.fixture(name="file")
def bar_file(tmp_path: Path) -> Path:
    path = tmp_path / "four_bar.yaml"
    path.write_text(FOUR_BAR, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("L2", 0.7),
        ("parameters.L2", 0.7),
        ("links.boom.mass", 20.0),
        ("links.boom.com[0]", 0.35),
        ("loops.lift.pin.rod[0]", 0.8),
        ("loops.lift.pin.rod", [0.8, 0.0, 0.0]),
        ("joints.q2.origin.xyz[0]", 0.9),
        ("joints.q1.offset", 0.0),
        ("joints.q1.origin.rpy[1]", 0.0),
        ("joints.wrist.roll.origin.xyz", [0.7, 0.0, 0.0]),
        ("end_effector.xyz[2]", 0.0),
        ("gravity[2]", -9.81),
    ],
)
def test_a_number_is_read_by_name_or_path(file: Path, name: str, value: float) -> None:
    assert np.array_equal(parameter_value(load(file).description, name), value)


CHANGES = {
    "L2: 0.7": {"L2": 0.72},
    "mass: 20": {"links.boom.mass": 21},
    "xyz: [0.9, 0, 0]": {"joints.q2.origin.xyz[0]": "905*mm"},
    "rod: [0.8, 0, 0]": {"loops.lift.pin.rod": [0.81, 0, 0.01]},
    "end_effector: {link: hand}": {"end_effector.xyz[2]": 0.1},
    "child: boom, axis: y}": {"joints.q1.offset": 0.02},
}
TEXTS = [
    "L2: 0.72",
    "mass: 21",
    "xyz: [0.905, 0, 0]",
    "rod: [0.81, 0, 0.01]",
    "end_effector: {link: hand, xyz: [0, 0, 0.1]}",
    "child: boom, axis: y, offset: 0.02}",
]


@pytest.mark.parametrize(("before", "after"), list(zip(CHANGES, TEXTS, strict=True)))
def test_a_changed_number_is_as_good_as_one_of_the_file(
    file: Path, before: str, after: str
) -> None:
    changed = load(file).with_parameters(CHANGES[before])
    assert before in FOUR_BAR
    file.write_text(FOUR_BAR.replace(before, after), encoding="utf-8")
    written = load(file)
    assert efforts(changed) == efforts(written)
    assert any("as given in the call" in note for note in changed.description.notes)


def efforts(robot: Robot) -> list[float]:
    state = robot.close(robot.reference + 0.05, [0.3] * len(robot.active))
    pose = robot.forward_kinematics(state).matrix.ravel()
    return [*robot.inverse_dynamics(state, [0.2] * len(robot.active)), *pose]


def test_changes_add_up_and_leave_the_robot_that_they_start_from(file: Path) -> None:
    robot = load(file)
    once = robot.with_parameters(L2=0.72)
    twice = copy.deepcopy(once).with_parameters({"links.boom.mass": 21})
    both = robot.with_parameters({"links.boom.mass": 21}, L2=0.72)
    assert efforts(twice) == efforts(both) != efforts(robot)
    assert parameter_value(robot.description, "L2") == 0.7
    assert parameter_value(twice.description, "L2") == 0.72


@pytest.mark.parametrize("name", swept(shipped_robots()))
def test_every_number_listed_is_read_and_written_back_the_same(name: str) -> None:
    description = load(name).description
    listed = parameter_paths(description)
    for path, value in listed.items():
        assert parameter_value(description, path) == value
    again = with_parameters(description, dict(listed.items()))
    for joint, other in zip(description.joints.values(), again.joints.values(), strict=True):
        assert np.allclose(joint.translation, other.translation, rtol=0.0, atol=1e-12)
    for link, other in zip(description.links.values(), again.links.values(), strict=True):
        assert np.allclose(link.com, other.com, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("role", ["arm", "k2"])
def test_a_pin_is_named_by_the_role_of_its_link(file: Path, role: str) -> None:
    """As in calibration: the same text of paths is read, changed and estimated."""
    link = {"arm": "boom", "k2": "rod"}[role]
    robot = load(file)
    by_role, by_link = f"loops.lift.pin.{role}", f"loops.lift.pin.{link}"
    before = parameter_value(robot.description, by_link)
    np.testing.assert_array_equal(parameter_value(robot.description, by_role), before)
    other = robot.with_parameters({f"{by_role}[0]": before[0] + 0.01})
    same = robot.with_parameters({f"{by_link}[0]": before[0] + 0.01})
    np.testing.assert_array_equal(other.close([-1.2, 0.0]).s, same.close([-1.2, 0.0]).s)
    free = AdjustableRobot(file).parameters([f"{by_role}[0]"])
    assert free[0].start == before[0]
    with pytest.raises(InputError, match="given twice"):
        robot.with_parameters({f"{by_role}[0]": 0.6, f"{by_link}[0]": 0.6})


FLAGS = """\
format: 1
name: body
floating: true
links: {base: {mass: 2}, hand: {mass: 1}}
joints:
  q1: {type: revolute, parent: base, child: hand, axis: y}
active: [q1]
end_effector: {link: hand}
"""


@pytest.mark.parametrize(
    "name",
    [
        "floating.mass",
        "floating.x[0]",
        "floating[0]",
        "name.x",
        "format.x",
        "links.hand.mass.x",
        "joints.q1.axis.x",
        "joints.q1.type.x.y",
        "loops.lift.pin.arm[0]",
        "loops.pin.arm",
    ],
)
def test_a_path_below_what_is_no_mapping_is_unknown(tmp_path: Path, name: str) -> None:
    path = tmp_path / "body.yaml"
    path.write_text(FLAGS, encoding="utf-8")
    robot = load(path)
    with pytest.raises(UnknownNameError, match="there is no parameter"):
        robot.with_parameters({name: 1.0})


def test_entries_of_modules_have_paths() -> None:
    robot = load("delta")
    assert parameter_value(robot.description, "modules.delta.parameters.arm") == 0.3
    assert parameter_value(robot.description, "joints.theta_B.offset") == 0.0
    changed = robot.with_parameters({"joints.theta_B.offset": 0.01})
    u = robot.reference.copy()
    u[1] -= 0.01
    moved = changed.forward_kinematics(changed.close(u)).position
    assert np.allclose(moved, robot.forward_kinematics(robot.close(robot.reference)).position)


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("L22", "did you mean 'L2'?"),
        ("links.bom.mass", "did you mean 'links.boom.mass'?"),
        ("loops.lift.pin.rod[3]", "did you mean 'loops.lift.pin.rod["),
        ("joints.q1.parent", "parameters: L2"),
        ("joints.q1.origin", "parameters: L2"),
        ("links", "parameters: L2"),
        ("", "parameters: L2"),
        ("joints.q1.offset.x", "parameters: L2"),
    ],
)
def test_a_name_that_is_not_there_gets_one_line_with_what_is_near(
    file: Path, name: str, hint: str
) -> None:
    with pytest.raises(UnknownNameError) as refused:
        load(file).with_parameters({name: 1.0})
    message = str(refused.value)
    assert f"there is no parameter '{name}'" in message
    assert hint in message
    assert "\n" not in message


@given(text=st.text(st.sampled_from("Lqlinks.[]0 2-"), max_size=12))
@examples(20)
def test_any_text_is_a_number_or_an_unknown_name(text: str) -> None:
    description = load("five_bar").description
    try:
        value = parameter_value(description, text)
    except UnknownNameError:
        return
    assert np.isfinite(value).all()


@pytest.mark.parametrize("value", [None, True, float("nan"), [1.0], object()])
def test_a_value_that_is_no_number_is_refused(file: Path, value: object) -> None:
    with pytest.raises(InputError, match="L2 is"):
        load(file).with_parameters(L2=value)


@pytest.mark.parametrize("value", [1.0, "1", [1.0, 2.0], "abc"])
def test_a_list_takes_as_many_numbers_as_it_has(file: Path, value: object) -> None:
    with pytest.raises(InputError, match=r"loops.lift.pin.rod means 3 numbers"):
        load(file).with_parameters({"loops.lift.pin.rod": value})


def test_a_length_that_opens_the_loop_says_which(file: Path) -> None:
    with pytest.raises(DescriptionError) as refused:
        load(file).with_parameters({"loops.lift.pin.rod[0]": 0.08})
    message = str(refused.value)
    assert "loops.lift" in message
    assert "does not close" in message
    assert "with loops.lift.pin.rod[0] = 0.08" in message
    assert "\n" not in message


def test_a_description_changed_by_a_program_has_no_numbers_of_its_file(file: Path) -> None:
    changed = replace(load(file).description, name="other")
    with pytest.raises(InputError, match="not read from a file, or was changed"):
        with_parameters(changed, {"L2": 0.7})


@pytest.mark.parametrize(
    ("value", "problem"),
    [("3*deg", "is an angle; expected a length"), ("2*kg", "is a mass; expected a length")],
)
def test_a_parameter_in_another_unit_than_its_entries_is_refused(value, problem):
    """The boom's length stands alone in places and sizes."""
    with pytest.raises(InputError, match=problem):
        load("excavator").with_parameters(boom=value)
