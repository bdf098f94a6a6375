"""Forward kinematics: chains, trees and single paths say the same, and what SciPy says."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hybrid_dynamics_core import load
from hybrid_dynamics_core.algebra.transform import IDENTITY, RigidTransform
from hybrid_dynamics_core.dynamics.spanning import TreeDynamics
from hybrid_dynamics_core.mechanism.configuration import Configuration, configuration_at
from hybrid_dynamics_core.mechanism.joint_transform import (
    joint_transforms,
    pose_in_base,
    poses_in_base,
    through_joint,
)
from hybrid_dynamics_core.mechanism.tree import Tree, build_tree

ROUNDING = 1e-14  # [m] of sums over a dozen joints
STEP = 1e-6  # [rad or m] of differences, whose error is of its square


def tree_of(name: str) -> tuple[Tree, np.ndarray]:
    """A shipped robot's tree, and any values of all its coordinates (n_s,)."""
    tree = build_tree(load(name).description)
    return tree, np.random.default_rng(2).uniform(-2.0, 2.0, len(tree.coordinates))


def assert_same(one: RigidTransform, other: RigidTransform) -> None:
    """Two poses agree to rounding."""
    np.testing.assert_allclose(one[0], other[0], atol=ROUNDING)
    np.testing.assert_allclose(one[1], other[1], atol=ROUNDING)


def along_path(tree: Tree, configuration: Configuration, body: int) -> RigidTransform:
    """The pose of a body, joint by joint as closures have it."""
    pose = IDENTITY
    for i in tree.path(body):
        pose, _ = through_joint(pose, tree.bodies[i], configuration)
    return pose


@pytest.mark.parametrize("name", ["staicu2015", "gough", "excavator", "forging_chu2020"])
class TestPoses:
    def test_chains_trees_and_paths_agree(self, name: str) -> None:
        tree, s = tree_of(name)
        configuration = configuration_at(tree, s)
        transforms = joint_transforms(tree, configuration)
        for body, pose in enumerate(poses_in_base(tree, transforms)):
            assert_same(pose, pose_in_base(tree, transforms, body))
            assert_same(pose, along_path(tree, configuration, body))

    def test_they_are_those_of_an_independent_library(self, name: str) -> None:
        tree, s = tree_of(name)
        poses = poses_in_base(tree, joint_transforms(tree, configuration_at(tree, s)))
        expected: list[tuple[Rotation, np.ndarray]] = []
        for body in tree.bodies:
            rotation, origin = Rotation.identity(), np.zeros(3)
            if body.parent >= 0:
                rotation, origin = expected[body.parent]
            origin = origin + rotation.apply(body.translation)
            rotation = rotation * Rotation.from_matrix(body.rotation)
            motion = s[body.coordinate] * np.array(body.axis)
            if body.is_revolute:
                rotation = rotation * Rotation.from_rotvec(motion)
            else:
                origin = origin + rotation.apply(motion)
            expected.append((rotation, origin))
        for pose, (rotation, origin) in zip(poses, expected, strict=True):
            assert_same(pose, (rotation.as_matrix(), origin))

    def test_at_zero_they_are_the_zero_poses(self, name: str) -> None:
        tree, s = tree_of(name)
        poses = poses_in_base(tree, joint_transforms(tree, configuration_at(tree, 0.0 * s)))
        for body, pose in enumerate(poses):
            assert_same(pose, tree.zero_pose(body))

    def test_columns_are_their_derivatives(self, name: str) -> None:
        tree, s = tree_of(name)
        body = len(tree.bodies) - 1
        columns = TreeDynamics(tree, configuration_at(tree, s)).jacobian(body, place(tree, s, body))
        for k, (linear, _) in columns.items():
            ahead, behind = s.copy(), s.copy()
            ahead[k] += STEP
            behind[k] -= STEP
            slope = (place(tree, ahead, body) - place(tree, behind, body)) / (2.0 * STEP)
            np.testing.assert_allclose(linear, slope, atol=1e-8)


def place(tree: Tree, s: np.ndarray, body: int) -> np.ndarray:
    """Origin of a body in the base frame (3,) [m]."""
    return np.array(TreeDynamics(tree, configuration_at(tree, s)).pose(body)[1])
