"""Run a program on symbols; keep what its outputs and checks need."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..algebra.scalar import Scalar
from .graph import Graph, Operand


@dataclass(frozen=True)
class Check:
    """The state is refused with `code` unless value > threshold (NaN is refused too)."""

    value: Scalar
    threshold: float
    code: int


@dataclass(frozen=True)
class Results:
    """What a program returns: named outputs (a scalar or nested sequences of scalars) and its checks."""

    outputs: Mapping[str, Any]
    checks: Sequence[Check]


Traceable = Callable[..., Results]


@dataclass(frozen=True)
class Trace:
    """A traced program: the graph, the inputs' sizes, the flat outputs and their names and shapes in order.

    `name`: "0", and for the body of a block the name of its trace, a dot and the block's number.
    """

    graph: Graph
    inputs: tuple[int, ...]
    outputs: tuple[Operand, ...]
    layout: tuple[tuple[str, tuple[int, ...]], ...]
    checks: tuple[Check, ...]
    name: str = "0"

    @cached_property
    def live(self) -> list[int]:
        """Nodes that outputs or checks depend on, in order."""
        return self.graph.live([*self.outputs, *(check.value for check in self.checks)])

    def live_blocks(self) -> list[int]:
        """Numbers of the blocks that outputs or checks depend on, in order."""
        nodes = (self.graph.nodes[i] for i in self.live)
        return sorted({int(a) for op, a, _ in nodes if op == "block"})

    def used_inputs(self) -> set[tuple[int, int]]:
        """(vector, component) of the inputs that outputs or checks depend on."""
        nodes = (self.graph.nodes[i] for i in self.live)
        return {(int(a), int(b)) for op, a, b in nodes if op == "input"}


def trace(program: Traceable, sizes: Sequence[int], name: str = "0") -> Trace:
    """Trace a program whose arguments are vectors of the given sizes."""
    graph = Graph()
    arguments = [[graph.input(v, k) for k in range(size)] for v, size in enumerate(sizes)]
    results = program(*arguments)
    flat: list[Operand] = []
    layout = []
    for output, value in results.outputs.items():
        shape = _shape(value)
        layout.append((output, shape))
        flat += _flatten(value)
    return Trace(graph, tuple(sizes), tuple(flat), tuple(layout), tuple(results.checks), name)


def body_name(outer: Trace, number: int) -> str:
    """Name of the trace of a block's body."""
    return f"{outer.name}.{number}"


def trace_body(outer: Trace, number: int) -> Trace:
    """The function that a Newton block iterates: unknowns and parameters in, flat residuals and Jacobian out."""
    block = outer.graph.blocks[number]
    function = block.body
    assert function is not None  # noqa: S101  only Newton has one
    sizes = [len(v) for v in block.arguments]
    return trace(
        lambda x, p: Results({"values": function(x, p)}, []), sizes, body_name(outer, number)
    )


def _shape(value: Any) -> tuple[int, ...]:
    if not isinstance(value, (list, tuple)):
        return ()
    return (len(value), *(_shape(value[0]) if value else ()))


def _flatten(value: Any) -> list[Any]:
    if not isinstance(value, (list, tuple)):
        return [value]
    return [leaf for item in value for leaf in _flatten(item)]


def flat_results(results: Results) -> tuple[list[Any], list[Check]]:
    """Outputs in flat order and checks: what a plain (untraced) run returns."""
    return [leaf for value in results.outputs.values() for leaf in _flatten(value)], list(
        results.checks
    )


def split(flat: np.ndarray, layout: Sequence[tuple[str, tuple[int, ...]]]) -> dict[str, np.ndarray]:
    """Named views of flat results (..., size): each (..., *shape)."""
    result = {}
    start = 0
    for name, shape in layout:
        size = int(np.prod(shape, dtype=int))
        result[name] = flat[..., start : start + size].reshape((*flat.shape[:-1], *shape))
        start += size
    return result
