"""Machines that differ from their files, and what a laser tracker measures on them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hybrid_dynamics_core.algebra.rotations import quaternion
from hybrid_dynamics_core.calibration import AdjustableRobot, FreeParameter
from hybrid_dynamics_core.description.geometry import rotation_about
from hybrid_dynamics_core.ground.arrays import Array
from hybrid_dynamics_core.robot.robot import Robot

NOISE = 5e-5  # [m] of each coordinate of a point
TURN = 5e-5  # [rad] of each component of an orientation
ERROR = 1e-3  # [m or rad] deviation of the parameters from the file
RANGE = 1.2  # [rad or m] of poses on each side of the reference
INSIDE = 0.1  # of the range of a joint, at either end, that poses leave out
FREE = {
    "ankle": "crank, joints.q_R.offset, legs.push_L.end[2], end_effector.xyz[0]",
    "delta": "modules.delta.parameters.arm, modules.delta.parameters.rod, joints.theta_A.offset,"
    " joints.theta_B.offset, end_effector.xyz[2]",
    "excavator": "boom, stick, bucket, joints.slew.offset, loops.boom_loop.pin.boom[0],"
    " joints.boom_cylinder.offset, loops.bucket_bars.pin.bucket[0]",
    "five_bar": "half, crank, bar, joints.q_L.offset, joints.q_R.offset",
    "forging_chu2020": "L1, L2, L3, b1, joints.q1.offset, joints.q12.offset, joints.q22.offset,"
    " loops.theta_1.pin.l2[0]",
    "gough": "modules.hexapod.parameters.base_radius, modules.hexapod.parameters.platform_radius,"
    " joints.lambda_A.offset, joints.lambda_B.offset, end_effector.xyz[2]",
    "palletizer": "out, height, L2, L3, joints.q1.offset, joints.q2.offset, joints.q3.offset",
    "staicu2015": "R1, l, L4, joints.lambda_A.offset, joints.lambda_D.offset",
    "type_c": "height, jib, fly, tail, stay, joints.q1.offset, joints.q2.offset",
    "type_d": "height, boom, reach, crank, push, joints.q1.offset, joints.q2.offset,"
    " joints.p3.offset",
}
WITH_ORIENTATION = ("staicu2015",)  # whose tool stays in place while its upper module turns
SHORT = {"staicu2015": 0.08}  # [m] range of poses where the loops would not close


@dataclass(frozen=True, eq=False)
class Measured:
    """Measurements of one machine.

    Attributes:
        nominal: the robot of the file.
        true: the machine.
        parameters: the parameters that differ.
        truth: their values (k,) [rad, m].
        columns: the data.
    """

    nominal: Robot
    true: Robot
    parameters: tuple[FreeParameter, ...]
    truth: Array
    columns: dict[str, Array]


def poses(robot: Robot, rng: np.random.Generator, count: int) -> Array:
    """Random active coordinates (count, n) [rad, m] within the limits."""
    span = SHORT.get(robot.name, RANGE)
    lower, upper = robot.limits.T
    low = np.maximum(lower, robot.reference - span)
    high = np.minimum(upper, robot.reference + span)
    margin = INSIDE * (high - low)
    shares = rng.random((count, len(low)))
    return np.asarray(low + margin + (high - low - 2.0 * margin) * shares)


def measured(name: str, rng: np.random.Generator, count: int) -> Measured:
    """Simulated measurements of a shipped robot whose parameters differ from the file."""
    adjustable = AdjustableRobot(name)
    parameters = tuple(adjustable.parameters(FREE[name].split(",")))
    start = np.array([parameter.start for parameter in parameters])
    truth = start + ERROR * rng.standard_normal(len(start))
    true = Robot(adjustable.described(parameters, truth))
    nominal = adjustable.robot
    u = poses(nominal, rng, count)
    pose = true.forward_kinematics(true.close(u))
    position = pose.position + NOISE * rng.standard_normal(pose.position.shape)
    columns = {joint: u[:, k] for k, joint in enumerate(true.active)}
    for k, axis in enumerate("xyz"):
        columns[f"tool.{axis}"] = position[:, k]
    if name in WITH_ORIENTATION:
        turned = np.stack([_turned(rotation, rng) for rotation in pose.rotation])
        for part, values in zip("xyzw", quaternion(turned).T, strict=True):
            columns[f"tool.q{part}"] = values
    return Measured(nominal, true, parameters, truth, columns)


def _turned(rotation: Array, rng: np.random.Generator) -> Array:
    """A rotation (3, 3) with the noise of an orientation."""
    vector = TURN * rng.standard_normal(3)
    angle = float(np.linalg.norm(vector))
    return np.asarray(rotation_about(vector / angle, angle) @ rotation)
