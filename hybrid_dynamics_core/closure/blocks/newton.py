"""Any block that has no closed form: Newton's method from a guess, with a bounded number of iterations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...algebra.numerics import newton
from ...algebra.scalar import Scalar, cos, sin
from ...mechanism.configuration import Posture
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

    def solve(self, posture: Posture, branch: Scalar, guess: Sequence[Scalar]) -> Scalar:  # noqa: ARG002
        """The margin is the number of iterations, negative if they did not converge."""
        parameters: list[Scalar] = []
        for k in self._known:
            parameters += (
                [posture.q[k], posture.c[k], posture.s[k]] if self._revolute[k] else [posture.q[k]]
            )
        *values, converged = newton(self.body, [guess[k] for k in self.unknowns], parameters)
        for k, value in zip(self.unknowns, values, strict=True):
            put = posture.set_angle if self._revolute[k] else posture.set_length
            put(k, value)
        return converged

    def body(self, unknowns: Sequence[Scalar], parameters: Sequence[Scalar]) -> list[Scalar]:
        """Residuals, then the Jacobian row by row."""
        posture = Posture(1 + max((*self._known, *self.unknowns)))
        given = iter(parameters)
        for k in self._known:
            posture.q[k] = next(given)
            if self._revolute[k]:
                posture.c[k], posture.s[k] = next(given), next(given)
        for k, value in zip(self.unknowns, unknowns, strict=True):
            posture.q[k] = value
            if self._revolute[k]:
                posture.c[k], posture.s[k] = cos(value), sin(value)
        residual, rows = [], []
        for loop in dict.fromkeys(equation.loop for equation in self.equations):
            block = loop.linearise(posture)
            for index in (e.index for e in self.equations if e.loop is loop):
                residual.append(block.residual[index])
                rows += [block.rows[index].get(k, 0.0) for k in self.unknowns]
        return [*residual, *rows]
