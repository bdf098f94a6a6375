"""Random spatial linkages with rods between two balls, which can spin about themselves."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from hypothesis import strategies as st

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.description import Closure, Frame, Joint, Link, RobotDescription
from hybrid_dynamics_core.ground.arrays import frozen
from tests.generated.robots import moved
from tests.mechanisms import random_link

TINY = 1e-8  # share of a rod's own inertia that it is given about its axis


def random_rotation(rng: np.random.Generator) -> np.ndarray:
    """A rotation matrix (3, 3)."""
    matrix, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return matrix * np.linalg.det(matrix)


class Spinning(NamedTuple):
    """A crank that moves rockers by rods between balls, and perhaps a pendulum that nobody drives.

    Attributes:
        seed: of all lengths, axes and masses.
        rods: their number: each turns the next rocker, and can spin.
        pendulum: whether the last rocker carries one.
    """

    seed: int
    rods: int
    pendulum: bool

    def description(self, spin_inertia: float = 0.0) -> RobotDescription:
        """The mechanism, closed with all joints at zero, all frames along the base's there.

        Args:
            spin_inertia: share of a rod's inertia that it has about its axis too.
        """
        maker = _Maker(self.seed, spin_inertia)
        place = maker.rng.uniform(-0.3, 0.3, 3)
        maker.add("a", "base", "crank", place, random_link("crank", maker.rng))
        carrier, origin = "crank", place
        for k in range(self.rods):
            carrier, origin = maker.add_rod(k, carrier, origin)
        if self.pendulum:
            link = random_link("pole", maker.rng)
            maker.add("q", carrier, "pole", origin + maker.rng.uniform(-0.2, 0.2, 3), link)
        return maker.description()

    def robot(self, spin_inertia: float = 0.0) -> Robot:
        """The library's robot."""
        return Robot(self.description(spin_inertia))

    @property
    def spins(self) -> set[str]:
        """Joints of the rods."""
        return {f"{letter}{k}" for letter in "uvw" for k in range(self.rods)}


class _Maker:
    def __init__(self, seed: int, spin_inertia: float) -> None:
        self.rng = np.random.default_rng(seed)
        self.spin_inertia = spin_inertia
        self.places: dict[str, np.ndarray] = {"base": np.zeros(3)}
        self.joints: dict[str, Joint] = {}
        self.links: dict[str, Link] = {}
        self.closures: list[Closure] = []

    def add(
        self,
        name: str,
        parent: str,
        child: str,
        place: np.ndarray,
        link: Link,
        axis: np.ndarray | None = None,
    ) -> None:
        """Add a hinge at a place in the base frame (3,), its axis random if None."""
        if axis is None:
            axis = random_rotation(self.rng)[0]
        offset = frozen(place - self.places[parent])
        joint = Joint(name, "revolute", parent, child, frozen(np.eye(3)), offset, frozen(axis))
        self.joints[name] = joint
        self.links[child] = link
        self.places[child] = place

    def add_rod(self, k: int, carrier: str, origin: np.ndarray) -> tuple[str, np.ndarray]:
        """Add a rod from a link to a new rocker; the rocker and its place."""
        rng = self.rng
        start = origin + 0.15 * random_rotation(rng)[0]
        along = random_rotation(rng)[0]
        length = rng.uniform(0.4, 0.7)
        end = start + length * along
        mass = rng.uniform(0.5, 2.0)
        flat = np.eye(3) - np.outer(along, along)
        inertia = mass * length**2 / 12.0 * (flat + self.spin_inertia * np.outer(along, along))
        rod = Link(f"rod{k}", mass, frozen(0.5 * length * along), frozen(inertia))
        axes = random_rotation(rng)
        self.add(f"u{k}", carrier, f"s{k}", start, Link(f"s{k}"), axes[0])
        self.add(f"v{k}", f"s{k}", f"t{k}", start, Link(f"t{k}"), axes[1])
        self.add(f"w{k}", f"t{k}", f"rod{k}", start, rod, axes[2])
        place = end + 0.3 * random_rotation(rng)[0]
        rocker = f"rocker{k}"
        self.add(f"c{k}", "base", rocker, place, random_link(rocker, rng))
        ball = Closure(
            f"ball{k}", rod.name, frozen(end - start), rocker, frozen(end - place), "point"
        )
        self.closures.append(ball)
        return rocker, place

    def description(self) -> RobotDescription:
        last = list(self.links)[-1]
        return RobotDescription(
            name="spinning",
            source="generated",
            gravity=frozen([0.3, -0.5, -9.7]),
            base="base",
            links=self.links,
            joints=self.joints,
            closures=tuple(self.closures),
            loops={},
            active=("a",),
            end_effector="end_effector",
            frames={"end_effector": Frame(last)},
            reference=dict.fromkeys(self.joints, 0.0),
            active_set="motors",
        )


def spinning() -> st.SearchStrategy[Spinning]:
    """One or two rods, with and without a pendulum."""
    return st.builds(Spinning, st.integers(0, 10_000), st.integers(1, 2), st.booleans())


def reframed(robot: RobotDescription, seed: int) -> RobotDescription:
    """The same robot with other frames on its links: turned, and moved along the joints' axes.

    The frame of a link that slides may lie anywhere.
    """
    rng = np.random.default_rng(seed)
    frames: dict[str, tuple[np.ndarray, np.ndarray]] = {robot.base: (np.eye(3), np.zeros(3))}
    for joint in robot.joints.values():
        offset = rng.normal() * joint.axis
        if joint.type == "prismatic":
            offset = rng.normal(size=3)
        frames[joint.child] = (random_rotation(rng), offset)
    joints: dict[str, Joint] = {}
    for name, joint in robot.joints.items():
        turn, offset = frames[joint.child]
        parent_turn, parent_offset = frames[joint.parent]
        place = joint.translation + joint.rotation @ offset - parent_offset
        joints[name] = replace(
            joint,
            rotation=frozen(parent_turn.T @ joint.rotation @ turn),
            translation=frozen(parent_turn.T @ place),
            axis=frozen(turn.T @ joint.axis),
        )
    links: dict[str, Link] = {}
    for name, link in robot.links.items():
        turn, offset = frames[name]
        com = frozen(turn.T @ (link.com - offset))
        links[name] = replace(link, com=com, inertia=frozen(turn.T @ link.inertia @ turn))
    return replace(
        robot,
        joints=joints,
        links=links,
        closures=tuple(_reframed_closure(closure, frames) for closure in robot.closures),
        frames={name: _reframed_frame(frame, frames) for name, frame in robot.frames.items()},
    )


def _reframed_closure(
    closure: Closure, frames: dict[str, tuple[np.ndarray, np.ndarray]]
) -> Closure:
    a, b = (_reframed_frame(frame, frames) for frame in closure.frames())
    return replace(
        closure,
        point_a=a.translation,
        rotation_a=a.rotation,
        point_b=b.translation,
        rotation_b=b.rotation,
    )


def _reframed_frame(frame: Frame, frames: dict[str, tuple[np.ndarray, np.ndarray]]) -> Frame:
    turn, offset = frames[frame.link]
    rotation = frozen(turn.T @ frame.rotation)
    return Frame(frame.link, rotation, frozen(turn.T @ (frame.translation - offset)))


def far_away(robot: RobotDescription, seed: int, distance: float) -> RobotDescription:
    """The robot with its base turned and put far away [m]."""
    rng = np.random.default_rng(seed)
    return moved(robot, random_rotation(rng), distance * random_rotation(rng)[0])
