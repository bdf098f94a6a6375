"""Platforms with the geometry that a test wants, at a pose that a test wants."""

from __future__ import annotations

import numpy as np

from hybrid_dynamics_core import Robot
from tests.generated.assembly import BASE, Assembly
from tests.generated.loops import leg


def platform(
    feet: np.ndarray,
    tips: np.ndarray,
    pose: tuple[np.ndarray, np.ndarray],
    freedoms: str = "xyzabc",
) -> tuple[Robot, np.ndarray, str]:
    """A platform on legs of universal joint, cylinder and ball.

    Robot, leg extensions at the pose, platform's name.

    freedoms: slides along x, y, z and turns about three axes (a, b, c) that are at right angles at
    the pose.
    """
    rotation, centre = pose
    a = Assembly(np.random.default_rng(1), tidy=True)
    link = BASE
    for freedom in freedoms:
        kind = "prismatic" if freedom in "xyz" else "revolute"
        link = a.hang(link, kind, np.eye(3)["xyzabc".index(freedom) % 3], centre, 0.1)
    legs = [
        leg(a, BASE, link, foot, centre + rotation @ tip, "UPS")
        for foot, tip in zip(feet, tips, strict=True)
    ]
    robot = Robot(a.description(tuple(legs), link))
    return robot, np.array([a.reference[name] for name in legs]), link


def own_pose(
    robot: Robot, link: str, pose: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """The pose, reached at the reference, as the link sees it.

    Takes poses of the link to poses of the platform.
    """
    at_reference = robot.forward_kinematics(robot.close(robot.reference), frame=link)
    return at_reference.rotation.T @ pose[0], at_reference.rotation.T @ (
        pose[1] - at_reference.position
    )
