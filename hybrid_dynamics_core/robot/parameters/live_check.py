"""Whether a model with live numbers is that of the changed description, wherever they go.

The description is built again with moved numbers. Its model must have the same structure, and the
constants that the live numbers give.
"""

from __future__ import annotations

from collections.abc import Mapping
from numbers import Real
from typing import Any

import numpy as np

from ...algebra.live import live_numbers
from ...closure.blocks.newton import NewtonBlock
from ...closure.plan import ClosurePlan
from ...description.model import RobotDescription
from ...dynamics.loads import described_loads
from ...dynamics.pack_loads import pack_loads
from ...ground.arrays import Array
from ...kernels.graph import Graph
from ...programs import Model
from ...programs.live import LiveModel
from ..model import RobotModel

_NOT_COMPUTED_WITH = ("limits",)
SAME = 1e-9  # relative, or in SI units below one: rounding of one constant, computed twice


def difference(
    live: LiveModel, values: list[float], other: Model, description: RobotDescription
) -> str:
    """What differs between a live model and the model of the changed description; "" if nothing.

    Args:
        live: the model with live numbers.
        values: other values of its parameters.
        other: the model of floats of the description with these values.
        description: that description.
    """
    model = live.at(values)
    structure = _other_structure(model.plan, other.plan)
    if structure:
        return structure
    frames = description.frames
    walk = _Walk()
    walk.compare(model.tree.bodies, other.tree.bodies, "links")
    walk.compare(model.frames, frames, "frames")
    walk.compare(model.closures, description.closures, "closures")
    walk.compare(model.plan.loops, other.plan.loops, "loops")
    for block, other_block in zip(model.plan.blocks, other.plan.blocks, strict=True):
        if not isinstance(block, NewtonBlock):
            walk.compare(block, other_block, f"loop {block.name}")
    return walk.problem


def unused(live: LiveModel) -> list[int]:
    """Indices of the parameters that no constant of the model depends on."""
    graph = live.graph or Graph()
    symbols = [number.symbol for number in live_numbers(live)]
    used: set[int] = set()
    for index in graph.live(symbols):
        op, _, component = graph.nodes[index]
        if op == "input":
            used.add(int(component))
    return sorted(set(range(live.count)) - used)


def has_other_loads(one: RobotModel, other: RobotModel) -> bool:
    """Whether two robots differ in the loads or effects of their descriptions."""
    pattern, values = _packed(one)
    other_pattern, other_values = _packed(other)
    if pattern != other_pattern:
        return True
    same = [np.array_equal(value, other_values[name]) for name, value in values.items()]
    return not all(same)


def _packed(model: RobotModel) -> tuple[object, Mapping[str, Array]]:
    description: RobotDescription = model.description
    loads = described_loads(description, model.coordinates)
    pattern, values = pack_loads(loads, model.tree, model.frame, None)
    return pattern, {**values, "gravity": loads.gravity}


def _other_structure(plan: ClosurePlan, other: ClosurePlan) -> str:
    """How the structure of two plans differs; "" if it does not."""
    if _counts(plan) != _counts(other):
        return "changes the number of equations of the loops"
    for loop, other_loop in zip(plan.loops, other.loops, strict=True):
        if type(loop) is not type(other_loop):
            return f"changes the kind of loop '{loop.name}'"
    for block, other_block in zip(plan.blocks, other.blocks, strict=True):
        is_same_kind = isinstance(block, type(other_block))
        if not is_same_kind or block.unknowns != other_block.unknowns:
            how = "by iteration" if other_block.iterates else "in another order"
            return f"changes how loop '{block.name}' is solved: {how}"
    return ""


def _counts(plan: ClosurePlan) -> tuple[int, ...]:
    parts = (plan.loops, plan.blocks, plan.redundant)
    return tuple(map(len, parts))


class _Walk:
    """Compares two objects of the same structure number by number.

    Attributes:
        problem: the first difference; "" if there is none.
    """

    def __init__(self) -> None:
        self.problem = ""
        self._visited: set[int] = set()

    def compare(self, one: Any, other: Any, where: str) -> None:
        """Compare two objects and all that they refer to."""
        if self.problem or one is other:
            return
        if isinstance(one, Real) and isinstance(other, Real):
            self._compare_numbers(float(one), float(other), where)
        elif isinstance(one, np.ndarray):
            entries = np.asarray(other).tolist()
            self.compare(one.tolist(), entries, where)
        elif isinstance(one, (tuple, list)):
            self._compare_lists(one, other, where)
        elif isinstance(one, Mapping):
            self._compare_mappings(one, other, where)
        elif hasattr(one, "__dict__") and id(one) not in self._visited:
            self._visited.add(id(one))
            self._compare_mappings(vars(one), vars(other), where)

    def _compare_numbers(self, one: float, other: float, where: str) -> None:
        if abs(one - other) > SAME * (1.0 + abs(other)):
            self.problem = f"reaches {where} in a way that code cannot follow"

    def _compare_mappings(self, one: Any, other: Any, where: str) -> None:
        for key in one:
            if key in other and key not in _NOT_COMPUTED_WITH:
                self.compare(one[key], other[key], f"{where} {key}")

    def _compare_lists(self, one: Any, other: Any, where: str) -> None:
        if len(one) != len(other):
            self.problem = f"changes {where}"
            return
        for value, other_value in zip(one, other, strict=True):
            self.compare(value, other_value, where)
