"""Planar platforms on three legs: all poses, by elimination, against searches."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core.certified.complex_ball import Ball, Polynomial
from hybrid_dynamics_core.certified.planar.planar_poses import PlanarLegs, PlanarPoses, planar_poses
from hybrid_dynamics_core.certified.planar.roots import discs
from tests.certified.geometries import random_planar_legs
from tests.hard_cases.linkages import robot as linkage
from tests.sampling import examples, swept

TRIPOD = """
format: 1
name: tripod
links: {base: {}, sx: {}, sy: {}, plate: {mass: 1}}
joints:
  x: {type: prismatic, parent: base, child: sx, axis: x}
  y: {type: prismatic, parent: sx, child: sy, axis: y}
  a: {type: revolute, parent: sy, child: plate, axis: z}
legs:
  one:
    joints:
      - {name: f0, type: revolute, axis: z}
      - {name: l0, type: prismatic, axis: x}
    to: {plate: [0.0, 0.0, 0.0]}
  two:
    joints:
      - {name: f1, type: revolute, axis: z, origin: {xyz: [2, 0, 0]}}
      - {name: l1, type: prismatic, axis: x}
    to: {plate: [0.7, 0.0, 0.0]}
  three:
    joints:
      - {name: f2, type: revolute, axis: z, origin: {xyz: [0.9, 1.8, 0]}}
      - {name: l2, type: prismatic, axis: x}
    to: {plate: [0.2, 0.6, 0.0]}
active: [l0, l1, l2]
end_effector: {link: plate}
reference: {x: 0.7, y: 0.5, a: 0.1, l0: 0.86, l1: 0.8, l2: 0.75}
"""

CARRIED_BY_A_LEG = TRIPOD.replace(
    """
links: {base: {}, sx: {}, sy: {}, plate: {mass: 1}}
joints:
  x: {type: prismatic, parent: base, child: sx, axis: x}
  y: {type: prismatic, parent: sx, child: sy, axis: y}
  a: {type: revolute, parent: sy, child: plate, axis: z}
legs:
  one:
    joints:
      - {name: f0, type: revolute, axis: z}
      - {name: l0, type: prismatic, axis: x}
    to: {plate: [0.0, 0.0, 0.0]}
""",
    """
links: {base: {}, bar: {}, rod: {mass: 1}, plate: {mass: 1}}
joints:
  f0: {type: revolute, parent: base, child: bar, axis: z}
  l0: {type: prismatic, parent: bar, child: rod, axis: x}
  a: {type: revolute, parent: rod, child: plate, axis: z}
legs:
""",
).replace("x: 0.7, y: 0.5, a: 0.1", "f0: 0.6, a: -0.5")


def solved(feet: np.ndarray, tips: np.ndarray, squares: np.ndarray) -> PlanarPoses:
    parts = [Ball(x.astype(complex), 1e-16 * np.abs(x)) for x in (feet, tips, squares)]
    return planar_poses(PlanarLegs(*parts))


def searched(feet: np.ndarray, tips: np.ndarray, squares: np.ndarray, starts: int) -> np.ndarray:
    """Rows (place, exp(i theta)) that Newton reaches from random starts, for one platform."""
    rng = np.random.default_rng(0)
    reach = np.abs(feet).max() + np.sqrt(squares.max())
    p = reach * (rng.uniform(-1, 1, starts) + 1j * rng.uniform(-1, 1, starts))
    theta = rng.uniform(-np.pi, np.pi, starts)
    for _ in range(60):
        arm = tips * np.exp(1j * theta)[:, None]
        leg = p[:, None] + arm - feet
        miss = 0.5 * (np.abs(leg) ** 2 - squares)
        turning = (leg.conj() * 1j * arm).real
        slope = np.stack([leg.real, leg.imag, turning], axis=2)
        slope[np.abs(np.linalg.det(slope)) < 1e-12] = np.eye(3)
        step = -np.linalg.solve(slope, miss[..., None])[..., 0]
        step *= np.minimum(1.0, 0.5 / np.maximum(np.abs(step).max(axis=1), 1e-12))[:, None]
        p = p + step[:, 0] + 1j * step[:, 1]
        theta = theta + step[:, 2]
    closed = np.abs(miss).max(axis=1) < 1e-12
    return np.stack([p[closed], np.exp(1j * theta[closed])], axis=1)


def test_lists_of_random_platforms_are_complete_and_hold_the_pose_that_gave_the_legs() -> None:
    feet, tips, squares, place, turn = random_planar_legs(np.random.default_rng(0), 500)
    poses = solved(feet, tips, squares)
    assert poses.complete.all()
    assert set(poses.real.sum(axis=1)) == {2, 4, 6}
    moved = poses.places[:, :, None] + poses.turns[:, :, None] * tips[:, None]
    miss = np.abs(np.abs(moved - feet[:, None]) ** 2 - squares[:, None]).max(axis=2)
    assert miss[poses.real].max() < 1e-5
    apart = np.abs(poses.turns - turn) + np.abs(poses.places - place)
    assert np.where(poses.real, apart, 1.0).min(axis=1).max() < 1e-5


@pytest.mark.parametrize("seed", swept(range(30), range(6)))
def test_no_pose_of_a_search_is_missing(seed: int) -> None:
    feet, tips, squares, _, _ = random_planar_legs(np.random.default_rng(seed), 1)
    poses = solved(feet, tips, squares)
    listed = np.stack([poses.places[0], poses.turns[0]], axis=1)[poses.real[0]]
    reached = searched(feet[0], tips[0], squares[0], 200)
    apart = np.abs(reached[:, None] - listed).max(axis=2)
    assert apart.min(axis=1).max() < 1e-6
    assert apart.min(axis=0).max() < 1e-6


def test_a_platform_that_gives_way_is_not_called_complete() -> None:
    """Parallel legs of equal length: the platform moves on circles."""
    feet = np.array([[0.0, 1.0, 0.3 + 1.0j]])
    poses = solved(feet, feet, np.full((1, 3), 0.25))
    assert not poses.complete.any()


def test_legs_out_of_reach_have_no_pose_and_that_is_proved() -> None:
    feet, tips, squares, _, _ = random_planar_legs(np.random.default_rng(1), 20)
    squares[:, 0] += 1e3
    poses = solved(feet, tips, squares)
    assert poses.complete.all()
    assert not poses.real.any()


@pytest.mark.parametrize("text", [TRIPOD, CARRIED_BY_A_LEG], ids=["slides", "leg"])
def test_a_robot_lists_its_modes_and_says_why_there_are_no_others(text: str) -> None:
    robot = linkage(text)
    modes = robot.assembly_modes(robot.reference)
    assert modes.complete
    assert "proved to have no other" in modes.reason
    assert all(mode.state.residual < 1e-12 for mode in modes)
    feet = np.array([0.0, 2.0, 0.9 + 1.8j])
    tips = np.array([0.0, 0.7, 0.2 + 0.6j])
    reached = searched(feet, tips, robot.reference**2, 200)
    listed = []
    for mode in modes:
        pose = robot.forward_kinematics(mode.state, frame="plate")
        turned = pose.rotation[0, 0] + 1j * pose.rotation[1, 0]
        listed.append((pose.position[0] + 1j * pose.position[1], turned))
    apart = np.abs(reached[:, None] - np.array(listed)).max(axis=2)
    assert apart.min(axis=1).max() < 1e-6
    assert apart.min(axis=0).max() < 1e-6


ROOTS = st.lists(st.complex_numbers(max_magnitude=3.0), min_size=2, max_size=6)


@given(ROOTS)
@examples(100)
def test_discs_hold_the_roots_that_a_polynomial_was_made_of(roots: list[complex]) -> None:
    one = Ball(np.ones(1, dtype=complex), np.zeros(1))
    product = Polynomial(0, (one,))
    for root in roots:
        factor = Ball(np.array([-root]), np.zeros(1))
        product = product.times(Polynomial(0, (factor, one)))
    middle = np.stack([c.middle for c in product.coefficients], axis=1)
    radius = np.stack([c.radius for c in product.coefficients], axis=1)
    reached = discs(Ball(middle, radius))
    apart = np.abs(np.array(roots)[:, None] - reached.centres[0])
    assert (apart <= reached.radii[0]).any(axis=1).all()
