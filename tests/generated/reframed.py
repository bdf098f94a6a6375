"""A robot in other words: other origins and axes of its frames, other zeros of its joints."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hybrid_dynamics_core.algebra.rotations import rotation_matrix
from hybrid_dynamics_core.description.model import Closure, Frame, Joint, Link, RobotDescription
from hybrid_dynamics_core.ground.arrays import frozen
from tests.generated.assembly import turn as turn_about


class Move(NamedTuple):
    """Where a new frame of a link stands in its old one."""

    rotation: np.ndarray
    translation: np.ndarray

    def point(self, old: np.ndarray) -> np.ndarray:
        """A point in the new frame."""
        return frozen(self.rotation.T @ (old - self.translation))

    def turned(self, old: np.ndarray) -> np.ndarray:
        """A vector, or the columns of a rotation, in the new frame."""
        return frozen(self.rotation.T @ old)


def reframed(
    robot: RobotDescription, seed: int, farthest: float = 0.5
) -> tuple[RobotDescription, dict[str, float]]:
    """The robot with every frame and every zero chosen anew.

    Args:
        robot: its description.
        seed: of all choices.
        farthest: a new zero is from the old one [rad or m].

    Returns:
        The robot, and by joint the old coordinate at the new zero [rad or m].
    """
    rng = np.random.default_rng(seed)
    moves = {robot.base: Move(random_rotation(rng), rng.normal(size=3))}
    for joint in robot.joints.values():
        moves[joint.child] = _child_move(joint, rng)
    zeros = {name: float(rng.uniform(-farthest, farthest)) for name in robot.joints}
    return _in_words(robot, moves, zeros), zeros


def with_zeros(robot: RobotDescription, zeros: dict[str, float]) -> RobotDescription:
    """The robot with other zeros, its frames as they are at the new ones.

    Args:
        robot: the robot.
        zeros: by joint the old coordinate at the new zero [rad or m].
    """
    still = Move(np.eye(3), np.zeros(3))
    return _in_words(robot, dict.fromkeys([robot.base, *robot.links], still), zeros)


def _in_words(
    robot: RobotDescription, moves: dict[str, Move], zeros: dict[str, float]
) -> RobotDescription:
    """The robot with its frames moved, and other zeros."""
    joints = {}
    for name, joint in robot.joints.items():
        joints[name] = _joint(joint, moves, zeros[name])
    frames = {}
    for name, frame in robot.frames.items():
        move = moves[frame.link]
        origin = move.point(frame.translation)
        frames[name] = Frame(frame.link, move.turned(frame.rotation), origin)
    mimics = {}
    for name, mimic in robot.mimics.items():
        offset = mimic.offset - zeros[name]
        for source, multiplier in mimic.multipliers.items():
            offset += multiplier * zeros[source]
        mimics[name] = replace(mimic, offset=offset)
    effects = {}
    for name, effect in robot.effects.items():
        effects[name] = replace(effect, rest=effect.rest - zeros[name])
    return replace(
        robot,
        gravity=moves[robot.base].turned(robot.gravity),
        links={name: _link(link, moves[name]) for name, link in robot.links.items()},
        joints=joints,
        closures=tuple(_closure(closure, moves) for closure in robot.closures),
        frames=frames,
        reference={name: value - zeros[name] for name, value in robot.reference.items()},
        mimics=mimics,
        effects=effects,
    )


def random_rotation(rng: np.random.Generator) -> np.ndarray:
    """Any rotation, all equally likely."""
    quaternion = rng.normal(size=4)
    return rotation_matrix(quaternion / np.linalg.norm(quaternion))


def _child_move(joint: Joint, rng: np.random.Generator) -> Move:
    """A new frame of a joint's child: of a hinge its origin stays on the axis."""
    origin = rng.normal(size=3)
    if joint.type == "revolute":
        origin = float(rng.normal()) * joint.axis
    return Move(random_rotation(rng), origin)


def _joint(joint: Joint, moves: dict[str, Move], zero: float) -> Joint:
    parent, child = moves[joint.parent], moves[joint.child]
    turn, slide = np.eye(3), zero * joint.axis
    if joint.type == "revolute":
        turn, slide = turn_about(joint.axis, zero), np.zeros(3)
    rotation = joint.rotation @ turn
    origin = joint.translation + joint.rotation @ slide + rotation @ child.translation
    lower, upper = joint.limits
    return replace(
        joint,
        rotation=frozen(parent.rotation.T @ rotation @ child.rotation),
        translation=parent.point(origin),
        axis=child.turned(joint.axis),
        limits=(lower - zero, upper - zero),
    )


def _link(link: Link, move: Move) -> Link:
    inertia = frozen(move.rotation.T @ link.inertia @ move.rotation)
    return replace(link, com=move.point(link.com), inertia=inertia)


def _closure(closure: Closure, moves: dict[str, Move]) -> Closure:
    a, b = moves[closure.link_a], moves[closure.link_b]
    place = place_of(closure, moves)
    return replace(
        closure,
        point_a=a.point(closure.point_a + closure.rotation_a @ place),
        rotation_a=a.turned(closure.rotation_a),
        point_b=b.point(closure.point_b + closure.rotation_b @ place),
        rotation_b=b.turned(closure.rotation_b),
    )


def place_of(closure: Closure, moves: dict[str, Move]) -> np.ndarray:
    """A place of the same joint in the closure's frame: along a hinge, anywhere on a weld."""
    place = moves[closure.link_a].translation
    if closure.kind == "axis":
        return place * np.array([0.0, 0.0, 1.0])
    if closure.kind == "frame":
        return place
    return np.zeros(3)
