"""Robots that bear loads: levers turn as they give way.

Deflections are differences of two nonlinear equilibria, each found by Newton's method on drives
and loops. Drives are soft, so that loads count: without their part the compliance is off by
percents.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given

from hybrid_dynamics_core import Loads, Payload, Robot, SingularityError, load, shipped_robots
from hybrid_dynamics_core.stiffness import Elasticity
from tests.generated.case import Case
from tests.generated.robots import STATES, examples, robots
from tests.sampling import swept
from tests.stiffness.machines import CRANE, machine

WRENCH = np.array([800.0, 500.0, -900.0, 90.0, 50.0, 40.0])
SMALL = 1.0  # [N] of further forces: differences keep 7 digits and more
CLOSE = 1e-5  # of the largest entry: differences over 1 N of places that are known to 1e-13 m
SOFT = 2e4  # [N/m, N m/rad]


def places(
    robot: Robot,
    start: np.ndarray,
    drives: np.ndarray,
    loads: Callable[[np.ndarray], Loads],
) -> np.ndarray:
    """Displacement (3, 3) of the tool per further force, from equilibria on both sides.

    Args:
        robot: the robot, whose drives are its active joints.
        start: (n,) where it is in equilibrium without a further force.
        drives: (n,) stiffnesses.
        loads: loads with a further force.
    """
    still = np.zeros(len(start))

    def needed(u: np.ndarray, force: np.ndarray) -> np.ndarray:
        return robot.inverse_dynamics(robot.close(u), still, loads(force))

    held = needed(start, np.zeros(3))
    step = 1e-6
    slopes = [
        (needed(start + step * e, np.zeros(3)) - needed(start - step * e, np.zeros(3))) / (2 * step)
        for e in np.eye(len(start))
    ]
    tangent = np.column_stack(slopes) + np.diag(drives)
    columns = []
    for axis in SMALL * np.eye(3):
        ends = []
        for force in (axis, -axis):
            u = start.copy()
            for _ in range(30):
                off = np.linalg.solve(tangent, needed(u, force) - held + drives * (u - start))
                u = u - off
                if np.abs(off).max() < 1e-13:
                    break
            ends.append(robot.forward_kinematics(robot.close(u)).position)
        columns.append((ends[0] - ends[1]) / (2 * SMALL))
    return np.column_stack(columns)


def off(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.abs(one - other).max() / np.abs(other).max())


@pytest.mark.parametrize("axes", ["base", "frame"])
@pytest.mark.parametrize("name", swept(shipped_robots(), ["excavator", "forging_chu2020", "gough"]))
def test_shipped_robots_move_as_loaded_machines_do(name: str, axes: str) -> None:
    robot = load(name)
    state = robot.close(robot.reference)
    drives = SOFT * (1.0 + np.arange(len(robot.active)))
    bare = robot.loads.with_gravity(np.array([3.0, 2.0, -9.0]))

    def loads(force: np.ndarray) -> Loads:
        return bare.with_wrench(WRENCH + np.concatenate([force, np.zeros(3)]), axes=axes)

    assert tuple(robot.all_drives) == tuple(robot.active)
    stiffness = robot.stiffness(state, Elasticity(dict(zip(robot.all_drives, drives, strict=True))))
    loaded = stiffness.loaded(loads(np.zeros(3)))
    turned = np.eye(3)
    if axes == "frame":
        turned = robot.forward_kinematics(state).rotation
    expected = places(robot, robot.reference, drives, loads)
    assert off(loaded.compliance[:3, :3] @ turned, expected) < CLOSE
    assert off(stiffness.compliance[:3, :3] @ turned, expected) > 10 * CLOSE
    np.testing.assert_allclose(
        sum(loaded.shares.values()),
        loaded.compliance,
        atol=1e-12 * np.abs(loaded.compliance).max(),
    )


@examples(10)
@given(robots(), STATES)
def test_random_robots_move_as_loaded_machines_do(case: Case, seed: int) -> None:
    robot = case.robot
    start = case.somewhere(seed)[: case.n]
    drives = np.full(case.n, 1e4)
    chosen = dict(zip(robot.active, drives, strict=True))
    assume(set(robot.all_drives) == set(robot.active))
    wrench = np.random.default_rng(seed).uniform(-1.0, 1.0, 6) * 100.0
    bare = replace(robot.loads, payloads={})

    def loads(force: np.ndarray) -> Loads:
        return bare.with_wrench(wrench + np.concatenate([force, np.zeros(3)]))

    stiffness = robot.stiffness(robot.close(start), Elasticity(chosen))
    try:
        loaded = stiffness.loaded(loads(np.zeros(3)))
    except SingularityError:
        assume(False)
    assume(loaded.critical_factor > 2.0)
    expected = places(robot, start, drives, loads)
    assert off(loaded.compliance[:3, :3], expected) < CLOSE


COLUMN = """
format: 1
name: column
links: {mast: {mass: 0.0, com: [0, 0, 0]}}
joints: {q: {type: revolute, parent: base, child: mast, axis: y, limits: [-1, 1]}}
active: [q]
end_effector: {link: mast, xyz: [0, 0, <length>]}
stiffness: {drives: {q: <stiffness>}}
"""


def test_a_column_on_a_spring_tips_at_its_stiffness_over_its_length() -> None:
    length, stiffness, gravity = 2.0, 5e3, 9.81
    robot = machine(COLUMN, length=length, stiffness=stiffness)
    elastic = robot.stiffness(robot.close([0.0]))
    mass = 100.0
    loads = robot.loads.with_gravity([0, 0, -gravity]).with_payload(Payload(mass))
    loaded = elastic.loaded(loads)
    tipping = mass * gravity * length
    assert loaded.compliance[0, 0] == pytest.approx(length**2 / (stiffness - tipping), rel=1e-12)
    assert loaded.critical_factor == pytest.approx(stiffness / tipping, rel=1e-12)
    hanging = elastic.loaded(loads.with_gravity([0, 0, gravity]))
    assert hanging.compliance[0, 0] == pytest.approx(length**2 / (stiffness + tipping), rel=1e-12)
    assert hanging.critical_factor == np.inf
    with pytest.raises(SingularityError, match="3 times the critical ones"):
        elastic.loaded(robot.loads.with_payload(Payload(3 * stiffness / (length * 9.80665))))


SLEWING = """
format: 1
name: slewing
links: {<links> boom: {mass: 300, com: [2, 0.5, 0.4]}}
joints:
  <joints>
  q: {type: revolute, parent: <parent>, child: boom, axis: z, limits: [-1, 1]}
active: [<active> q]
end_effector: {link: boom, xyz: [4, 1, 0.8]}
stiffness: {drives: {<drives> q: 2e5}, pins: {<pins>}}
"""


def test_a_bearing_is_two_hinges_under_load_too() -> None:
    bearing = machine(
        SLEWING, links="", joints="", parent="base", active="", drives="", pins="q: {tilt: 1e5}"
    )
    hinges = machine(
        SLEWING,
        links="cross: {}, plate: {},",
        joints="a: {type: revolute, parent: base, child: cross, axis: x, limits: [-1, 1]}\n"
        "  b: {type: revolute, parent: cross, child: plate, axis: y, limits: [-1, 1]}",
        parent="plate",
        active="a, b,",
        drives="a: 1e5, b: 1e5,",
        pins="",
    )
    one = bearing.stiffness(bearing.close([0.0]))
    other = hinges.stiffness(hinges.close([0.0] * 3))
    wanted = other.loaded().compliance
    np.testing.assert_allclose(one.loaded().compliance, wanted, atol=1e-12 * np.abs(wanted).max())
    assert off(one.compliance, wanted) > 1e-3


def test_a_pin_of_a_loop_is_two_slides_under_load_too() -> None:
    stiffness = 4e5
    text = CRANE.replace("{oil: {bulk_modulus: 1.2e9, dead_volume: [1e-3, 2e-3]}}", "3e5")
    pinned = machine(text + f"  pins: {{lug: {{radial: {stiffness}}}}}\n")
    slides = text.replace("  barrel: {}", "  near: {}\n  far: {}\n  barrel: {}").replace(
        "closures:",
        "  across: {type: prismatic, parent: boom, child: near, axis: x, limits: [-1, 1],"
        " origin: {xyz: [1.5, 0, 0]}}\n"
        "  along: {type: prismatic, parent: near, child: far, axis: z, limits: [-1, 1]}\n"
        "closures:",
    )
    slides = slides.replace("boom: [1.5, 0, 0]", "far: [0, 0, 0]")
    slides = slides.replace("active: [cylinder]", "active: [cylinder, across, along]")
    slides += f"    across: {stiffness}\n    along: {stiffness}\n"
    sliding = machine(slides)
    one = pinned.stiffness(pinned.close([2.5]))
    other = sliding.stiffness(sliding.close([2.5, 0.0, 0.0]))
    np.testing.assert_allclose(one.compliance, other.compliance, atol=1e-15)
    wanted = other.loaded().compliance
    np.testing.assert_allclose(one.loaded().compliance, wanted, atol=1e-12 * np.abs(wanted).max())
    assert off(one.compliance, wanted) > 1e-3
