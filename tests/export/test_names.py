"""Names as URDF and ROS have them go through files, exports and commands of every kind."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import DescriptionError, Robot, load
from hybrid_dynamics_core.description.located_yaml import read_yaml
from tests.description.robots import parse
from tests.export.test_round_trip import FORMS, assert_the_same, write
from tests.sampling import examples

# Each kind of entry that has a name, as {0} to {19}.
TEXT = """\
format: 1
name: {0}
parameters: {{reach: 0.6}}
base: {1}
links:
  {1}: {{mass: 90}}
  {2}: {{mass: 10, com: [0.4, 0, 0], inertia: {{rod: {{axis: x, length: 0.8}}}}}}
  {3}: {{mass: 4, com: [0.2, 0, 0], inertia: {{rod: {{axis: x, length: 0.4}}}}}}
  {4}: {{mass: 2, com: [-0.2, 0, 0], inertia: {{rod: {{axis: x, length: 0.4}}}}}}
  {5}: {{mass: 1, com: [0.1, 0, 0], inertia: {{sphere: {{radius: 0.1}}}}}}
  {6}: {{mass: 1, com: [0.1, 0, 0], inertia: {{sphere: {{radius: 0.1}}}}}}
joints:
  {7}: {{type: revolute, parent: {1}, child: {2}, origin: {{rpy: [pi/2, 0, 0]}}, axis: z,
    friction: {{viscous: 3}}}}
  {8}: {{type: revolute, parent: {1}, child: {3}, axis: z,
    origin: {{xyz: [0.3, 0, -0.5], rpy: [pi/2, 0, 0]}}, spring: {{stiffness: 4, rest: 1}}}}
  {9}: {{type: prismatic, parent: {3}, child: {4}, origin: {{xyz: [0.4, 0, 0]}}, axis: x,
    limits: [0, 0.35]}}
  {10}: {{type: revolute, parent: {2}, child: {5}, origin: {{xyz: [0.8, 0, 0]}}, axis: z,
    mimic: {{joint: {7}, multiplier: -1}}}}
  {11}: {{type: revolute, parent: {14}, child: {6}, axis: x, limits: [-3, 3],
    drive: {{rotor_inertia: 1.0e-3, gear_ratio: 50}}}}
loops:
  {12}: {{type: A, base: {1}, arm: {2}, k1: {3}, k2: {4}, assembly: clockwise,
    pin: {{{4}: [0, 0, 0], {2}: [reach, 0, 0]}}}}
active: [{9}, {11}]
actuators:
  {9}: {{kind: hydraulic_cylinder, bore: 0.065, rod: 0.04, stroke: [0, 0.35]}}
frames:
  {13}: {{link: {6}, xyz: [0.1, 0, 0]}}
  {14}: {{link: {5}, xyz: [0.2, 0, 0]}}
payloads:
  {15}: {{on: {13}, mass: 2}}
end_effector: {{link: {13}}}
reference: {{{9}: 0.1, {11}: 0.3}}
"""
COUNT = 16
PLAIN = TEXT.format(*(f"n{k}" for k in range(COUNT)))
PUBLISHED = [
    *("two-arms", "base_link", "front-left", "arm/upper", "_x", "2nd", "left.hand"),
    *("arm/q-1", "1/q", "arm/slide", "-".join("abc"), "j_1/", "7-loop", "tool0", "a/b/c", "_"),
]


def is_text(name: str) -> bool:
    """Whether YAML takes it for a text, not for a number or nothing."""
    return read_yaml(f"[{name}]").data == [name]


def is_free(name: str) -> bool:
    """Whether no format has a meaning of its own for it."""
    return name not in ("world", "end_effector") and not name.startswith("__")


names = st.from_regex(r"[A-Za-z0-9_][A-Za-z0-9_./-]{0,11}", fullmatch=True)
named = st.lists(
    names.filter(is_text).filter(is_free), min_size=COUNT, max_size=COUNT, unique_by=str.lower
)


def efforts(robot: Robot) -> np.ndarray:
    state = robot.close([0.12, 0.4], [0.3, -0.2])
    return robot.inverse_dynamics(state, [0.5, 0.7])


@pytest.mark.parametrize("form", FORMS)
@examples(30)
@given(chosen=named)
def test_random_names_go_through_every_format(form: str, chosen: list[str]) -> None:
    robot, plain = Robot(parse(TEXT.format(*chosen))), Robot(parse(PLAIN))
    assert efforts(robot) == pytest.approx(efforts(plain), rel=1e-12)
    with tempfile.TemporaryDirectory() as folder:
        back = load(write(robot, form, Path(folder)))
    assert_the_same(robot, back)
    assert efforts(back) == pytest.approx(efforts(plain), rel=1e-9)


WRONG = ["-a", "/a", ".a", "a b", "a=b", "a,b", "q\u00e4", "a" * 201]


@pytest.mark.parametrize("name", WRONG)
def test_names_that_would_be_taken_for_something_else_are_refused(name: str) -> None:
    chosen = [f"n{k}" for k in range(COUNT)]
    chosen[2] = f'"{name}"'
    with pytest.raises(DescriptionError, match=r"not a valid name: letters, digits and _ - \. /"):
        parse(TEXT.format(*chosen))


def test_names_that_yaml_takes_for_numbers_stand_in_quotes() -> None:
    chosen = [f"n{k}" for k in range(COUNT)]
    chosen[2] = "'12'"
    assert "12" in parse(TEXT.format(*chosen)).links
    chosen[2] = "12"
    with pytest.raises(DescriptionError, match=r"is 12; expected text; .* in quotes: '12'"):
        parse(TEXT.format(*chosen))
