"""The model of a robot with some numbers of its description live."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...algebra.live import Live
from ...closure.blocks.block_solver import BlockSolver
from ...closure.blocks.live_newton import LiveNewtonBlock
from ...closure.blocks.newton import NewtonBlock
from ...closure.blocks.patterns import Context, solver_for
from ...closure.constraints.equations import Equation, LoopEquations, loops_of
from ...closure.constraints.from_description import loop_equations
from ...closure.loop_length import measure
from ...closure.matching import EquationBlock
from ...closure.plan import ClosurePlan
from ...description.build import described_numbers
from ...description.document import KeyPath
from ...description.model import Closure, Frame, Joint, RobotDescription
from ...description.parameters.written import Written
from ...dynamics.pins import moved_pins
from ...kernels.graph import Graph
from ...mechanism.tree import Tree, build_tree
from ...programs import Model
from ...programs.live import LiveModel

_JOINT = ("rotation", "translation", "axis")
_CLOSURE = ("point_a", "point_b", "rotation_a", "rotation_b")


def live_model(
    described: Model, robot: RobotDescription, written: Written, values: Mapping[KeyPath, float]
) -> LiveModel:
    """The model in which some numbers are arguments.

    Args:
        described: the model of floats, whose structure is kept.
        robot: its description, as the model uses it.
        written: what the description was built from.
        values: the numbers by path, as they are in the description.
    """
    graph = Graph()
    numbers: dict[KeyPath, Any] = {}
    for k, (path, value) in enumerate(values.items()):
        numbers[path] = Live(value, graph.input(0, k))
    live = described_numbers(written.changed(numbers).document_to_build())
    plain = described_numbers(written.document_to_build())
    merged = merged_numbers(robot, plain, live)
    tree = build_tree(merged)
    plan = _live_plan(described, tree, merged)
    pins = described.pins(robot.closures)
    return LiveModel(
        tree,
        plan,
        described.idle,
        tuple(merged.closures),
        described=described,
        frames=all_frames(merged),
        live_pins=tuple(moved_pins(pins, tree, merged.closures)),
        graph=graph,
        count=len(values),
    )


def all_frames(robot: RobotDescription) -> dict[str, Frame]:
    """All frames by name; links have their own."""
    frames = {name: Frame(name) for name in robot.links}
    return {**frames, **robot.frames}


def merged_numbers(
    robot: RobotDescription, plain: RobotDescription, live: RobotDescription
) -> RobotDescription:
    """The description with live numbers, where the model uses the numbers of the file.

    A joint that was turned into the plane of its loop, for example, keeps the numbers of the model.
    """
    joints: dict[str, Joint] = {}
    for name, joint in robot.joints.items():
        joints[name] = _with(joint, plain.joints[name], live.joints[name], _JOINT)
    before = {closure.name: closure for closure in plain.closures}
    after = {closure.name: closure for closure in live.closures}
    closures: list[Closure] = []
    for closure in robot.closures:
        name = closure.name
        closures.append(_with(closure, before[name], after[name], _CLOSURE))
    return replace(
        robot,
        joints=joints,
        closures=tuple(closures),
        links=live.links,
        frames=live.frames,
        mimics=live.mimics,
    )


def _with(used: Any, plain: Any, live: Any, names: Sequence[str]) -> Any:
    """An entry of the model with live arrays in place of those that are the file's."""
    changes: dict[str, Any] = {}
    for name in names:
        if np.array_equal(getattr(used, name), getattr(plain, name)):
            changes[name] = getattr(live, name)
    return replace(used, **changes)


def _live_plan(described: Model, tree: Tree, robot: RobotDescription) -> ClosurePlan:
    """The closure plan with live equations in place of its own."""
    plan = described.plan
    unknowns = set(range(len(tree.coordinates))) - set(plan.given)
    loops = loop_equations(tree, robot, frozenset(unknowns))
    by_loop = dict(zip(plan.loops, loops, strict=True))
    closures = {closure.name: closure for closure in robot.closures}
    near = dict(enumerate(map(float, plan.reference.q)))
    context = Context(tree, closures, near)
    blocks = [_live_block(block, by_loop, context) for block in plan.blocks]
    together = [loops_of(block.equations) for block in blocks]
    measure(tree, robot, loops, together, plan.reference)
    for block in blocks:
        lengths = [equation.loop.length for equation in block.equations]
        block.length = max(lengths)
        if isinstance(block, NewtonBlock):
            block.order = ()
    iterated = map(_iterated, blocks, plan.blocks)
    redundant = [_moved(equation, by_loop) for equation in plan.redundant]
    return replace(
        plan,
        blocks=tuple(iterated),
        loops=tuple(loops),
        redundant=tuple(redundant),
    )


def _live_block(
    block: BlockSolver, by_loop: Mapping[LoopEquations, LoopEquations], context: Context
) -> BlockSolver:
    equations = tuple(_moved(equation, by_loop) for equation in block.equations)
    live = solver_for(EquationBlock(equations, block.unknowns), context)
    if not isinstance(live, type(block)):
        raise TypeError(f"{block.name} is another block with live numbers")
    return live


def _iterated(block: BlockSolver, described: BlockSolver) -> BlockSolver:
    """A Newton block that takes its live numbers as parameters."""
    if not isinstance(block, NewtonBlock):
        return block
    live = LiveNewtonBlock(block, block.equations)
    live.order = described.order
    return live


def _moved(equation: Equation, by_loop: Mapping[LoopEquations, LoopEquations]) -> Equation:
    return Equation(by_loop[equation.loop], equation.index)
