"""Welds beside ball joints, cut at the centre of the joint: equal to all six equations."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, reject
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hybrid_dynamics_core import ClosedState, Robot
from hybrid_dynamics_core.closure.blocks.leg_blocks import BallJointBlock
from hybrid_dynamics_core.closure.constraints import from_description
from hybrid_dynamics_core.dynamics.regrouped import regrouped
from hybrid_dynamics_core.errors import StateError
from hybrid_dynamics_core.formats.reader import parse_description
from tests.generated.assembly import unit
from tests.laws.test_loads import heavy_loads
from tests.laws.test_regrouped import require_equal
from tests.sampling import examples

ROUNDING = 1e-8  # of numbers of about 10; the weld is iterated to 1e-10
Pose = tuple[Rotation, np.ndarray]


class Chain:
    """Hinges in random frames, one behind the other, at zero."""

    def __init__(self, rng: np.random.Generator, name: str, data: dict[str, Any]) -> None:
        self.rng, self.name, self.data = rng, name, data
        self.link = "base"
        self.place: Pose = Rotation.identity(), np.zeros(3)

    def add(self, length: float, mass: float, **joint: Any) -> None:
        """Add a joint, a hinge about a random axis if nothing else is said."""
        number = len(self.data["joints"])
        turn, offset = Rotation.random(random_state=self.rng), length * self.rng.normal(size=3)
        link = f"{self.name}{number}"
        self.data["joints"][f"j_{link}"] = {
            "type": "revolute",
            "axis": unit(self.rng.normal(size=3)).tolist(),
            "parent": self.link,
            "child": link,
            "origin": {"xyz": offset.tolist(), "rpy": turn.as_euler("xyz").tolist()},
            **joint,
        }
        self.data["links"][link] = {}
        if mass:
            inertia = {"xx": 0.02, "yy": 0.03, "zz": 0.015, "xy": 0.002}
            com = (0.1 * self.rng.normal(size=3)).tolist()
            self.data["links"][link] = {"mass": mass, "com": com, "inertia": inertia}
        rotation, origin = self.place
        self.place = rotation * turn, origin + rotation.apply(offset)
        self.link = link


def welded(seed: int, kind: str) -> Robot:
    """Two chains, welded together; one of them ends in a ball joint."""
    rng = np.random.default_rng(seed)
    data: dict[str, Any] = {"format": 1, "name": "welded", "links": {"base": {}}, "joints": {}}
    one, other = Chain(rng, "a", data), Chain(rng, "b", data)
    for _ in range(2):
        one.add(0.3, 1.0)
    if kind == "ball":
        one.add(0.2, 2.0, type="ball", axis="z")
    else:
        one.add(0.2, 0.0)
        one.add(0.0, 0.4)
        one.add(0.0, 2.0)
    for _ in range(3):
        other.add(0.3, 1.5)
    frame, point = Rotation.random(random_state=rng), 0.2 * rng.normal(size=3)
    rotation, origin = one.place
    back, there = other.place
    end = origin + rotation.apply(point) - there
    turned = back.inv() * rotation * frame
    data["closures"] = {
        "weld": {
            "kind": "frame",
            "between": {
                one.link: {"xyz": point.tolist(), "rpy": frame.as_euler("xyz").tolist()},
                other.link: {
                    "xyz": back.inv().apply(end).tolist(),
                    "rpy": turned.as_euler("xyz").tolist(),
                },
            },
        }
    }
    data["active"] = list(data["joints"])[:2]
    data["end_effector"] = {"link": other.link}
    return Robot(parse_description(yaml.safe_dump(data, sort_keys=False)))


def closed(robot: Robot, u: np.ndarray, du: np.ndarray) -> ClosedState:
    """A state near zero; random robots that are too near a singular place for it do not count."""
    try:
        return robot.close(u, du)
    except StateError:
        reject()


@given(seed=st.integers(0, 10**6))
@examples(10)
@pytest.mark.parametrize("kind", ["hinges", "ball"])
def test_a_weld_cut_at_a_ball_joint_is_the_weld(kind: str, seed: int) -> None:
    cut = welded(seed, kind)
    assert any(isinstance(block, BallJointBlock) for block in cut._model.plan.blocks)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(from_description, "cut_at_ball", lambda *_: None)
        whole = welded(seed, kind)
    assert len(whole._model.plan.blocks) == 1
    rng = np.random.default_rng(seed)
    u, du, ddu = 0.03 * rng.uniform(-1.0, 1.0, 2), *rng.uniform(-1.0, 1.0, (2, 2))
    expected = closed(whole, u, du)
    state = cut.close(u, du)
    scale = max(1.0, float(np.abs(expected.R).max()) ** 2)
    assert state.s == pytest.approx(expected.s, abs=ROUNDING * scale)
    assert state.ds == pytest.approx(expected.ds, abs=ROUNDING * scale)
    efforts = whole.inverse_dynamics(expected, ddu)
    close = {"abs": ROUNDING * scale * max(10.0, float(np.abs(efforts).max()))}
    assert cut.inverse_dynamics(state, ddu) == pytest.approx(efforts, **close)
    assert cut.forward_dynamics(state, efforts) == pytest.approx(ddu, abs=1e-5)
    masses = [robot.minimal_form(at)[0] for robot, at in ((cut, state), (whole, expected))]
    assert masses[0] == pytest.approx(masses[1], **close)


@given(seed=st.integers(0, 10**6))
@examples(4)
@pytest.mark.parametrize("kind", ["hinges", "ball"])
def test_links_behind_the_joint_carry_no_mass_in_efforts(kind: str, seed: int) -> None:
    machine = welded(seed, kind)
    rng = np.random.default_rng(seed)
    u, du = 0.03 * rng.uniform(-1.0, 1.0, 2), rng.uniform(-1.0, 1.0, 2)
    state = closed(machine, u, du)
    for loads in (machine.loads, heavy_loads(machine)):
        require_equal(machine, [state], loads)
    model = machine._model.program_model
    tree = regrouped(model.tree, model.plan, machine.description.closures)
    behind = [body for body in tree.bodies if body.name.startswith("a")][2:]
    assert [body.mass for body in behind] == [0.0] * len(behind)
