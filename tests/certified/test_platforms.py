"""Platforms on six legs: every pose certified, and the list proved to be complete."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core.certified.platforms import platform as solver
from hybrid_dynamics_core.certified.platforms.certificates import System, certify
from hybrid_dynamics_core.certified.platforms.start_system import most_poses, start_system
from hybrid_dynamics_core.certified.platforms.study import Legs, quadrics
from tests.certified.geometries import random_legs, random_turn, solved
from tests.hard_cases.multistart import platform_poses
from tests.sampling import swept

SEEDS = swept(range(12), range(2))


@pytest.mark.parametrize("seed", SEEDS)
def test_no_pose_of_brute_force_is_missing(seed: int) -> None:
    """Newton from a thousand starts, on rotations, reaches no pose that the list lacks."""
    feet, tips, lengths = random_legs(np.random.default_rng(seed))
    poses = solved(feet, tips, lengths)
    assert poses.complete, poses.reason
    assert len(poses.origins) % 2 == 0
    for rotation, origin in zip(poses.rotations, poses.origins, strict=True):
        reached = np.linalg.norm(origin + tips @ rotation.T - feet, axis=1)
        np.testing.assert_allclose(reached, lengths, atol=1e-9)
    for rotation, origin in platform_poses(feet, tips, lengths, 1000, seed):
        apart = np.abs(poses.rotations - rotation).max(axis=(1, 2))
        apart += np.abs(poses.origins - origin).max(axis=1)
        assert np.count_nonzero(apart < 1e-6) == 1


@pytest.mark.parametrize("seed", SEEDS)
def test_a_list_does_not_depend_on_frames_units_and_order(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    feet, tips, lengths = random_legs(rng)
    order = rng.permutation(6)
    base, top = random_turn(rng), random_turn(rng)
    moved = 7.0 * feet[order] @ base.T + 50.0
    turned = 7.0 * tips[order] @ top.T + rng.normal(size=3)
    one, other = solved(feet, tips, lengths), solved(moved, turned, 7.0 * lengths[order])
    assert one.complete
    assert other.complete
    expected = np.sort([np.trace(base @ r @ top.T) for r in one.rotations])
    np.testing.assert_allclose(np.sort(np.trace(other.rotations.T)), expected, atol=1e-6)


def test_lengths_out_of_reach_have_no_pose_and_that_is_proved() -> None:
    feet, tips, lengths = random_legs(np.random.default_rng(4))
    poses = solved(feet, tips, lengths * [1.0, 9.0, 1.0, 1.0, 1.0, 0.1])
    assert poses.complete
    assert len(poses.origins) == 0


@pytest.mark.parametrize("shared_feet", [False, True])
@pytest.mark.parametrize("seed", swept(range(12), range(2)))
def test_platforms_with_shared_tips_have_sixteen_complex_poses(
    seed: int, shared_feet: bool
) -> None:
    """Three points of the platform, or of the base, take two legs each, in any order."""
    rng = np.random.default_rng(seed)
    feet, tips, _ = random_legs(rng)
    shared = np.repeat(tips[:3], 2, axis=0)[rng.permutation(6)]
    lengths = np.linalg.norm(np.array([0.1, 0.2, 0.9]) + shared - feet, axis=1)
    if shared_feet:
        feet, shared = shared, feet
        lengths = np.linalg.norm(np.array([0.1, 0.2, 0.9]) + shared - feet, axis=1)
    poses = solved(feet, shared, lengths)
    assert poses.complete
    assert poses.reason.startswith("all 16 complex solutions are certified")
    for rotation, origin in platform_poses(feet, shared, lengths, 600, seed):
        apart = np.abs(poses.rotations - rotation).max(axis=(1, 2))
        apart += np.abs(poses.origins - origin).max(axis=1)
        assert np.count_nonzero(apart < 1e-6) == 1


def test_platforms_on_hexagons_have_fewer_solutions_and_are_not_called_complete() -> None:
    angles = np.repeat([0.0, 2.0, 4.0], 2) * np.pi / 3.0
    sides = np.tile([1.0, -1.0], 3)
    rings = [angles + 0.2 * sides, angles + 0.7 * sides]
    feet, tips = (np.stack([np.cos(a), np.sin(a), 0.0 * a], axis=1) for a in rings)
    lengths = np.linalg.norm(random_turn(np.random.default_rng(2))[2] + 0.6 * tips - feet, axis=1)
    poses = solved(feet, 0.6 * tips, lengths)
    assert not poses.complete
    assert "of 40 complex solutions are certified" in poses.reason


@pytest.mark.parametrize("in_pairs", [False, True])
def test_start_systems_have_all_their_solutions(in_pairs: bool) -> None:
    for number in range(2):
        start = start_system(number, in_pairs)
        matrices = quadrics(start.legs)
        values = np.einsum("ni,kij,nj->nk", start.points, matrices, start.points)
        assert len(start.points) == most_poses(in_pairs)
        assert np.abs(values).max() < 1e-6


def test_points_that_are_no_solutions_are_not_certified() -> None:
    rng = np.random.default_rng(6)
    feet, tips, lengths = random_legs(rng)
    system = System(quadrics(Legs(feet, tips, lengths**2)).real, np.full(7, 1e-15))
    points = rng.normal(size=(50, 8)) + 1j * rng.normal(size=(50, 8))
    balls = certify(system, points / np.linalg.norm(points, axis=1)[:, None])
    assert not balls.certified.any()


def test_a_certificate_holds_for_every_geometry_within_its_radius() -> None:
    """Solutions of changed quadrics stay in the balls that were certified for all of them."""
    rng = np.random.default_rng(7)
    feet, tips, lengths = random_legs(rng)
    legs = Legs(feet, tips, lengths**2)
    matrices = quadrics(legs).real
    ends = start_system(0)
    tracker = solver.PathTracker.between(ends.legs, legs)
    points = solver.polished(matrices, tracker.ends(ends.points).points)
    doubt = np.full(7, 1e-9)
    balls = certify(System(matrices, doubt), points)
    noise = rng.uniform(-1e-9, 1e-9, matrices.shape)
    changed = matrices + 0.5 * (noise + np.swapaxes(noise, 1, 2))
    moved = solver.polished(changed, balls.centres)
    beside = np.einsum("ni,ni->n", balls.centres.conj(), moved)
    distance = np.abs(moved / beside[:, None] - balls.centres).max(axis=1)
    assert balls.certified.any()
    assert (distance <= balls.radii)[balls.certified].all()
