"""Blocks without a closed form: Newton's method from a guess, with bounded iterations.

Redundant equations are solved with the others by Gauss-Newton: Newton's method on A^T r = 0 with
A^T A for its Jacobian, where r are the residuals and A is their Jacobian.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain

import numpy as np

from ...algebra.linear import pivot_order, transposed_product
from ...algebra.numerics import newton
from ...algebra.scalar import Scalar, Scalars, absolute
from ...mechanism.configuration import Configuration, with_turns
from ..constraints.equations import OPEN, Equation, coefficients, loops_of
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
        parameters += [*configuration.charts, *self.iterated_with()]
        start = [guess[k] for k in self.unknowns]
        *values, iterations = newton(self.residuals_and_jacobian, start, parameters)
        for k, value in zip(self.unknowns, values, strict=True):
            nearest = with_turns(value, guess[k]) if k in self._free_to_turn else value
            configuration.set_value(k, nearest, revolute=self._revolute[k])
        if len(self.equations) > len(self.unknowns):
            return _smaller(iterations, self._closes(configuration) * absolute(iterations))
        return iterations

    def iterated_with(self) -> list[Scalar]:
        """Further parameters of the iteration, besides coordinates."""
        return []

    def _closes(self, configuration: Configuration) -> Scalar:
        """1 if all equations hold, -1 if not: least squares may end where they do not."""
        sign: Scalar = 1.0
        for loop in loops_of(self.equations):
            residual = loop.linearise(configuration).residual
            for equation in self.equations:
                if equation.loop is loop:
                    slack = OPEN - absolute(residual[equation.index])
                    sign = _smaller(sign, slack / absolute(slack))
        return sign

    def residuals_and_jacobian(self, unknowns: Scalars, parameters: Scalars) -> list[Scalar]:
        """The function that Newton's method calls: residuals, then the Jacobian row by row."""
        configuration = self._configuration(unknowns, parameters)
        residuals: list[Scalar] = []
        rows: list[list[Scalar]] = []
        linear = {loop: loop.linearise(configuration) for loop in loops_of(self.equations)}
        for k in self.order or range(len(self.equations)):
            equation = self.equations[k]
            of_loop = linear[equation.loop]
            residuals.append(of_loop.residual[equation.index])
            rows.append(coefficients(of_loop.rows[equation.index], self.unknowns))
        if len(rows) > len(self.unknowns):
            columns = [[residual] for residual in residuals]
            residuals = [total for (total,) in transposed_product(rows, columns)]
            rows = transposed_product(rows, rows)
        return [*residuals, *chain.from_iterable(rows)]

    def choose_order(self, configuration: Configuration) -> None:
        """Choose the `order` by elimination at a configuration of floats.

        Least squares need none: the largest entries of A^T A are on its diagonal.
        """
        if len(self.equations) > len(self.unknowns):
            return
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


def _smaller(a: Scalar, b: Scalar) -> Scalar:
    return 0.5 * (a + b - absolute(a - b))
