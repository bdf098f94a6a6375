"""Tracing: run a program on symbols, and keep what its outputs and checks need."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from ..algebra.scalar import Scalar
from .graph import Graph, Operand

_MATRICES = frozenset({"R", "M", "C", "dR", "d_u", "d_du", "d_ddu", "d_tau"})  # outputs of n rows


@dataclass(frozen=True)
class Check:
    """A condition value > threshold of good states; others, and NaN, have the status `code`."""

    value: Scalar
    threshold: float
    code: int


@dataclass(frozen=True)
class Results:
    """The results of a program.

    Attributes:
        outputs: outputs by name, each a scalar or nested sequences of scalars.
        checks: conditions of a good state.
        rewritable: outputs that may be computed in another order, with other rounding, by fewer
            operations. Programs that keep the same values have the same result to the last bit.
        kept: scalars that are computed as they are written.
    """

    outputs: Mapping[str, Any]
    checks: Sequence[Check]
    rewritable: tuple[str, ...] = ()
    kept: Sequence[Scalar] = ()


Traceable = Callable[..., Results]


@dataclass(frozen=True)
class Trace:
    """A traced program.

    Attributes:
        graph: the operations.
        inputs: sizes of the input vectors.
        outputs: all values, flat and in order.
        layout: names and shapes of the outputs, in order.
        checks: conditions of a good state.
        rewritable: names of the outputs that may be computed in another order.
        kept: values that may not.
        name: "0"; for the body of a block, the name of the outer trace, a dot and the block's
            index.
    """

    graph: Graph
    inputs: tuple[int, ...]
    outputs: tuple[Operand, ...]
    layout: tuple[tuple[str, tuple[int, ...]], ...]
    checks: tuple[Check, ...]
    name: str = "0"
    rewritable: tuple[str, ...] = ()
    kept: tuple[Operand, ...] = ()

    @cached_property
    def live(self) -> list[int]:
        """Nodes that outputs or checks depend on, in order."""
        return self.graph.live([*self.outputs, *(check.value for check in self.checks)])

    def live_blocks(self) -> list[int]:
        """Indices of the blocks that outputs or checks depend on, in order."""
        nodes = (self.graph.nodes[i] for i in self.live)
        return sorted({int(a) for op, a, _ in nodes if op == "block"})

    def used_inputs(self) -> set[tuple[int, int]]:
        """(vector, component) of the inputs that outputs or checks depend on."""
        nodes = (self.graph.nodes[i] for i in self.live)
        return {(int(a), int(b)) for op, a, b in nodes if op == "input"}


def trace(program: Traceable, sizes: Sequence[int], name: str = "0") -> Trace:
    """Trace a program whose arguments are vectors of the given sizes."""
    graph = Graph()
    arguments = []
    for vector, size in enumerate(sizes):
        arguments.append([graph.input(vector, k) for k in range(size)])
    return trace_of(graph, program(*arguments), sizes, name)


def trace_of(graph: Graph, results: Results, sizes: Sequence[int], name: str) -> Trace:
    """The trace of results in a graph whose inputs are vectors of the given sizes."""
    flat: list[Operand] = []
    layout = []
    for output, value in results.outputs.items():
        shape = _shape(value)
        if shape == (0,) and output in _MATRICES:  # of a robot in which nothing moves
            shape = (0, 0)
        layout.append((output, shape))
        flat += flatten(value)
    return Trace(
        graph,
        tuple(sizes),
        tuple(flat),
        tuple(layout),
        tuple(results.checks),
        name,
        results.rewritable,
        tuple(results.kept),
    )


def body_name(outer: Trace, number: int) -> str:
    """Name of the trace of a block's body."""
    return f"{outer.name}.{number}"


def trace_body(outer: Trace, number: int) -> Trace:
    """Trace the function of a Newton block.

    Its inputs are unknowns and parameters, its outputs flat residuals and Jacobian.
    """
    block = outer.graph.blocks[number]
    function = block.body
    assert function is not None  # noqa: S101  only Newton has one
    sizes = [len(vector) for vector in block.arguments]
    name = body_name(outer, number)
    return trace(lambda x, p: Results({"values": function(x, p)}, []), sizes, name)


def _shape(value: Any) -> tuple[int, ...]:
    if not isinstance(value, (list, tuple)):
        return ()
    if not value:
        return (0,)
    return (len(value), *_shape(value[0]))


def flatten(value: Any) -> list[Any]:
    """Scalars of nested sequences, in order."""
    if not isinstance(value, (list, tuple)):
        return [value]
    flat = []
    for item in value:
        flat += flatten(item)
    return flat
