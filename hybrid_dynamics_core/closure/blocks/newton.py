"""Blocks without a closed form: Newton's method from a guess, with bounded iterations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...algebra.linear import pivot_order
from ...algebra.numerics import newton
from ...algebra.scalar import Scalar, Scalars
from ...mechanism.configuration import Configuration, with_turns
from ..constraints.equations import Equation, coefficients, loops_of
from .block_solver import BlockSolver


class NewtonBlock(BlockSolver):
    """Equations of any loops, solved together. The guess decides the assembly mode."""

    modes = ("reference",)
    iterates = True

    def __init__(
        self, equations: Sequence[Equation], unknowns: Sequence[int], revolute: Mapping[int, bool]
    ) -> None:
        self.equations = tuple(equations)
        self.unknowns = tuple(unknowns)
        self._revolute = revolute
        self._inputs = self.inputs
        angles = frozenset(k for k in self.unknowns if revolute[k])
        self._free_to_turn = angles - self.counted_turns

    def solve(self, configuration: Configuration, branch: Scalar, guess: Scalars) -> Scalar:
        """The margin is the number of iterations, negative if they did not converge."""
        parameters: list[Scalar] = []
        for k in self._inputs:
            parameters.append(configuration.q[k])
            if self._revolute[k]:
                parameters += [configuration.c[k], configuration.s[k]]
        parameters += configuration.charts
        start = [guess[k] for k in self.unknowns]
        *values, iterations = newton(self.residuals_and_jacobian, start, parameters)
        for k, value in zip(self.unknowns, values, strict=True):
            nearest = with_turns(value, guess[k]) if k in self._free_to_turn else value
            configuration.set_value(k, nearest, revolute=self._revolute[k])
        return iterations

    def residuals_and_jacobian(self, unknowns: Scalars, parameters: Scalars) -> list[Scalar]:
        """The function that Newton's method calls: residuals, then the Jacobian row by row."""
        configuration = self._configuration(unknowns, parameters)
        residuals: list[Scalar] = []
        entries: list[Scalar] = []
        linear = {loop: loop.linearise(configuration) for loop in loops_of(self.equations)}
        for k in self.order or range(len(self.equations)):
            equation = self.equations[k]
            of_loop = linear[equation.loop]
            residuals.append(of_loop.residual[equation.index])
            entries += coefficients(of_loop.rows[equation.index], self.unknowns)
        return [*residuals, *entries]

    def choose_order(self, configuration: Configuration) -> None:
        """Choose the `order` by elimination at a configuration of floats."""
        rows: list[list[float]] = []
        for equation in self.equations:
            row = equation.loop.linearise(configuration).rows[equation.index]
            rows.append([float(entry) for entry in coefficients(row, self.unknowns)])
        self.order = pivot_order(np.array(rows))

    def _configuration(self, unknowns: Scalars, parameters: Scalars) -> Configuration:
        """A configuration with only the block's coordinates set."""
        configuration = Configuration(1 + max((*self._inputs, *self.unknowns)))
        remaining = iter(parameters)
        for k in self._inputs:
            configuration.q[k] = next(remaining)
            if self._revolute[k]:
                configuration.c[k] = next(remaining)
                configuration.s[k] = next(remaining)
        configuration.charts = tuple(remaining)
        for k, value in zip(self.unknowns, unknowns, strict=True):
            configuration.set_value(k, value, revolute=self._revolute[k])
        return configuration
