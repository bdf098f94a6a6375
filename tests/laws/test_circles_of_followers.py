"""Joints that follow each other in a circle: a linear system, solved where it has one solution."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import DescriptionError, Robot
from hybrid_dynamics_core.export import to_yaml
from hybrid_dynamics_core.formats.reader import parse_description
from tests.agreement.pinocchio_model import PinocchioRobot
from tests.sampling import examples

NAMES = ("lead", "other", "one", "two", "three")
FOLLOWERS = NAMES[2:]
LEADERS = NAMES[:2]


def text_of(mimics: dict[str, Any]) -> str:
    """Five joints in a row, of which some follow others."""
    rng = np.random.default_rng(4)
    links: dict[str, Any] = {}
    joints: dict[str, Any] = {}
    parent = "base"
    for k, name in enumerate(NAMES):
        com = rng.uniform(-0.3, 0.3, 3).tolist()
        moments = dict(zip(("xx", "yy", "zz"), rng.uniform(0.02, 0.03, 3).tolist(), strict=True))
        links[f"link_{name}"] = {"mass": 1.0 + k, "com": com, "inertia": moments}
        joints[name] = {
            "type": "prismatic" if name == "two" else "revolute",
            "parent": parent,
            "child": f"link_{name}",
            "origin": {"xyz": rng.uniform(-0.5, 0.5, 3).tolist()},
            "axis": rng.normal(size=3).tolist(),
        }
        if name in mimics:
            joints[name]["mimic"] = mimics[name]
        parent = f"link_{name}"
    active = [name for name in NAMES if name not in mimics]
    robot = {"format": 1, "name": "row", "links": links, "joints": joints, "active": active}
    return yaml.safe_dump({**robot, "end_effector": {"link": parent}}, sort_keys=False)


def random_circle(seed: int) -> tuple[dict[str, Any], np.ndarray, np.ndarray, np.ndarray]:
    """Followers of leaders and of each other: q = A q + B u + c."""
    rng = np.random.default_rng(seed)
    among = np.round(rng.uniform(-2.0, 2.0, (3, 3)), 1)
    np.fill_diagonal(among, 0.0)
    leading = np.round(rng.uniform(-1.0, 1.0, (3, 2)), 1)
    offsets = np.round(rng.uniform(-0.2, 0.2, 3), 2)
    mimics = {}
    for row, name in enumerate(FOLLOWERS):
        multipliers = dict(zip((*FOLLOWERS, *LEADERS), (*among[row], *leading[row]), strict=True))
        kept = {source: float(value) for source, value in multipliers.items() if value}
        mimics[name] = {"joints": kept, "offset": float(offsets[row])}
    return mimics, among, leading, offsets


@given(st.integers(0, 100_000))
@examples(16, deadline=None)
def test_a_circle_is_a_linear_system(seed: int) -> None:
    """Coordinates against NumPy's solution; with its rates, mass and bias against Pinocchio's."""
    mimics, among, leading, offsets = random_circle(seed)
    matrix = np.eye(3) - among
    if np.linalg.cond(matrix) > 1e6:
        return
    robot = Robot(parse_description(text_of(mimics)))
    assert not robot.follows  # closed form
    assert robot.active == LEADERS
    state = robot.close([0.3, -0.2], [0.5, 0.7])
    values = dict(zip(robot.coordinates, state.s.tolist(), strict=True))
    expected = np.linalg.solve(matrix, leading @ state.u + offsets)
    assert [values[name] for name in FOLLOWERS] == pytest.approx(expected, abs=1e-9)
    order = [robot.coordinates.index(name) for name in (*LEADERS, *FOLLOWERS)]
    R = np.vstack([np.eye(2), np.linalg.solve(matrix, leading)])
    assert state.R[order] == pytest.approx(R, abs=1e-9)
    other = PinocchioRobot(robot.description, robot.coordinates)
    mass = robot.minimal_form(state)[0]
    assert mass == pytest.approx(
        state.R.T @ other.mass_matrix(state.s) @ state.R, rel=1e-9, abs=1e-9
    )
    forces = other.tree_forces(state.s, state.ds, robot.accelerations(state, [1.0, -1.0]))
    efforts = robot.inverse_dynamics(state, [1.0, -1.0])
    assert efforts == pytest.approx(state.R.T @ forces, rel=1e-9, abs=1e-8)
    back = Robot(parse_description(to_yaml(robot)))
    assert back.close(state.u).s == pytest.approx(state.s, abs=1e-12)


SINGULAR = {
    "the same twice": {"one": {"joint": "two"}, "two": {"joint": "one"}},
    "through a third": {
        "one": {"joint": "two", "multiplier": 4},
        "two": {"joint": "three", "multiplier": 0.5},
        "three": {"joint": "one", "multiplier": 0.5},
    },
    "with a leader": {"one": {"joints": {"lead": 1, "two": 1}}, "two": {"joint": "one"}},
    "itself": {"one": {"joint": "one", "multiplier": 2}},
}


@pytest.mark.parametrize("mimics", SINGULAR.values(), ids=SINGULAR.keys())
def test_a_circle_without_one_solution_is_refused_with_its_joints(mimics: dict[str, Any]) -> None:
    text = text_of(mimics)
    way = ", ".join(mimics)
    with pytest.raises(DescriptionError, match=f"does not determine {way};") as caught:
        parse_description(text)
    assert "'one' follows itself (one -> " in str(caught.value)
    assert text.splitlines()[(caught.value.line or 0) - 1].strip() == "mimic:"


def test_other_coordinates_may_be_given() -> None:
    """What leads is found from what follows, in a circle too."""
    mimics = {
        "one": {"joints": {"lead": -1, "two": 1}},
        "two": {"joints": {"one": 2, "other": 1}},
    }
    robot = Robot(parse_description(text_of(mimics)))
    state = robot.close([0.2, 0.3, 0.1])
    values = dict(zip(robot.coordinates, state.s.tolist(), strict=True))
    given = {name: values[name] for name in ("one", "two", "three")}
    again = robot.close_given(given)
    assert again.s == pytest.approx(state.s, abs=1e-12)
