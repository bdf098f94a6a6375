"""Reactions: the wrench in every closure and in every joint, from the forces of a motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from ..algebra.scalar import Scalar
from ..algebra.transform import RigidTransform
from ..algebra.vector import ZERO3, Vector, add, cross, matvec, sub
from ..closure.closed_motion import ClosedMotion
from ..description.model import Closure
from ..dynamics.load_pattern import NOTHING, LoadPattern
from ..dynamics.pins import Pin
from ..dynamics.spanning import TreeDynamics, Wrench, difference, total
from ..kernels.trace import Results
from ..mechanism.tree import Tree
from .dynamics import Dynamics
from .model import AT_ACCELERATION, Inputs, Model, Program, with_loads


class _PinWrench(NamedTuple):
    """The wrench that a pin exerts on its link a, in base axes.

    Attributes:
        pin: the pin.
        place: its position (3,) [m].
        force: (3,) [N].
        moment: about the place (3,) [N m].
        share: how well force and moment are determined, from 0 to 1.
    """

    pin: Pin
    place: Vector
    force: Vector
    moment: Vector
    share: Scalar

    def about(self, origin: Vector) -> Wrench:
        """Force, and moment about another point."""
        arm = sub(self.place, origin)
        return self.force, add(self.moment, cross(arm, self.force))


def reactions(closures: Sequence[Closure], pattern: LoadPattern = NOTHING) -> Program:
    """Program for tau and the wrenches in closures and joints, in base axes.

    Equal virtual work converts the multipliers of the loop equations into forces at the pins. A
    joint bears its wrench in the open tree, minus that of the pins that share its load.
    """

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        motion = dynamics.motion
        loaded = dynamics.loaded
        tree = dynamics.tree
        dds = motion.accelerations(x.ddu, dynamics.ds)
        in_link_axes = loaded.joint_wrenches(dynamics.gravity, dynamics.ds, dds)
        forces = loaded.with_joint_effects(tree.along_joints(in_link_axes), dynamics.ds, dds)
        tau, multipliers = motion.project(forces)
        along = generalised_forces(motion, multipliers)
        poses = tree.poses()
        origins = [origin for _, origin in poses]
        joints = _in_base_axes(in_link_axes, poses)
        base = _on_base(model.tree, joints, origins)
        pins = model.pins(closures)
        solved = [_solved(pin, tree, along.get(pin.name, {})) for pin in pins]
        for wrench in solved:
            _shift_to_pin(model.tree, wrench, joints, origins)
        outputs = {
            "tau": tau,
            "pin_places": [wrench.place for wrench in solved],
            "pin_forces": [wrench.force for wrench in solved],
            "pin_moments": [wrench.moment for wrench in solved],
            "pin_shares": [wrench.share for wrench in solved],
            "joint_places": origins,
            "joint_forces": [force for force, _ in joints],
            "joint_moments": [moment for _, moment in joints],
            "base": base,
        }
        return Results(outputs, dynamics.checks)

    return with_loads(AT_ACCELERATION, run, pattern)


def _in_base_axes(wrenches: Sequence[Wrench], poses: Sequence[RigidTransform]) -> list[Wrench]:
    """Wrenches on bodies in link axes, in base axes."""
    turned: list[Wrench] = []
    for (rotation, _), (force, moment) in zip(poses, wrenches, strict=True):
        turned.append((matvec(rotation, force), matvec(rotation, moment)))
    return turned


def _solved(pin: Pin, tree: TreeDynamics, generalised: Mapping[int, Scalar]) -> _PinWrench:
    force, moment, share = pin.wrench(tree, generalised)
    place, _ = pin.ends(tree)
    return _PinWrench(pin, place, force, moment, share)


def _shift_to_pin(
    tree: Tree, wrench: _PinWrench, joints: list[Wrench], origins: Sequence[Vector]
) -> None:
    """Subtract the wrench of a pin from the joints of its loop.

    The joints on link a's side are relieved of it, those on link b's side bear it too.
    """
    side_a, side_b, _ = tree.branches(wrench.pin.body_a, wrench.pin.body_b)
    for i in side_a:
        joints[i] = difference(joints[i], wrench.about(origins[i]))
    for i in side_b:
        joints[i] = total(joints[i], wrench.about(origins[i]))


def _on_base(tree: Tree, joints: Sequence[Wrench], origins: Sequence[Vector]) -> list[Scalar]:
    """Force and moment about the base origin on the base, from its joints and pins."""
    force, moment = ZERO3, ZERO3
    for body, (joint_force, joint_moment), origin in zip(tree.bodies, joints, origins, strict=True):
        if body.parent < 0:
            force = add(force, joint_force)
            moment = add(moment, add(joint_moment, cross(origin, joint_force)))
    return [*force, *moment]


def generalised_forces(
    motion: ClosedMotion, multipliers: list[list[Scalar]]
) -> dict[str, dict[int, Scalar]]:
    """The generalised forces along joints of the multipliers of each closure.

    Args:
        motion: the closed motion.
        multipliers: mu of each block, as `ClosedMotion.project` gives them.

    Returns:
        By closure, then by coordinate.
    """
    forces: dict[str, dict[int, Scalar]] = {}
    for block, factors in zip(motion.blocks, multipliers, strict=True):
        for equation, row, factor in zip(block.equations, block.rows, factors, strict=True):
            along = forces.setdefault(equation.loop.name, {})
            for k, coefficient in row.items():
                along[k] = along.get(k, 0.0) + coefficient * factor
    return forces
