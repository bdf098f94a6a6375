"""Quaternions and rotation matrices, against SciPy; half turns too, where w vanishes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hybrid_dynamics_core import Pose
from hybrid_dynamics_core.algebra.rotations import canonical, quaternion, rotation_matrix

ROUNDING = 4e-16  # of a component of a unit quaternion


def half_turns(axes: np.ndarray) -> np.ndarray:
    """Rotations by 180 degrees about unit axes (N, 3)."""
    return 2.0 * axes[:, :, None] * axes[:, None, :] - np.eye(3)


def unit_axes() -> np.ndarray:
    """Random axes, the coordinate axes and their opposites, and axes in the coordinate planes."""
    axes = np.random.default_rng(0).normal(size=(500, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    planes = [[0.0, 0.6, 0.8], [0.0, -0.6, 0.8], [-0.6, 0.8, 0.0], [0.8, 0.0, -0.6]]
    return np.vstack([axes, np.eye(3), -np.eye(3), planes])


CASES = {
    "random": Rotation.random(500, random_state=1).as_matrix(),
    "half turns": half_turns(unit_axes()),
    "nearly half turns": Rotation.from_rotvec((np.pi - 1e-9) * unit_axes()).as_matrix(),
    "small turns": Rotation.from_rotvec(1e-9 * unit_axes()).as_matrix(),
    "none": np.eye(3)[None],
}


@pytest.mark.parametrize("rotations", CASES.values(), ids=CASES.keys())
class TestQuaternions:
    def test_they_are_those_of_an_independent_library(self, rotations: np.ndarray) -> None:
        expected = Rotation.from_matrix(rotations).as_quat(canonical=True)
        np.testing.assert_allclose(canonical(quaternion(rotations)), expected, atol=ROUNDING)

    def test_one_has_the_bits_of_a_stack(self, rotations: np.ndarray) -> None:
        expected = [quaternion(rotation) for rotation in rotations]
        assert np.array_equal(quaternion(rotations), expected)

    def test_they_have_length_one_and_no_negative_w(self, rotations: np.ndarray) -> None:
        found = quaternion(rotations)
        np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1.0, atol=ROUNDING)
        assert found[:, 3].min() >= 0.0

    def test_they_give_the_rotations_back(self, rotations: np.ndarray) -> None:
        """The matrices are orthonormal to a few roundings only, the quaternions' exactly so."""
        back = [rotation_matrix(q) for q in quaternion(rotations)]
        np.testing.assert_allclose(back, rotations, atol=2e-15)

    def test_poses_have_them(self, rotations: np.ndarray) -> None:
        many = Pose(np.zeros((len(rotations), 3)), rotations).quaternion
        assert many.shape == (len(rotations), 4)
        one = Pose(np.zeros(3), rotations[0]).quaternion
        assert one.shape == (4,)
        assert np.array_equal(one, many[0])


def test_a_quaternion_of_any_length_gives_a_rotation() -> None:
    found = rotation_matrix([0.2, -0.4, 0.6, 1.0])
    expected = Rotation.from_quat([0.2, -0.4, 0.6, 1.0]).as_matrix()
    np.testing.assert_allclose(found, expected, atol=ROUNDING)


def test_of_two_quaternions_of_a_half_turn_one_is_canonical() -> None:
    turned = np.array([[-0.6, 0.8, 0.0, 0.0], [0.6, -0.8, 0.0, 0.0]])
    assert np.array_equal(canonical(turned), [[0.6, -0.8, 0.0, 0.0]] * 2)
