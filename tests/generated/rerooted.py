"""The same robot on another spanning tree.

A loop is cut at another joint, and what hung on it hangs on the pin.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hybrid_dynamics_core.description import Closure, Frame, Joint, RobotDescription
from hybrid_dynamics_core.ground.arrays import frozen
from tests.generated.assembly import frame_with_normal, unit
from tests.generated.assembly import turn as turn_about
from tests.generated.space import Space

CUTTABLE = ("planar", "axis")  # closures that are a turning joint
Pose = tuple[np.ndarray, np.ndarray]


def other_cuts(robot: RobotDescription) -> list[tuple[str, str]]:
    """(closure, joint) wherever a loop may as well be cut.

    Turning joints that are not active, in loops of one pin.

    Not where bars of another loop turn round that is named a parallelogram: it is told by its four
    bars.
    """
    cuts = []
    for c in robot.closures:
        named = [
            _loop(robot, o) for o in robot.closures if o is not c and o.assembly == "parallelogram"
        ]
        for name in _loop(robot, c) if c.kind in CUTTABLE else ():
            turns = {name, *turned_by(robot, c, name)}
            if robot.joints[name].type == "revolute" and name not in robot.active:
                cuts += [(c.name, name)] if all(turns.isdisjoint(loop) for loop in named) else []
    return sorted(cuts)


def turned_by(robot: RobotDescription, c: Closure, cut: str) -> list[str]:
    """Joints between a cut and the closure, which turn round."""
    below = next(names for link in (c.link_a, c.link_b) if cut in (names := chain(robot, link)))
    return below[below.index(cut) + 1 :]


def chain(robot: RobotDescription, link: str) -> list[str]:
    """Joints from the base to a link."""
    over = {j.child: name for name, j in robot.joints.items()}
    names: list[str] = []
    while link in over:
        names.insert(0, over[link])
        link = robot.joints[over[link]].parent
    return names


def _loop(robot: RobotDescription, c: Closure) -> set[str]:
    """Joints of the loop that a closure closes."""
    return set(chain(robot, c.link_a)) ^ set(chain(robot, c.link_b))


def rerooted(
    robot: RobotDescription, s: np.ndarray, names: tuple[str, ...], closure: str, cut: str
) -> RobotDescription:
    """The robot with a pin as a joint of the tree, named after the closure, and the joint `cut` as
    the closure.

    s: a closed configuration in the order `names`. The links between both turn round: each hangs on
    what hung on it.
    """
    poses = Space(robot, names).poses(s)
    values = dict(zip(names, s.tolist(), strict=True))
    pin = next(c for c in robot.closures if c.name == closure)
    if cut not in chain(robot, pin.link_a):
        pin = _swapped(pin)
    turned = turned_by(robot, pin, cut)
    axes = {name: poses[j.child][0] @ j.axis for name, j in robot.joints.items()}
    places = {name: poses[j.child][1] for name, j in robot.joints.items()}
    here = poses[pin.link_a][1] + poses[pin.link_a][0] @ pin.point_a
    across = axes[cut] if pin.kind == "planar" else poses[pin.link_a][0] @ pin.rotation_a[:, 2]
    made = {closure: ("revolute", pin.link_b, pin.link_a, across, 0.0)}
    origins = {pin.link_a: here}
    for (
        name
    ) in turned:  # a joint between the same links, seen from the other one: its axis turns round
        j = robot.joints[name]
        made[name] = (j.type, j.child, j.parent, -axes[name], values[name])
        origins[j.parent] = places[name]
    new_poses = {link: (turn, origins.get(link, at)) for link, (turn, at) in poses.items()}
    joints = {closure: _joint(closure, *made[closure], new_poses)}
    for name, j in robot.joints.items():
        if name in made:
            joints[name] = _joint(name, *made[name], new_poses)
        elif name != cut:
            joints[name] = _joint(
                name, j.type, j.parent, j.child, axes[name], values[name], new_poses
            )
    old = robot.joints[cut]
    ends = [_local(new_poses[link], places[cut]) for link in (old.parent, old.child)]
    axle = frame_with_normal(unit(axes[cut]), None)
    turns = [new_poses[link][0].T @ axle for link in (old.parent, old.child)]
    kept = [_moved_closure(c, poses, new_poses) for c in robot.closures if c.name != closure]
    mode = pin.assembly if pin.assembly == "parallelogram" else None
    more = {
        "kind": pin.kind,
        "rotation_a": frozen(turns[0]),
        "rotation_b": frozen(turns[1]),
        "assembly": mode,
    }
    kept.append(Closure(cut, old.parent, frozen(ends[0]), old.child, frozen(ends[1]), **more))
    return replace(
        robot,
        links={
            n: replace(k, com=frozen(k.com - _shift(n, poses, new_poses)))
            for n, k in robot.links.items()
        },
        joints=joints,
        closures=tuple(kept),
        loops={},
        frames={
            n: Frame(f.link, f.rotation, frozen(f.translation - _shift(f.link, poses, new_poses)))
            for n, f in robot.frames.items()
        },
        reference={**{n: values[n] for n in joints if n in values}, closure: 0.0},
        effects={n: e for n, e in robot.effects.items() if n != cut},
    )


def _swapped(c: Closure) -> Closure:
    ends = {"link_a": c.link_b, "point_a": c.point_b, "rotation_a": c.rotation_b}
    return replace(c, **ends, link_b=c.link_a, point_b=c.point_a, rotation_b=c.rotation_a)


def _shift(link: str, poses: dict[str, Pose], new_poses: dict[str, Pose]) -> np.ndarray:
    """How far a link's origin has moved, in link axes."""
    turn, origin = poses[link]
    return turn.T @ (new_poses[link][1] - origin)


def _local(pose: Pose, point: np.ndarray) -> np.ndarray:
    return pose[0].T @ (point - pose[1])


def _joint(
    name: str,
    kind: str,
    parent: str,
    child: str,
    axis: np.ndarray,
    value: float,
    poses: dict[str, Pose],
) -> Joint:
    """The joint that lets the child stand at its pose for this value."""
    turn, origin = poses[child]
    own = turn.T @ axis
    onto, start = poses[parent]
    if kind == "revolute":
        zero = onto.T @ turn @ turn_about(own, -value), onto.T @ (origin - start)
    else:
        zero = onto.T @ turn, onto.T @ (origin - value * axis - start)
    return Joint(name, kind, parent, child, frozen(zero[0]), frozen(zero[1]), frozen(own))


def _moved_closure(c: Closure, poses: dict[str, Pose], new_poses: dict[str, Pose]) -> Closure:
    """The closure on links whose frames have moved.

    Its mode, unless a parallelogram, is that of the reference.
    """
    ends = {
        f"point_{end}": frozen(
            getattr(c, f"point_{end}") - _shift(getattr(c, f"link_{end}"), poses, new_poses)
        )
        for end in "ab"
    }
    return replace(c, **ends, assembly=c.assembly if c.assembly == "parallelogram" else None)
