"""Any block that has no closed form: Newton's method from a guess, with a bounded number of iterations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...algebra.numerics import newton
from ...algebra.scalar import Scalar, cos, sin
from ...mechanism.configuration import Configuration
from ..constraints.equations import Equation
from .block_solver import Step


class NewtonStep(Step):
    """Equations of any loops, solved together; the branch is where the guess leads."""

    modes = ("reference",)
    iterates = True

    def __init__(
        self, equations: Sequence[Equation], unknowns: Sequence[int], revolute: Mapping[int, bool]
    ) -> None:
        self.equations = tuple(equations)
        self.unknowns = tuple(unknowns)
        self._revolute = revolute
        self._known = self.known

    def solve(
        self,
        configuration: Configuration,
        branch: Scalar,  # noqa: ARG002
        guess: Sequence[Scalar],
    ) -> Scalar:
        """The margin is the number of iterations, negative if they did not converge."""
        parameters: list[Scalar] = []
        for k in self._known:
            parameters += (
                [configuration.q[k], configuration.c[k], configuration.s[k]]
                if self._revolute[k]
                else [configuration.q[k]]
            )
        *values, converged = newton(self.body, [guess[k] for k in self.unknowns], parameters)
        for k, value in zip(self.unknowns, values, strict=True):
            put = configuration.set_angle if self._revolute[k] else configuration.set_length
            put(k, value)
        return converged

    def body(self, unknowns: Sequence[Scalar], parameters: Sequence[Scalar]) -> list[Scalar]:
        """Residuals, then the Jacobian row by row."""
        configuration = Configuration(1 + max((*self._known, *self.unknowns)))
        given = iter(parameters)
        for k in self._known:
            configuration.q[k] = next(given)
            if self._revolute[k]:
                configuration.c[k], configuration.s[k] = next(given), next(given)
        for k, value in zip(self.unknowns, unknowns, strict=True):
            configuration.q[k] = value
            if self._revolute[k]:
                configuration.c[k], configuration.s[k] = cos(value), sin(value)
        residual, rows = [], []
        for loop in dict.fromkeys(equation.loop for equation in self.equations):
            block = loop.linearise(configuration)
            for index in (e.index for e in self.equations if e.loop is loop):
                residual.append(block.residual[index])
                rows += [block.rows[index].get(k, 0.0) for k in self.unknowns]
        return [*residual, *rows]
