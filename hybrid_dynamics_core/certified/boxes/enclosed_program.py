"""Programs in which the loops are closed by given boxes, and not by solving."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...algebra.scalar import Scalar, Scalars
from ...closure.blocks.block_solver import BlockSolver
from ...ground.arrays import Array
from ...kernels.graph import Graph
from ...mechanism.configuration import Configuration
from ...mechanism.tree import Tree
from ...programs import Inputs, Model, Program
from ..interval import Interval
from .graph_values import GraphValues, columns

CONFIGURATION, RATES, ACCELERATIONS = range(3)  # vectors of inputs


class EnclosedBlock(BlockSolver):
    """A block whose solution is given."""

    def __init__(
        self,
        block: BlockSolver,
        tree: Tree,
        values: Mapping[int, Scalar],
    ) -> None:
        """Take the equations of a block, and the values of its unknowns by coordinate."""
        self.equations = block.equations
        self.unknowns = block.unknowns
        self.iterates = block.iterates
        self.order = block.order
        self.meets_guards = True
        self._tree = tree
        self._values = values

    def solve(
        self,
        configuration: Configuration,
        branch: Scalar,  # noqa: ARG002
        guess: Scalars,  # noqa: ARG002
    ) -> Scalar:
        """Set the unknowns."""
        for k in self.unknowns:
            configuration.set_value(
                k,
                self._values[k],
                revolute=self._tree.is_revolute(k),
            )
        return 1.0


class EnclosedProgram:
    """An output of a program for boxes of all coordinates.

    Args:
        model: the robot.
        program: the program.
        signs: branch signs of the blocks, then the charts of ball and free joints.
        constants: further inputs of the program by name, and gravity.
        output: name of the output.
    """

    def __init__(
        self,
        model: Model,
        program: Program,
        signs: Sequence[float],
        constants: Mapping[str, Array],
        output: str,
    ) -> None:
        graph = Graph()
        count = len(model.plan.given)
        size = len(model.tree.coordinates)
        s = [graph.input(CONFIGURATION, k) for k in range(size)]
        given = {k: s[k] for k in model.plan.given}
        values = dict(enumerate(s))
        blocks = [EnclosedBlock(block, model.tree, values) for block in model.plan.blocks]
        plan = replace(model.plan, blocks=tuple(blocks))
        inputs = {name: constants[name].tolist() for name in program.inputs if name in constants}
        arguments = Inputs(
            u=list(given.values()),
            du=[graph.input(RATES, k) for k in range(count)],
            ddu=[graph.input(ACCELERATIONS, k) for k in range(count)],
            branch=list(signs),
            guess=[0.0] * size,
            **inputs,
        )
        results = program.run(replace(model, plan=plan), arguments)
        self._values = GraphValues(graph, results.outputs[output])

    def at(
        self,
        s: Interval,
        du: Array,
        ddu: Array,
    ) -> Interval:
        """The output (N, k) for N boxes of all coordinates (N, n_s), and rates (n,)."""
        count = len(s.lower)
        inputs: dict[tuple[int, int], Interval] = {}
        for k, value in enumerate(columns(s.lower, s.upper)):
            inputs[CONFIGURATION, k] = value
        for vector, values in (
            (RATES, du),
            (ACCELERATIONS, ddu),
        ):
            for k, rate in enumerate(values.tolist()):
                inputs[vector, k] = Interval(rate)
        results = self._values.at(inputs, count)
        lower = [np.broadcast_to(result.lower, count) for result in results]
        upper = [np.broadcast_to(result.upper, count) for result in results]
        return Interval(
            np.stack(lower, axis=1),
            np.stack(upper, axis=1),
        )
