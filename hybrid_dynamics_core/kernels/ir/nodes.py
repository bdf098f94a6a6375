"""Instructions for the nodes of a trace, on one state or on a vector of states."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from ..graph import Operand, Symbol
from ..trace import Trace
from .atan2 import atan2_name
from .text import Function, Lanes

_ARITHMETIC = {"add": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv"}
_INTRINSIC = {"sqrt": "sqrt", "abs": "fabs", "rint": "rint"}
# (nodes, index of the block) -> names of its outputs
CallBlock = Callable[["Nodes", int], list[str]]
# (lanes, node computed elsewhere) -> name of its value
Fetch = Callable[[Lanes, int], str]


class Nodes:
    """Writes nodes of a trace into a function; `value` returns their names.

    Nodes that are computed elsewhere are fetched when needed.
    """

    def __init__(
        self, trace: Trace, lanes: Lanes, indices: Iterable[int], fetch: Fetch, call: CallBlock
    ) -> None:
        self.trace, self.lanes = trace, lanes
        self._fetch, self._call = fetch, call
        self._names: dict[int, str] = {}
        self._blocks: dict[int, list[str]] = {}
        self._angles: dict[str, tuple[str, str]] = {}
        for index in indices:
            if trace.graph.nodes[index][0] != "input":
                self._names[index] = self._node(index)

    @property
    def function(self) -> Function:
        """The function written to."""
        return self.lanes.function

    def value(self, x: Operand | int) -> str:
        """The name of a node's value (a node by symbol or index), or a constant."""
        if isinstance(x, float):
            return self.lanes.constant(x)
        index = x.index if isinstance(x, Symbol) else x
        if index not in self._names:
            self._names[index] = self._fetch(self.lanes, index)
        return self._names[index]

    def _node(self, index: int) -> str:
        op, a, b = self.trace.graph.nodes[index]
        if op == "block":
            if int(a) not in self._blocks:
                self._blocks[int(a)] = self._call(self, int(a))
            return self._blocks[int(a)][int(b)]
        first = self.value(a)
        if op == "neg":
            return self.lanes.negative(first)
        if op in ("sin", "cos"):
            sine, cosine = self._angle(first)
            return sine if op == "sin" else cosine
        if op in _INTRINSIC:
            return self.lanes.intrinsic(_INTRINSIC[op], first)
        second = self.value(b)
        if op in _ARITHMETIC:
            return self.lanes.arithmetic(_ARITHMETIC[op], first, second)
        kind, name = self.lanes.kind, atan2_name(self.lanes.width)
        return self.function.let(f"call {kind} {name}({kind} {first}, {kind} {second})")

    def _angle(self, angle: str) -> tuple[str, str]:
        if angle not in self._angles:
            f, kind = self.function, self.lanes.kind
            pair = f"{{ {kind}, {kind} }}"
            both = f.let(f"call {pair} @sincos.{self.lanes.width}({kind} {angle})")
            sine = f.let(f"extractvalue {pair} {both}, 0")
            cosine = f.let(f"extractvalue {pair} {both}, 1")
            self._angles[angle] = sine, cosine
        return self._angles[angle]
