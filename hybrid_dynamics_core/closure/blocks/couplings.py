"""Joints coupled by linear equations with constant coefficients, solved together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...algebra.independence import is_regular
from ...algebra.live import plain
from ...algebra.scalar import Scalar, Scalars
from ...mechanism.configuration import Configuration
from ..constraints.equations import Equation
from ..constraints.joint_coupling import JointCoupling
from .block_solver import BlockSolver


class CouplingsBlock(BlockSolver):
    """Block of k linear equations between coordinates, for k unknowns.

    Args:
        couplings: the equations.
        unknowns: indices of the coordinates that they determine.
        revolute: whether each unknown is an angle.

    Raises:
        ValueError: the equations do not determine the unknowns.
    """

    def __init__(
        self,
        couplings: Sequence[JointCoupling],
        unknowns: Sequence[int],
        revolute: Mapping[int, bool],
    ) -> None:
        self.couplings = tuple(couplings)
        self.equations = tuple(Equation(coupling, 0) for coupling in couplings)
        self.unknowns = tuple(unknowns)
        self._revolute = dict(revolute)
        matrix = np.array([[c.coefficients.get(k, 0.0) for k in unknowns] for c in couplings])
        matrix = plain(matrix)
        if not is_regular(matrix):
            raise ValueError("the couplings do not determine the unknowns")
        self._inverse = np.linalg.inv(matrix).tolist()

    def solve(self, configuration: Configuration, branch: Scalar, guess: Scalars) -> Scalar:
        """Set the unknowns. The block always closes."""
        remainders = [self._remainder(coupling, configuration) for coupling in self.couplings]
        for unknown, row in zip(self.unknowns, self._inverse, strict=True):
            value: Scalar = 0.0
            for factor, remainder in zip(row, remainders, strict=True):
                if factor:
                    value = value - factor * remainder
            configuration.set_value(unknown, value, revolute=self._revolute[unknown])
        return 1.0

    def _remainder(self, coupling: JointCoupling, configuration: Configuration) -> Scalar:
        """The sum of a coupling with all unknowns at zero."""
        total: Scalar = coupling.offset
        for k, coefficient in coupling.coefficients.items():
            if k not in self.unknowns:
                total = total + coefficient * configuration.q[k]
        return total
