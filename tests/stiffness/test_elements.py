"""Single elements: belts, bearings as numbers and as matrices, soft ground, idle joints."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import SingularityError, load
from hybrid_dynamics_core.stiffness import Bearing, Belt, DriveStiffness, Elasticity, LinkMatrix
from tests.stiffness.machines import CANTILEVER, CRANE, machine

EXACT = 1e-9  # loops close to 1e-12
ARM = 4.0  # [m] of the cantilever

IDLE = """
format: 1
name: pendulum
links: {upper: {mass: 1, com: [0, 0, -1]}, lower: {mass: 1, com: [0, 0, -1]}}
joints:
  q1: {type: revolute, parent: base, child: upper, axis: y}
  q2: {type: revolute, parent: upper, child: lower, axis: y, origin: {xyz: [0, 0, -2]}}
active: [q1]
idle: [q2]
end_effector: {link: lower, xyz: [0, 0, -2]}
"""


def lever(arm: float) -> np.ndarray:
    """Displacement at an arm along x of a body, from that at its foot."""
    moved = np.eye(6)
    moved[1, 5] = arm
    moved[2, 4] = -arm
    return moved


@pytest.mark.parametrize("spans", [(0.5,), (0.4, 0.6)])
def test_a_belt_is_its_strands_side_by_side(spans):
    robot = machine(CANTILEVER, shear="Ay: .inf")
    belt = Belt(2e5, spans, radius=0.05)
    elasticity = Elasticity({"q": DriveStiffness(1e4, belt=belt)})
    compliance = robot.stiffness(robot.close([0.0]), elasticity).compliance
    stiffness = sum(2e5 / span for span in spans) * 0.05**2
    assert compliance[4, 4] == pytest.approx(1.0 / stiffness + 1e-4, rel=EXACT)  # in series
    assert compliance[2, 2] == pytest.approx(ARM**2 * compliance[4, 4], rel=EXACT)


def test_soft_ground_and_a_soft_link_move_the_tool_by_the_lever():
    robot = machine(CANTILEVER, shear="Ay: .inf")
    rng = np.random.default_rng(2)
    root = rng.normal(size=(6, 6))
    matrix = 1e6 * (root @ root.T + 6.0 * np.eye(6))
    expected = lever(ARM) @ np.linalg.inv(matrix) @ lever(ARM).T
    for link in ("base", "boom"):
        elasticity = Elasticity(links={link: LinkMatrix(matrix)})
        compliance = robot.stiffness(robot.close([0.0]), elasticity).compliance
        np.testing.assert_allclose(compliance, expected, rtol=1e-9, atol=1e-20)


def test_a_matrix_of_a_pin_is_the_same_as_its_numbers():
    robot = machine(CRANE)
    state = robot.close([2.5])
    numbers = {
        "lug": Bearing(radial=3e8),
        "luff": Bearing(radial=2e8, axial=1e8, tilt=1e7),
    }
    matrices = {
        "lug": Bearing(matrix=np.diag([3e8, 3e8, 0, 0, 0, 0])),
        "luff": Bearing(matrix=np.diag([2e8, 2e8, 1e8, 1e7, 1e7, 0])),
    }
    one = robot.stiffness(state, Elasticity(pins=numbers)).compliance
    other = robot.stiffness(state, Elasticity(pins=matrices)).compliance
    np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-9 * np.abs(one).max())


def test_a_cranes_pin_yields_as_castigliano_says():
    """The 3-4-5 triangle: the rod pulls F 5 / 1.2, and the pin gives way along it."""
    robot = machine(CRANE)
    elasticity = Elasticity(pins={"lug": Bearing(radial=3e8)})
    pulled = 5.0 / 1.2
    compliance = robot.stiffness(robot.close([2.5]), elasticity).compliance
    assert compliance[2, 2] == pytest.approx(pulled**2 / 3e8, rel=EXACT)


def test_what_nothing_holds_is_refused_by_name():
    robot = machine(IDLE)
    state = robot.close([0.0, 0.0])
    with pytest.raises(SingularityError, match="q2 move without any spring"):
        robot.stiffness(state, Elasticity({"q1": 1e5}))
    # the link above the idle joint is held
    upper = robot.stiffness(state, Elasticity({"q1": 1e5}), frame="upper")
    assert upper.stiffness_along([0, 0, 0, 0, 1, 0]) == pytest.approx(1e5)
    # hanging straight down, its weight has no part along the joint
    assert upper.deflection().displacement == pytest.approx(np.zeros(6), abs=1e-15)
    tilted = robot.stiffness(robot.close([0.3, 0.2]), Elasticity({"q1": 1e5}), frame="upper")
    with pytest.raises(SingularityError, match="do not hold the load"):
        tilted.deflection()


def test_a_platform_is_stiffer_with_all_its_legs_elastic_than_with_softer_ones():
    robot = load("gough")
    state = robot.close(robot.reference)
    legs = dict.fromkeys(robot.all_drives, 1e6)
    stiff = robot.stiffness(state, Elasticity(legs)).stiffness
    soft = robot.stiffness(state, Elasticity({**legs, robot.all_drives[0]: 1e5})).stiffness
    np.testing.assert_allclose(stiff, stiff.T, rtol=1e-9)
    assert np.linalg.eigvalsh(stiff - soft).min() > -1e-6 * np.abs(stiff).max()
