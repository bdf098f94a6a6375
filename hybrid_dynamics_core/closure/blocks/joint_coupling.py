"""One joint from the joints that it follows."""

from __future__ import annotations

from ...algebra.scalar import Scalar, Scalars
from ...mechanism.configuration import Configuration
from ..constraints.equations import Equation
from ..constraints.joint_coupling import JointCoupling
from .block_solver import BlockSolver


class JointCouplingBlock(BlockSolver):
    """The one unknown of a linear equation between coordinates."""

    def __init__(self, coupling: JointCoupling, unknown: int, revolute: bool) -> None:
        self.coupling = coupling
        self.equations = (Equation(coupling, 0),)
        self.unknowns = (unknown,)
        self._revolute = revolute

    def solve(self, configuration: Configuration, branch: Scalar, guess: Scalars) -> Scalar:
        """Always closes."""
        (unknown,) = self.unknowns
        scale = -1.0 / self.coupling.coefficients[unknown]
        value: Scalar = self.coupling.offset * scale
        for k, coefficient in self.coupling.coefficients.items():
            if k != unknown:
                value = value + coefficient * scale * configuration.q[k]
        configuration.set_value(unknown, value, revolute=self._revolute)
        return 1.0
