"""Robots put together in space, at a random configuration.

Joints stand where the configuration has them, so every loop closes.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from hybrid_dynamics_core.description import Closure, Frame, Joint, Link, Loop, RobotDescription
from hybrid_dynamics_core.ground.arrays import frozen

Pose = tuple[np.ndarray, np.ndarray]  # rotation (3, 3), origin (3,)
BASE = "base"
Z = np.array([0.0, 0.0, 1.0])


def unit(v: np.ndarray) -> np.ndarray:
    """The unit vector along v."""
    return v / np.linalg.norm(v)


def skew(v: np.ndarray) -> np.ndarray:
    """The matrix (3, 3) whose product with w is v x w."""
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def turn(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rotation about a unit axis."""
    across = skew(axis)
    return np.eye(3) + np.sin(angle) * across + (1.0 - np.cos(angle)) * across @ across


def frame_with_normal(normal: np.ndarray, rng: np.random.Generator | None) -> np.ndarray:
    """A rotation whose third column is the normal.

    Turned at random about it if a generator is given.
    """
    flattest = int(np.argmin(np.abs(normal)))
    first = unit(np.cross(normal, np.eye(3)[flattest]))
    frame = np.column_stack([first, np.cross(normal, first), normal])
    if rng is None:
        return frame
    return frame @ turn(Z, rng.uniform(-np.pi, np.pi))


@dataclass
class Assembly:
    """Links at their poses in the base frame, and joints between them with their values there.

    tidy: link frames and directions along the axes of the base, as people write robots; otherwise
    all tilted.
    """

    rng: np.random.Generator
    tidy: bool = False
    poses: dict[str, Pose] = field(default_factory=lambda: {BASE: (np.eye(3), np.zeros(3))})
    joints: dict[str, Joint] = field(default_factory=dict)
    reference: dict[str, float] = field(default_factory=dict)
    axes: dict[str, np.ndarray] = field(default_factory=dict)  # in the base frame, by joint
    closures: list[Closure] = field(default_factory=list)
    loops: dict[str, Loop] = field(default_factory=dict)
    massless: set[str] = field(default_factory=set)
    rank: int = 0  # independent equations, as counted by whoever closes the loops
    preferred: list[str] = field(default_factory=list)  # joints that may be active; all if empty
    number: int = 0
    links: dict[str, Link] = field(default_factory=dict)

    @property
    def tilting(self) -> np.random.Generator | None:
        """What frames are turned with; none where they are tidy."""
        return None if self.tidy else self.rng

    def fresh(self, prefix: str) -> str:
        """A name not used yet."""
        self.number += 1
        return f"{prefix}{self.number}"

    def direction(self) -> np.ndarray:
        """A direction of space."""
        if self.tidy:
            return np.eye(3)[self.rng.integers(3)] * self.rng.choice([-1.0, 1.0])
        return unit(self.rng.normal(size=3))

    def across(self, axis: np.ndarray) -> np.ndarray:
        """A direction at right angles to an axis."""
        frame = frame_with_normal(axis, self.tilting)
        return frame[:, int(self.rng.integers(2))]

    def hang(
        self,
        parent: str,
        kind: str,
        axis: np.ndarray,
        point: np.ndarray,
        value: float | None = None,
        name: str = "",
    ) -> str:
        """Hang a new link on a joint whose axis passes through the point.

        Returns the link's name.
        """
        child = name or self.fresh("l")
        rng = self.rng
        along = rng.normal() * 0.1
        if self.tidy:
            rotation = frame_with_normal(axis, None)[:, rng.permutation(3)]
            rotation[:, 0] *= np.sign(np.linalg.det(rotation))
        else:
            rotation = turn(unit(rng.normal(size=3)), rng.uniform(-3, 3))
        if kind == "revolute":
            origin = point + along * axis
            reach = 1.0
        else:
            origin = point + rng.normal(size=3) * 0.1
            reach = 0.2
        self.poses[child] = (rotation, origin)
        if value is None:
            value = float(rng.uniform(-reach, reach))
        axis_in_child = rotation.T @ axis
        back_rotation = np.eye(3)
        back_origin = np.zeros(3)
        if kind == "revolute":
            back_rotation = turn(axis_in_child, -value)
        else:
            back_origin = -value * axis_in_child
        in_parent, place = self.local_pose(parent, rotation, origin)
        joint = f"q_{child}"
        self.joints[joint] = Joint(
            joint,
            kind,
            parent,
            child,
            frozen(in_parent @ back_rotation),
            frozen(place + in_parent @ back_origin),
            frozen(axis_in_child),
        )
        self.reference[joint] = value
        self.axes[joint] = axis
        return child

    def joint_of(self, link: str) -> Joint:
        """The joint that carries a link."""
        return self.joints[f"q_{link}"]

    def local_pose(self, link: str, rotation: np.ndarray, point: np.ndarray) -> Pose:
        """A pose of the base frame in a link's frame."""
        r, p = self.poses[link]
        return r.T @ rotation, r.T @ (point - p)

    def local(self, link: str, point: np.ndarray) -> np.ndarray:
        """A point of the base frame in a link's frame."""
        return self.local_pose(link, np.eye(3), point)[1]

    def tie(
        self,
        a: str,
        b: str,
        point: np.ndarray,
        kind: str = "planar",
        axis: np.ndarray | None = None,
        name: str = "",
        assembly: str | None = None,
    ) -> str:
        """Close a loop: what lies at the point on both links stays together."""
        name = name or self.fresh("c")
        if axis is None:
            frame = turn(self.direction(), 0.0 if self.tidy else 0.7)
        else:
            frame = frame_with_normal(axis, self.rng)
        (ra, pa), (rb, pb) = (self.local_pose(link, frame, point) for link in (a, b))
        if kind == "axis":
            rb = rb @ turn(Z, 1.0)  # only the z axes need to agree
        elif kind in ("planar", "point"):
            ra, rb = np.eye(3), np.eye(3)
        ends = {
            "point_a": frozen(pa),
            "point_b": frozen(pb),
            "rotation_a": frozen(ra),
            "rotation_b": frozen(rb),
        }
        closure = Closure(name, link_a=a, link_b=b, kind=kind, assembly=assembly, **ends)
        self.closures.append(closure)
        return name

    def link(self, name: str) -> Link:
        """The link, with random mass properties that a body can have."""
        if name in self.links:
            return self.links[name]
        rng = self.rng
        axes = turn(unit(rng.normal(size=3)), 1.0)
        variances = rng.uniform(0.01, 0.1, size=3)
        inertia = axes @ np.diag(variances.sum() - variances) @ axes.T
        mass = float(rng.uniform(0.5, 3.0))
        link = Link(name)
        if name not in self.massless:
            link = Link(name, mass, frozen(0.2 * rng.normal(size=3)), frozen(inertia))
        return self.links.setdefault(name, link)

    def description(
        self, active: tuple[str, ...], end_effector: str, name: str = "generated"
    ) -> RobotDescription:
        """The robot; its reference names every joint."""
        links = {link: self.link(link) for link in self.poses if link != BASE}
        tool = Frame(
            end_effector,
            frozen(turn(unit(self.rng.normal(size=3)), 0.5)),
            frozen(self.rng.normal(size=3)),
        )
        down = np.array([0.0, 0.0, -1.0]) if self.tidy else unit(self.rng.normal(size=3))
        return RobotDescription(
            name=name,
            source="generated",
            gravity=frozen(9.81 * down),
            base=BASE,
            links=links,
            joints=dict(self.joints),
            closures=tuple(self.closures),
            loops=dict(self.loops),
            active=active,
            end_effector="end_effector",
            frames={"end_effector": tool},
            reference=dict(self.reference),
        )
