"""Staicu (2015): the leg variables from the platforms' poses, as they are written by hand.

A leg is a vector from its joint below to its joint above. Its length and two angles follow from the
three components. Angles and lengths count from the central configuration.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from hybrid_dynamics_core.description import RobotDescription
from hybrid_dynamics_core.description.model import Joint

ANGLES = {"A": 0.0, "B": 2 * math.pi / 3, "C": -2 * math.pi / 3}  # of the base joints
ANGLES |= {"D": 0.0, "E": 2 * math.pi / 3, "F": -2 * math.pi / 3}  # printed: alpha_E = -alpha_E
BASE, LOWER = 0.6, 0.2  # R1, r1: radii of the lower module [m]
UPPER = 0.75 / math.sqrt(3.0)  # R2 = r2 = l / sqrt 3 [m]
HEIGHT = 0.8  # h1 [m]
NU_1, NU_2 = math.pi / 6.0, math.pi / 3.0  # twists of the platforms [rad]
L40 = 1.5  # l4 + l6, legs D to F in the central configuration [m]
H2 = math.sqrt(L40**2 - UPPER**2)  # [m]
DELTA_2 = -math.pi / 3.0


class Leg(NamedTuple):
    """Length [m] and angles [rad] of a leg, not yet from the central configuration."""

    length: float
    phi10: float
    phi21: float


def direction(angle: float) -> np.ndarray:
    """e(angle): the horizontal unit vector."""
    return np.array([math.cos(angle), math.sin(angle), 0.0])


def lower_leg(leg: str, place: np.ndarray) -> Leg:
    """A leg of the lower module, with its platform at G = place (3,) [m].

    L sin phi10 cos phi21 is the tangential part, -L cos phi10 cos phi21 the radial one, and
    L sin phi21 the height. The second is the line of (9) that prints sin for a cos.
    """
    angle = ANGLES[leg]
    vector = place + LOWER * direction(angle + NU_1) - BASE * direction(angle)
    radial = direction(angle) @ vector
    tangential = direction(angle + math.pi / 2.0) @ vector
    length = float(np.linalg.norm(vector))
    return Leg(length, math.atan2(tangential, -radial), math.asin(vector[2] / length))


def upper_leg(leg: str, rotation: np.ndarray) -> Leg:
    """A leg of the upper module, with its platform turned by a rotation (3, 3).

    L cos phi21 = -e(alpha + delta_2) . v, L sin phi10 sin phi21 = -e(alpha + delta_2 + pi/2) . v,
    L cos phi10 sin phi21 = v_z, in the frame of the lower platform.
    """
    angle = ANGLES[leg]
    above = rotation @ (UPPER * direction(angle + NU_2))
    vector = np.array([0.0, 0.0, H2]) + above - UPPER * direction(angle)
    along = -direction(angle + DELTA_2) @ vector
    across = -direction(angle + DELTA_2 + math.pi / 2.0) @ vector
    length = float(np.linalg.norm(vector))
    phi10 = math.atan2(across, vector[2])
    return Leg(length, phi10, math.atan2(math.hypot(across, vector[2]), along))


def rotation_of(alpha_1: float, alpha_2: float, alpha_3: float) -> np.ndarray:
    """Rx(alpha_1) Ry(alpha_2) Rz(alpha_3)."""
    c, s = np.cos([alpha_1, alpha_2, alpha_3]), np.sin([alpha_1, alpha_2, alpha_3])
    about_x = np.array([[1, 0, 0], [0, c[0], -s[0]], [0, s[0], c[0]]])
    about_y = np.array([[c[1], 0, s[1]], [0, 1, 0], [-s[1], 0, c[1]]])
    about_z = np.array([[c[2], -s[2], 0], [s[2], c[2], 0], [0, 0, 1]])
    return about_x @ about_y @ about_z


def leg_variables(pose: Mapping[str, float]) -> dict[str, float]:
    """All 18 leg variables from x, y, z (from h1) [m] and alpha_1 to alpha_3 [rad]."""
    place = np.array([pose["x"], pose["y"], HEIGHT + pose["z"]])
    rotation = rotation_of(pose["alpha_1"], pose["alpha_2"], pose["alpha_3"])
    variables = {}
    for leg in "ABCDEF":
        if leg in "ABC":
            now = lower_leg(leg, place)
            central = lower_leg(leg, np.array([0.0, 0.0, HEIGHT]))
        else:
            now = upper_leg(leg, rotation)
            central = upper_leg(leg, np.eye(3))
        variables[f"lambda_{leg}"] = now.length - central.length
        variables[f"phi10_{leg}"] = now.phi10 - central.phi10
        variables[f"phi21_{leg}"] = now.phi21 - central.phi21
    return variables


def graph(robot: RobotDescription) -> list[str]:
    """The graph of the mechanism, a line a chain of bodies: joints between them, a tie at the end.

    Chains run from the base or a platform to a platform, or to a body that carries no other.
    """
    joints = {joint.child: joint for joint in robot.joints.values()}
    ties = {tie.link_a: tie.link_b for tie in robot.closures}
    stations = {robot.base, *ties.values()}
    carrying = {joint.parent for joint in joints.values()}
    lines = []
    for body in joints:
        if body in carrying and body not in stations:
            continue
        chain = chain_to(body, joints, stations)
        if body in ties:
            chain += ["=ball=", ties[body]]
        lines.append(" ".join(chain))
    return lines


def chain_to(body: str, joints: Mapping[str, Joint], stations: set[str]) -> list[str]:
    """Bodies and joints from the station before a body to the body."""
    chain = [body]
    at_start = False
    while not at_start:
        joint = joints[chain[0]]
        chain = [joint.parent, f"-{joint.name}-", *chain]
        at_start = joint.parent in stations
    return chain
