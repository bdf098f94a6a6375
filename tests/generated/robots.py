"""What the laws are tried on.

Class III robots and stacks of modules, and other ways to write the same robot.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from hypothesis import Phase
from hypothesis import strategies as st

from hybrid_dynamics_core.description import Closure, Frame, RobotDescription
from hybrid_dynamics_core.ground.arrays import frozen
from tests import sampling
from tests.generated.case import Case
from tests.generated.class_three import class_three
from tests.generated.stacks import stacks
from tests.sampling import Test

STATES = st.integers(0, 99)  # seeds of random states


def examples(number: int) -> Callable[[Test], Test]:
    """So many robots, or a sample of them.

    None is shrunk: a plan is short as it stands, and building hundreds of robots takes minutes.
    """
    return sampling.examples(number, phases=(Phase.explicit, Phase.generate))


def robots() -> st.SearchStrategy[Case]:
    """Mostly class III, and every sixth a stack of at most two modules: larger, hence slower."""
    return st.integers(0, 5).flatmap(lambda k: class_three() if k else stacks(2))


def shuffled(robot: RobotDescription, seed: int) -> RobotDescription:
    """The same robot with its links, joints, loops and closures in another order, and closures told
    the other way.
    """
    rng = np.random.default_rng(seed)

    def mixed(entries: dict) -> dict:
        return {name: entries[name] for name in rng.permutation(list(entries))}

    closures = [swapped(c) if rng.integers(2) else c for c in robot.closures]
    return replace(
        robot,
        links=mixed(robot.links),
        joints=mixed(robot.joints),
        loops=mixed(robot.loops),
        closures=tuple(closures[k] for k in rng.permutation(len(closures))),
    )


def swapped(c: Closure) -> Closure:
    """A closure told from its other end."""
    return replace(
        c,
        link_a=c.link_b,
        point_a=c.point_b,
        rotation_a=c.rotation_b,
        link_b=c.link_a,
        point_b=c.point_a,
        rotation_b=c.rotation_a,
    )


def moved(robot: RobotDescription, rotation: np.ndarray, offset: np.ndarray) -> RobotDescription:
    """The robot mounted elsewhere on the world, gravity turned with it."""
    joints = {
        name: (
            replace(
                j,
                rotation=frozen(rotation @ j.rotation),
                translation=frozen(rotation @ j.translation + offset),
            )
            if j.parent == robot.base
            else j
        )
        for name, j in robot.joints.items()
    }
    closures = []
    for c in robot.closures:
        for end in "ab":
            if getattr(c, f"link_{end}") == robot.base:
                point, turned = getattr(c, f"point_{end}"), getattr(c, f"rotation_{end}")
                c = replace(  # noqa: PLW2901
                    c,
                    **{
                        f"point_{end}": frozen(rotation @ point + offset),
                        f"rotation_{end}": frozen(rotation @ turned),
                    },
                )
        closures.append(c)
    return replace(
        robot, joints=joints, closures=tuple(closures), gravity=frozen(rotation @ robot.gravity)
    )


def scaled(robot: RobotDescription, factor: float) -> RobotDescription:
    """The robot with every length multiplied."""
    strokes = {name for name, j in robot.joints.items() if j.type == "prismatic"}
    return replace(
        robot,
        joints={
            n: replace(j, translation=frozen(factor * j.translation))
            for n, j in robot.joints.items()
        },
        closures=tuple(
            replace(c, point_a=frozen(factor * c.point_a), point_b=frozen(factor * c.point_b))
            for c in robot.closures
        ),
        frames={
            n: Frame(f.link, f.rotation, frozen(factor * f.translation))
            for n, f in robot.frames.items()
        },
        reference={n: factor * v if n in strokes else v for n, v in robot.reference.items()},
    )


def as_text(robot: RobotDescription) -> str:
    """The robot as a description file."""
    lines = ["format: 1", f"name: {robot.name}", f"gravity: {_list(robot.gravity)}", "links:"]
    for link in robot.links.values():
        i = link.inertia
        parts = (
            ("xx", i[0, 0]),
            ("yy", i[1, 1]),
            ("zz", i[2, 2]),
            ("xy", i[0, 1]),
            ("xz", i[0, 2]),
            ("yz", i[1, 2]),
        )
        inertia = ", ".join(f"{key}: {float(value)!r}" for key, value in parts)
        body = (
            f"mass: {link.mass!r}, com: {_list(link.com)}, inertia: {{{inertia}}}"
            if link.mass
            else ""
        )
        lines.append(f"  {link.name}: {{{body}}}")
    lines.append("joints:")
    lines += [
        f"  {j.name}: {{type: {j.type}, parent: {j.parent}, child: {j.child}, axis:"
        f" {_list(j.axis)}, origin: {{xyz: {_list(j.translation)}, rpy:"
        f" {_list(_rpy(j.rotation))}}}}}"
        for j in robot.joints.values()
    ]
    for section, tied in (("loops", True), ("closures", False)):
        entries = [_closure(robot, c) for c in robot.closures if (c.name in robot.loops) == tied]
        lines += [f"{section}:", *entries] if entries else []
    tool = robot.frames["end_effector"]
    place = f"xyz: {_list(tool.translation)}, rpy: {_list(_rpy(tool.rotation))}"
    reference = ", ".join(f"{name}: {value!r}" for name, value in robot.reference.items())
    lines += [
        f"active: [{', '.join(robot.active)}]",
        f"end_effector: {{link: {tool.link}, {place}}}",
        f"reference: {{{reference}}}",
    ]
    return "\n".join(lines) + "\n"


def _closure(robot: RobotDescription, c: Closure) -> str:
    assembly = f", assembly: {c.assembly}" if c.assembly else ""
    if c.name in robot.loops:
        loop = robot.loops[c.name]
        pin = f"{c.link_a}: {_list(c.point_a)}, {c.link_b}: {_list(c.point_b)}"
        return (
            f"  {c.name}: {{type: {loop.type}, base: {loop.base}, arm: {loop.arm}, k1: {loop.k1},"
            f" k2: {loop.k2}, pin: {{{pin}}}{assembly}}}"
        )
    ends = ", ".join(
        f"{link}: {{xyz: {_list(point)}, rpy: {_list(_rpy(rotation))}}}"
        for link, point, rotation in (
            (c.link_a, c.point_a, c.rotation_a),
            (c.link_b, c.point_b, c.rotation_b),
        )
    )
    return f"  {c.name}: {{kind: {c.kind}, between: {{{ends}}}{assembly}}}"


def _rpy(r: np.ndarray) -> list[float]:
    """Roll, pitch, yaw of a rotation Rz Ry Rx.

    At pitch +-90 degrees, where roll and yaw act alike, all as yaw.
    """
    flat = float(np.hypot(r[0, 0], r[1, 0]))
    if flat < 1e-9:
        return [0.0, float(np.arctan2(-r[2, 0], flat)), float(np.arctan2(-r[0, 1], r[1, 1]))]
    return [
        float(np.arctan2(r[2, 1], r[2, 2])),
        float(np.arctan2(-r[2, 0], flat)),
        float(np.arctan2(r[1, 0], r[0, 0])),
    ]


def _list(values: np.ndarray | list[float]) -> str:
    return "[" + ", ".join(repr(float(v)) for v in values) + "]"
