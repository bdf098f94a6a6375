"""Programs whose constants are arguments: a model with live numbers, and derivatives by them.

The structure of the model is that of the robot as it is described: its closed forms, its order of
blocks. Symbols of the arguments stand in place of the constants that depend on them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from ..algebra.live import bound, live_numbers
from ..algebra.scalar import Scalar, Scalars
from ..description.model import Closure, Frame
from ..dynamics.load_pattern import NOTHING, LoadPattern
from ..dynamics.pins import Pin
from ..kernels.differentiate import evaluate, jacobian
from ..kernels.graph import Graph, Symbol
from ..kernels.run import Kernel
from ..kernels.trace import Results, flatten
from ..mechanism.tree import Tree
from .closure import CLOSE
from .dynamics import inverse_dynamics
from .kinematics import forward_kinematics
from .kinematics import jacobian as frame_jacobian
from .model import Inputs, Model, Program
from .reactions import reactions

PARAMETERS = "parameters"


@dataclass(frozen=True)
class LiveModel(Model):
    """A model with live numbers.

    Attributes:
        described: the model of floats that it has its structure from.
        frames: frames by name.
        live_pins: pins of the closures.
        graph: the graph of the parameters; None once the numbers are bound.
        count: number of parameters.
    """

    described: Model | None = None
    frames: Mapping[str, Frame] | None = None
    live_pins: tuple[Pin, ...] = ()
    graph: Graph | None = None
    count: int = 0

    @property
    def regrouped(self) -> Tree:
        """The tree itself."""
        return self.tree

    @property
    def layout(self) -> None:
        """None: all links have axes of their own."""
        return None

    @property
    def measured(self) -> Tree:
        """The tree of floats."""
        return self.tree if self.described is None else self.described.tree

    def pins(self, closures: Sequence[Closure]) -> list[Pin]:  # noqa: ARG002
        """The pins of the closures."""
        return list(self.live_pins)

    def at(self, parameters: Scalars) -> LiveModel:
        """The model with symbols or floats in place of live numbers."""
        assert self.graph is not None  # noqa: S101
        nodes = self.graph.nodes
        inputs: dict[int, Scalar] = {}
        for index, (op, _, component) in enumerate(nodes):
            if op == "input":
                inputs[index] = parameters[int(component)]
        everything = [Symbol(self.graph, index) for index in range(len(nodes))]
        values = evaluate(self.graph, everything, inputs)
        live = replace(self, graph=None, described=None)
        symbols: dict[int, Scalar] = {}
        for number in live_numbers(live):
            symbols[id(number)] = values[number.symbol.index]
        return replace(bound(live, symbols), described=self.described)


@dataclass(frozen=True)
class LiveCall:
    """A program by its kind.

    Attributes:
        kind: "close", "pose", "jacobian", "inverse_dynamics" or "reactions".
        frame: name of the frame, for poses and Jacobians.
        pattern: pattern of the loads, for dynamics.
    """

    kind: str
    frame: str = ""
    pattern: LoadPattern = NOTHING

    def program(self, model: LiveModel) -> Program:
        """The program of a model."""
        if self.kind == "close":
            return CLOSE
        if self.kind == "inverse_dynamics":
            return inverse_dynamics(self.pattern)
        if self.kind == "reactions":
            return reactions(model.closures, self.pattern)
        assert model.frames is not None  # noqa: S101
        frame = model.frames[self.frame]
        return forward_kinematics(frame) if self.kind == "pose" else frame_jacobian(frame)


@dataclass(frozen=True)
class LiveProgram:
    """A program of a live model, with derivatives of its results.

    Attributes:
        model: the model.
        call: the program.
        outputs: names of the results.
        by: vectors by which they are differentiated, such as "parameters" and "u".
    """

    model: LiveModel
    call: LiveCall
    outputs: tuple[str, ...]
    by: tuple[str, ...] = ()

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the input vectors, in order."""
        return (*self.call.program(self.model).inputs, PARAMETERS)

    def kernel(self, label: str, backend: str | None = None) -> Kernel:
        """The program as functions of arrays."""
        program = self.call.program(self.model)
        sizes = [program.size(self.model, name) for name in program.inputs]

        def run(*vectors: Scalars) -> Results:
            return self.results(program.inputs, vectors)

        return Kernel(run, [*sizes, self.model.count], backend, label)

    def results(self, names: Sequence[str], vectors: Sequence[Scalars]) -> Results:
        """The results at the values of the inputs, the parameters last."""
        *others, parameters = vectors
        named = dict(zip(names, others, strict=True))
        model = self.model.at(parameters)
        results = self.call.program(model).run(model, Inputs(**named))
        outputs = {name: results.outputs[name] for name in self.outputs}
        named[PARAMETERS] = parameters
        for vector in self.by:
            outputs |= _derivatives(outputs_of(outputs, self.outputs), vector, named[vector])
        return Results(outputs, results.checks)


@dataclass(frozen=True)
class BoundProgram:
    """A program of a live model, with the parameters as its second input.

    Attributes:
        model: the model.
        program: the program.
    """

    model: LiveModel
    program: Program

    def kernel(self, label: str) -> Kernel:
        """The program as functions of arrays."""
        first, *others = self.program.inputs
        sizes = [self.program.size(self.model, name) for name in self.program.inputs]

        def run(given: Scalars, parameters: Scalars, *vectors: Scalars) -> Results:
            named = dict(zip(others, vectors, strict=True))
            named[first] = given
            return self.program.run(self.model.at(parameters), Inputs(**named))

        return Kernel(run, [sizes[0], self.model.count, *sizes[1:]], label=label)


def outputs_of(outputs: Mapping[str, Any], names: Sequence[str]) -> dict[str, Any]:
    """Some of the outputs."""
    return {name: outputs[name] for name in names}


def derivative_name(output: str, vector: str) -> str:
    """Name of the derivative of an output."""
    return f"{output} by {vector}"


def _derivatives(outputs: Mapping[str, Any], vector: str, by: Scalars) -> dict[str, Any]:
    """The derivatives of outputs: each entry becomes a list along the vector."""
    flat = flatten([flatten(value) for value in outputs.values()])
    rows = iter(jacobian(flat, list(by)))
    result: dict[str, Any] = {}
    for name, value in outputs.items():
        result[derivative_name(name, vector)] = _with_rows(value, rows)
    return result


def _with_rows(value: Any, rows: Iterator[list[Scalar]]) -> Any:
    if isinstance(value, (list, tuple)):
        return [_with_rows(entry, rows) for entry in value]
    return next(rows)
