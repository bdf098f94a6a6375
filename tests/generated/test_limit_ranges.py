"""`robot.limits` obey the limits of joints that follow through loops, and end where one is met."""

from __future__ import annotations

import contextlib
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.closure.toggle_range import given_inputs
from hybrid_dynamics_core.errors import ClosureError, HybridDynamicsError
from hybrid_dynamics_core.formats.reader import parse_description
from tests.generated.case import Case
from tests.generated.class_three import class_three
from tests.generated.robots import STATES, examples

WAYS = (-1, 1)
NEAR_END = 1e-6  # [rad or m]
OBEYED = 1e-9  # [rad or m]
NO_RATE = 1e-9
STEPS = 40  # of the way from the reference to an end


def limited(robot: Robot, rng: np.random.Generator) -> Robot:
    """The robot with limits about the reference on two of three joints that loops move."""
    joints = dict(robot.description.joints)
    reference = dict(zip(robot.coordinates, robot.close(robot.reference).s.tolist(), strict=True))
    for name in robot.passive:
        if rng.random() < 2.0 / 3.0:
            below, above = rng.uniform(0.02, 0.5, 2)
            limits = (reference[name] - below, reference[name] + above)
            joints[name] = replace(joints[name], limits=limits)
    return Robot(replace(robot.description, joints=joints))


def followers(robot: Robot, k: int, rng: np.random.Generator) -> list[str]:
    """Joints whose loops depend on one active coordinate alone, and that it moves."""
    n = len(robot.active)
    plan = robot._model.plan
    names: list[str] = []
    for block in plan.blocks:
        if given_inputs(plan, block) == [k]:
            names += [robot.coordinates[unknown] for unknown in block.unknowns]
    for _ in range(3):
        state = robot.close(robot.reference + 0.01 * rng.normal(size=n), check=False)
        assume(state.status == 0)  # the reference may be next to a toggle point
        rates = state.R
        for name in names:
            others = np.delete(rates[robot.coordinates.index(name)], k)
            assert np.abs(others).max(initial=0.0) < NO_RATE
    return names


def excess(robot: Robot, s: np.ndarray, names: list[str]) -> float:
    """By how much one of some joints is beyond its limits at most, of states (..., n_s)."""
    worst = -np.inf
    for name in names:
        lower, upper = robot.description.joints[name].limits
        values = s[..., robot.coordinates.index(name)]
        worst = max(worst, lower - values.min(), values.max() - upper)
    return worst


def followed(robot: Robot, k: int, end: float) -> np.ndarray:
    """All coordinates (STEPS + 1, n_s) on the way of one from the reference to an end."""
    u = np.tile(robot.reference, (STEPS + 1, 1))
    u[:, k] = np.linspace(robot.reference[k], end, STEPS + 1)
    return robot.close_path(u).s


@examples(40)
@given(class_three(max_links=3, max_loops=3), STATES)
def test_limits_are_those_of_all_joints_that_follow(case: Case, seed: int) -> None:
    rng = np.random.default_rng(seed)
    robot = limited(case.robot, rng)
    assume(not robot.follows)
    for k in range(len(robot.active)):
        names = followers(robot, k, rng)
        for end, closing, way in zip(robot.limits[k], robot.closing_range[k], WAYS, strict=True):
            if end != closing:
                try:
                    inside = followed(robot, k, end - way * NEAR_END)
                    outside = followed(robot, k, end + way * NEAR_END)
                except HybridDynamicsError:  # of a loop with further coordinates
                    continue
                assert excess(robot, inside, names) <= OBEYED
                assert excess(robot, outside[-1], names) > 0.0
                continue
            # no limit was met before the loops end, or at all
            far = robot.reference[k] + 0.3 * way
            near = min(far * way, end * way - 0.01) * way
            with contextlib.suppress(HybridDynamicsError):  # of a loop with further coordinates
                assert excess(robot, followed(robot, k, near), names) <= OBEYED


CRANK = """
format: 1
name: crank
links:
  base: {}
  crank: {mass: 1}
  rod: {mass: 1}
  ram: {mass: 1}
joints:
  a: {type: revolute, parent: base, child: crank, axis: z}
  b: {type: revolute, parent: crank, child: rod, axis: z, origin: {xyz: [LENGTH, 0, 0]},
    limits: [-5, 2]}
  x: {type: prismatic, parent: base, child: ram, axis: x, limits: [SHORTEST, 2]}
closures:
  pin: {kind: planar, between: {rod: [0.5, 0, 0], ram: [0, 0, 0]}}
active: [a]
end_effector: {link: ram}
reference: {a: 0.5, b: -0.7, x: 1}
"""


def crank(shortest: float, length: float = 0.2) -> Robot:
    text = CRANK.replace("SHORTEST", str(shortest)).replace("LENGTH", str(length))
    return Robot(parse_description(text))


def test_a_slide_ends_the_turn_of_its_crank() -> None:
    """By the law of cosines: crank 0.2 m, rod 0.5 m, slide 0.5 m."""
    end = float(np.arccos(0.2))
    assert crank(0.5).limits[0] == pytest.approx([-end, end], abs=1e-12)
    assert not np.isfinite(crank(0.5).closing_range).any()


def test_a_pin_that_turns_with_its_crank_counts_whole_turns() -> None:
    """Its angle is that of the rod less that of the crank."""
    lower, upper = crank(0.1).limits[0].tolist()
    for a, b in ((lower, 2.0), (upper, -5.0)):
        assert a + b == pytest.approx(-np.arcsin(0.4 * np.sin(a)), abs=1e-9)
    assert upper > np.pi


def test_a_refusal_names_the_limits_that_the_slide_leaves() -> None:
    """Crank 0.6 m, rod 0.5 m: the loop closes to asin(5/6), the slide ends at 0.9 m."""
    machine = crank(0.9, 0.6)
    end, limit = float(np.arcsin(5.0 / 6.0)), float(np.arccos(0.92 / 1.08))
    assert machine.closing_range[0] == pytest.approx([-end, end], abs=1e-12)
    assert machine.limits[0] == pytest.approx([-limit, limit], abs=1e-12)
    words = r"the limits of a are \[-0.551286, 0.551286\] rad"
    with pytest.raises(ClosureError, match=words) as caught:
        machine.close([1.2])
    assert caught.value.allowed == pytest.approx((-end, end), abs=1e-12)
