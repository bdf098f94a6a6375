"""Poses and Jacobians of frames of the closed mechanism."""

from __future__ import annotations

from ..algebra.scalar import Scalar
from ..algebra.transform import RigidTransform, compose
from ..algebra.vector import Rotation, Vector
from ..closure.closed_motion import ClosedMotion
from ..description.model import Frame
from ..dynamics.spanning import TreeDynamics
from ..kernels.trace import Results
from ..mechanism.tree import frame_offset
from .closure import closed_motion
from .model import AT_POSITION, Inputs, Model, Program


def frame_pose(tree: TreeDynamics, frame: Frame) -> RigidTransform:
    """Rotation and origin of a named frame in the base frame."""
    pose = tree.pose(tree.tree.body_index(frame.link))
    return compose(pose, frame_offset(frame))


def forward_kinematics(frame: Frame) -> Program:
    """Program for the pose of one frame."""

    def run(model: Model, x: Inputs) -> Results:
        motion, checks, _ = closed_motion(model, x)
        rotation, position = frame_pose(TreeDynamics(model.tree, motion.configuration), frame)
        return Results({"position": position, "rotation": rotation}, checks)

    return Program(AT_POSITION, run)


def jacobian(frame: Frame) -> Program:
    """Program for the (6, n) Jacobian of one frame's origin with respect to u: J = J_tree R."""

    def run(model: Model, x: Inputs) -> Results:
        motion, checks, _ = closed_motion(model, x)
        _, _, rows = pose_of(model, motion, frame)
        return Results({"jacobian": rows}, checks)

    return Program(AT_POSITION, run)


def pose_and_jacobian(frame: Frame) -> Program:
    """Program for pose and Jacobian together, for the steps of inverse kinematics."""

    def run(model: Model, x: Inputs) -> Results:
        motion, checks, _ = closed_motion(model, x)
        rotation, position, rows = pose_of(model, motion, frame)
        return Results({"position": position, "rotation": rotation, "jacobian": rows}, checks)

    return Program(AT_POSITION, run)


def pose_of(
    model: Model, motion: ClosedMotion, frame: Frame
) -> tuple[Rotation, Vector, list[list[Scalar]]]:
    """Rotation, origin and the rows of the Jacobian (6, n) of a frame."""
    tree = TreeDynamics(model.tree, motion.configuration)
    rotation, position = frame_pose(tree, frame)
    columns = tree.jacobian(model.tree.body_index(frame.link), position)
    velocity_map = motion.velocity_map()
    rows: list[list[Scalar]] = [[0.0] * len(motion.given) for _ in range(6)]
    for k, (linear, angular) in columns.items():
        for row, part in zip(rows, (*linear, *angular), strict=True):
            for j, factor in enumerate(velocity_map[k]):
                row[j] = row[j] + part * factor
    return rotation, position, rows
