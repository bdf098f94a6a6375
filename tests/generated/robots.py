"""What the laws are tried on.

Class III robots and stacks of modules, and other ways to write the same robot.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from hypothesis import Phase
from hypothesis import strategies as st

from hybrid_dynamics_core.description import Closure, Frame, Joint, Link, RobotDescription
from hybrid_dynamics_core.ground.arrays import frozen
from tests import sampling
from tests.generated.case import Case
from tests.generated.class_three import class_three
from tests.generated.stacks import stacks
from tests.sampling import Test

STATES = st.integers(0, 99)  # seeds of random states
# entries of an inertia matrix by their keys in a file
ENTRIES = {
    "xx": (0, 0),
    "yy": (1, 1),
    "zz": (2, 2),
    "xy": (0, 1),
    "xz": (0, 2),
    "yz": (1, 2),
}


def examples(number: int) -> Callable[[Test], Test]:
    """So many robots, or a sample of them.

    None is shrunk: a plan is short as it stands, and building hundreds of robots takes minutes.
    """
    return sampling.examples(number, phases=(Phase.explicit, Phase.generate))


def robots() -> st.SearchStrategy[Case]:
    """Mostly class III, and every sixth a stack of at most two modules: larger, hence slower."""
    return st.integers(0, 5).flatmap(lambda k: class_three() if k else stacks(2))


def shuffled(robot: RobotDescription, seed: int) -> RobotDescription:
    """The same robot with its entries in another order, and closures from their other ends."""
    rng = np.random.default_rng(seed)

    def mixed(entries: dict) -> dict:
        return {str(name): entries[name] for name in rng.permutation(list(entries))}

    closures = [swapped(closure) if rng.integers(2) else closure for closure in robot.closures]
    return replace(
        robot,
        links=mixed(robot.links),
        joints=mixed(robot.joints),
        loops=mixed(robot.loops),
        closures=tuple(closures[k] for k in rng.permutation(len(closures))),
    )


def swapped(closure: Closure) -> Closure:
    """A closure from its other end."""
    return replace(
        closure,
        link_a=closure.link_b,
        point_a=closure.point_b,
        rotation_a=closure.rotation_b,
        link_b=closure.link_a,
        point_b=closure.point_a,
        rotation_b=closure.rotation_a,
    )


def moved(robot: RobotDescription, rotation: np.ndarray, offset: np.ndarray) -> RobotDescription:
    """The robot mounted elsewhere on the world, gravity turned with it."""
    joints = dict(robot.joints)
    for name, joint in robot.joints.items():
        if joint.parent == robot.base:
            turned = frozen(rotation @ joint.rotation)
            translation = frozen(rotation @ joint.translation + offset)
            joints[name] = replace(joint, rotation=turned, translation=translation)
    closures = [_moved_ends(closure, robot.base, rotation, offset) for closure in robot.closures]
    gravity = frozen(rotation @ robot.gravity)
    return replace(robot, joints=joints, closures=tuple(closures), gravity=gravity)


def _moved_ends(closure: Closure, base: str, rotation: np.ndarray, offset: np.ndarray) -> Closure:
    """A closure whose ends on the base have moved with the robot."""
    for _ in "ab":
        if closure.link_a == base:
            point = frozen(rotation @ closure.point_a + offset)
            turned = frozen(rotation @ closure.rotation_a)
            closure = replace(closure, point_a=point, rotation_a=turned)
        closure = swapped(closure)
    return closure


def scaled(robot: RobotDescription, factor: float) -> RobotDescription:
    """The robot with every length multiplied."""
    joints = {}
    reference = dict(robot.reference)
    for name, joint in robot.joints.items():
        joints[name] = replace(joint, translation=frozen(factor * joint.translation))
        if joint.type == "prismatic" and name in reference:
            reference[name] = factor * reference[name]
    closures = []
    for closure in robot.closures:
        point_a = frozen(factor * closure.point_a)
        point_b = frozen(factor * closure.point_b)
        closures.append(replace(closure, point_a=point_a, point_b=point_b))
    frames = {}
    for name, frame in robot.frames.items():
        frames[name] = Frame(frame.link, frame.rotation, frozen(factor * frame.translation))
    return replace(
        robot, joints=joints, closures=tuple(closures), frames=frames, reference=reference
    )


def as_text(robot: RobotDescription) -> str:
    """The robot as a description file."""
    lines = ["format: 1", f"name: {robot.name}", f"gravity: {_list(robot.gravity)}", "links:"]
    lines += [_link(link) for link in robot.links.values()]
    lines.append("joints:")
    lines += [_joint(joint) for joint in robot.joints.values()]
    typed = [_loop(robot, closure) for closure in robot.closures if closure.name in robot.loops]
    plain = [_closure(closure) for closure in robot.closures if closure.name not in robot.loops]
    if typed:
        lines += ["loops:", *typed]
    if plain:
        lines += ["closures:", *plain]
    tool = robot.frames["end_effector"]
    place = f"xyz: {_list(tool.translation)}, rpy: {_list(_rpy(tool.rotation))}"
    reference = ", ".join(f"{name}: {value!r}" for name, value in robot.reference.items())
    lines += [
        f"active: [{', '.join(robot.active)}]",
        f"end_effector: {{link: {tool.link}, {place}}}",
        f"reference: {{{reference}}}",
    ]
    return "\n".join(lines) + "\n"


def _link(link: Link) -> str:
    if not link.mass:
        return f"  {link.name}: {{}}"
    inertia = link.inertia.tolist()
    entries = [f"{key}: {inertia[i][j]!r}" for key, (i, j) in ENTRIES.items()]
    body = f"mass: {link.mass!r}, com: {_list(link.com)}, inertia: {{{', '.join(entries)}}}"
    return f"  {link.name}: {{{body}}}"


def _joint(joint: Joint) -> str:
    origin = f"xyz: {_list(joint.translation)}, rpy: {_list(_rpy(joint.rotation))}"
    return (
        f"  {joint.name}: {{type: {joint.type}, parent: {joint.parent}, child: {joint.child}, axis:"
        f" {_list(joint.axis)}, origin: {{{origin}}}}}"
    )


def _loop(robot: RobotDescription, closure: Closure) -> str:
    """A closure as a loop of Chu's types."""
    loop = robot.loops[closure.name]
    pin = f"{closure.link_a}: {_list(closure.point_a)}, {closure.link_b}: {_list(closure.point_b)}"
    return (
        f"  {closure.name}: {{type: {loop.type}, base: {loop.base}, arm: {loop.arm}, k1: {loop.k1},"
        f" k2: {loop.k2}, pin: {{{pin}}}{_assembly(closure)}}}"
    )


def _closure(closure: Closure) -> str:
    first = _end(closure.link_a, closure.point_a, closure.rotation_a)
    second = _end(closure.link_b, closure.point_b, closure.rotation_b)
    ends = f"{first}, {second}"
    return f"  {closure.name}: {{kind: {closure.kind}, between: {{{ends}}}{_assembly(closure)}}}"


def _assembly(closure: Closure) -> str:
    if not closure.assembly:
        return ""
    return f", assembly: {closure.assembly}"


def _end(link: str, point: np.ndarray, rotation: np.ndarray) -> str:
    return f"{link}: {{xyz: {_list(point)}, rpy: {_list(_rpy(rotation))}}}"


def _rpy(r: np.ndarray) -> list[float]:
    """Roll, pitch, yaw of a rotation Rz Ry Rx.

    At pitch +-90 degrees, where roll and yaw act alike, all as yaw.
    """
    level = np.hypot(r[0, 0], r[1, 0])
    pitch = np.arctan2(-r[2, 0], level)
    roll = 0.0
    yaw = np.arctan2(-r[0, 1], r[1, 1])
    if level >= 1e-9:
        roll = np.arctan2(r[2, 1], r[2, 2])
        yaw = np.arctan2(r[1, 0], r[0, 0])
    return [float(roll), float(pitch), float(yaw)]


def _list(values: np.ndarray | list[float]) -> str:
    return "[" + ", ".join(repr(float(v)) for v in values) + "]"
