"""Functions of blocks, on lanes: inverse of a matrix, and Newton's iteration.

They equal `algebra.numerics` on floats.
"""

from __future__ import annotations

from ..graph import Block
from ..trace import Trace, body_name, trace_body
from .elimination import invert_function, invert_name, pivoting_function, pivoting_invert
from .newton import NewtonFunction, newton_name
from .nodes import Fetch, Nodes
from .text import Lanes


def block_functions(trace: Trace, width: int) -> list[str]:
    """The functions of the live blocks of a trace on lanes, without duplicates.

    Inner ones come first.
    """
    texts: list[str] = []
    for number in trace.live_blocks():
        block = trace.graph.blocks[number]
        size = block.size
        if block.body is None:
            texts += [pivoting_function(size, size), pivoting_invert(size)]
            texts.append(invert_function(size, _zeros(block), width))
        else:
            inner = trace_body(trace, number)
            texts += block_functions(inner, width)
            texts.append(pivoting_function(size, 1))
            texts.append(NewtonFunction(inner, size, width, call_block).text())
    return list(dict.fromkeys(texts))


def _zeros(block: Block) -> int:
    """Bits of the entries of a matrix that are always zero."""
    (entries,) = block.arguments
    bits = 0
    for k, entry in enumerate(entries):
        if isinstance(entry, float) and entry == 0.0:
            bits |= 1 << k
    return bits


def call_block(nodes: Nodes, number: int) -> list[str]:
    """Write a call of a block's function; returns the names of its outputs."""
    block = nodes.trace.graph.blocks[number]
    f = nodes.function
    kind, width = nodes.lanes.kind, nodes.lanes.width
    arguments: list[str] = []
    for vector in block.arguments:
        arguments += map(nodes.value, vector)
    given = f.slot(kind, len(arguments))
    answer = f.slot(kind, block.outputs)
    for k, argument in enumerate(arguments):
        f.store(argument, given, k, kind=kind)
    if block.body is None:
        name = invert_name(block.size, _zeros(block), width)
    else:
        name = newton_name(body_name(nodes.trace, number), width)
    f.do(f"call void @{name}(ptr {given}, ptr {answer})")
    return [f.load(answer, k, kind=kind) for k in range(block.outputs)]


def fetch_input(trace: Trace) -> Fetch:
    """Access to the input vectors %a0, %a1, ... of one state."""

    def fetch(lanes: Lanes, index: int) -> str:
        _, vector, component = trace.graph.nodes[index]
        return lanes.function.load(f"%a{int(vector)}", int(component))

    return fetch
