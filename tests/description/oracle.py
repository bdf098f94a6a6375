"""Poses and closed loops from a description alone: chains of 4 x 4 matrices, Newton's method."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from hybrid_dynamics_core.description import Closure, RobotDescription

STEP = 1e-7


def turn(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rotation about a unit axis."""
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * skew + (1.0 - np.cos(angle)) * skew @ skew


def matrix(rotation: np.ndarray, translation: np.ndarray) -> np.ndarray:
    """A pose as a 4 x 4 matrix."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, translation
    return pose


def link_pose(robot: RobotDescription, link: str, s: Mapping[str, float]) -> np.ndarray:
    """4 x 4 pose of a link at joint values s (0 where absent)."""
    if link == robot.base:
        return np.eye(4)
    joint = next(j for j in robot.joints.values() if j.child == link)
    q, still = s.get(joint.name, 0.0), np.zeros(3)
    moved = (
        matrix(turn(joint.axis, q), still)
        if joint.type == "revolute"
        else matrix(np.eye(3), joint.axis * q)
    )
    return link_pose(robot, joint.parent, s) @ matrix(joint.rotation, joint.translation) @ moved


def frame_pose(robot: RobotDescription, name: str, s: Mapping[str, float]) -> np.ndarray:
    """4 x 4 pose of a frame, or of a link that has no frame of its name."""
    if name not in robot.frames:
        return link_pose(robot, name, s)
    frame = robot.frames[name]
    return link_pose(robot, frame.link, s) @ matrix(frame.rotation, frame.translation)


def gap(robot: RobotDescription, closure: Closure, s: Mapping[str, float]) -> np.ndarray:
    """What a closure lacks: (3,) [m] for points, (6,) with z axes, (12,) with whole frames."""
    a = link_pose(robot, closure.link_a, s) @ matrix(closure.rotation_a, closure.point_a)
    b = link_pose(robot, closure.link_b, s) @ matrix(closure.rotation_b, closure.point_b)
    columns = {"planar": [3], "point": [3], "axis": [3, 2], "frame": [3, 0, 1, 2]}[closure.kind]
    return np.concatenate([(a - b)[:3, k] for k in columns])


def gaps(robot: RobotDescription, s: Mapping[str, float]) -> np.ndarray:
    """All closures."""
    return np.concatenate([gap(robot, closure, s) for closure in robot.closures])


def jacobian(robot: RobotDescription, s: Mapping[str, float], names: Iterable[str]) -> np.ndarray:
    """Central differences of the gaps."""
    columns = [
        (gaps(robot, {**s, n: s.get(n, 0.0) + STEP}) - gaps(robot, {**s, n: s.get(n, 0.0) - STEP}))
        / (2 * STEP)
        for n in names
    ]
    return np.array(columns).T


def close(
    robot: RobotDescription, given: Mapping[str, float], near: Mapping[str, float]
) -> dict[str, float]:
    """Values of all joints that close every loop with the given ones, by Newton's method."""
    unknown = [name for name in robot.joints if name not in given]
    s = {**{name: near.get(name, 0.0) for name in unknown}, **given}
    for _ in range(100):
        miss = gaps(robot, s)
        if np.abs(miss).max() < 1e-13:
            break
        step = np.linalg.lstsq(jacobian(robot, s, unknown), -miss, rcond=1e-8)[0]
        step *= min(1.0, 0.3 / max(np.abs(step).max(), 1e-300))
        s.update({name: s[name] + float(d) for name, d in zip(unknown, step, strict=True)})
    return s


def rank(robot: RobotDescription, s: Mapping[str, float], names: Iterable[str]) -> int:
    """Rank of the gaps' Jacobian for some joints."""
    return int(np.linalg.matrix_rank(jacobian(robot, s, names), tol=1e-6))


def freedom(robot: RobotDescription, s: Mapping[str, float]) -> int:
    """Degrees of freedom at a closed configuration."""
    return len(robot.joints) - (rank(robot, s, list(robot.joints)) if robot.closures else 0)


def mass_matrix(robot: RobotDescription, s: dict[str, float], names: list[str]) -> np.ndarray:
    """From the kinetic energy of every link, with central differences of its pose."""
    h, total = 1e-6, np.zeros((len(names), len(names)))
    for link in robot.links.values():
        if link.name == robot.base:
            continue
        linear, angular = [], []
        turn = frame_pose(robot, link.name, s)[:3, :3]
        for name in names:
            a, b = (frame_pose(robot, link.name, {**s, name: s[name] + d}) for d in (h, -h))
            linear.append((a @ [*link.com, 1] - b @ [*link.com, 1])[:3] / (2 * h))
            rate = turn.T @ (a - b)[:3, :3] / (2 * h)
            angular.append([rate[2, 1], rate[0, 2], rate[1, 0]])
        jv, jw = np.array(linear).T, np.array(angular).T
        total += link.mass * jv.T @ jv + jw.T @ link.inertia @ jw
    return total
