"""Reactions: the wrench in every closure and in every joint, from the forces that the motion needs."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ..algebra.scalar import Scalar
from ..algebra.vector import ZERO3, Vector, add, cross, matvec, sub
from ..closure.closed_motion import ClosedMotion
from ..description.model import Closure
from ..dynamics.load_pattern import NOTHING, LoadPattern
from ..dynamics.pins import Pin, find_pins
from ..dynamics.spanning import Wrench
from ..kernels.trace import Results
from ..mechanism.tree import Tree
from .dynamics import Dynamics
from .model import Inputs, Model, Program


def reactions(closures: Sequence[Closure], pattern: LoadPattern = NOTHING) -> Program:
    """Program for tau and the wrenches in closures and joints, in base axes.

    The multipliers carry over from the equations that close the loops to the pins by equal work.
    The joints bear what those of the open tree would, less what the pins bear in their place.
    """

    def run(model: Model, x: Inputs) -> Results:
        dynamics = Dynamics(model, x, pattern)
        motion, laden, tree = dynamics.motion, dynamics.laden, dynamics.tree
        dds = motion.accelerations(x.ddu, dynamics.ds)
        opened = laden.joint_wrenches(dynamics.gravity, dynamics.ds, dds)
        tau, multipliers = motion.project(laden.added(tree.along_joints(opened), dynamics.ds, dds))
        along = generalised_forces(motion, multipliers)
        poses = tree.poses()
        joints = [
            (matvec(turn, f), matvec(turn, m))
            for (turn, _), (f, m) in zip(poses, opened, strict=True)
        ]
        base = _on_base(model.tree, joints, [origin for _, origin in poses])
        pins = find_pins(model.tree, model.plan, closures)
        solved = [pin.wrench(tree, along.get(pin.name, {})) for pin in pins]
        places = [pin.ends(tree)[0] for pin in pins]
        for pin, place, (force, moment, _) in zip(pins, places, solved, strict=True):
            for i, add_or_take in _branches(model.tree, pin):
                turning = add(moment, cross(sub(place, poses[i][1]), force))
                joints[i] = (add_or_take(joints[i][0], force), add_or_take(joints[i][1], turning))
        outputs = {
            "tau": tau,
            "pin_places": places,
            "pin_forces": [force for force, _, _ in solved],
            "pin_moments": [moment for _, moment, _ in solved],
            "pin_shares": [share for _, _, share in solved],
            "joint_places": [origin for _, origin in poses],
            "joint_forces": [force for force, _ in joints],
            "joint_moments": [moment for _, moment in joints],
            "base": base,
        }
        return Results(outputs, dynamics.checks)

    return Program(
        ("u", "du", "ddu", "branch", "guess", "gravity", *pattern.inputs), run, pattern.sizes
    )


def _branches(tree: Tree, pin: Pin) -> list[tuple[int, Callable[[Vector, Vector], Vector]]]:
    """The bodies beyond which the pin's wrench is borne: link a's side is relieved of it, link b's side has it too."""
    side_a, side_b, _ = tree.branches(pin.body_a, pin.body_b)
    return [*((i, sub) for i in side_a), *((i, add) for i in side_b)]


def _on_base(tree: Tree, joints: Sequence[Wrench], origins: Sequence[Vector]) -> list[Scalar]:
    """Force and moment about the base origin of all that stands on the base; pins to the base are among it."""
    force, moment = ZERO3, ZERO3
    for body, (f, m), origin in zip(tree.bodies, joints, origins, strict=True):
        if body.parent < 0:
            force, moment = add(force, f), add(moment, add(m, cross(origin, f)))
    return [*force, *moment]


def generalised_forces(
    motion: ClosedMotion, multipliers: list[list[Scalar]]
) -> dict[str, dict[int, Scalar]]:
    """By closure: the forces along the joints that its equations and their multipliers stand for."""
    result: dict[str, dict[int, Scalar]] = {}
    for block, factors in zip(motion.blocks, multipliers, strict=True):
        for equation, row, factor in zip(block.equations, block.rows, factors, strict=True):
            forces = result.setdefault(equation.loop.name, {})
            for k, coefficient in row.items():
                forces[k] = forces.get(k, 0.0) + coefficient * factor
    return result
