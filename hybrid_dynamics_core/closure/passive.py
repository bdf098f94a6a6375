"""From active to all coordinates: positions by the plan, then rates, accelerations, R and force projection.

With s = [u; z] and J_s s' = 0 (Chu (2020), Eq. 18):  s' = R u',  R = [E; -J_z^-1 J_u] (Eq. 20),
s'' = R u'' + R' u'. Each block needs only the coordinates before it, so nothing larger than a block is inverted.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..algebra.linear import Inverse
from ..algebra.scalar import Scalar
from ..mechanism.tree import Tree
from .plan import ClosurePlan, given_posture
from .step import Linearised


class ClosedMotion:
    """The closed mechanism at active coordinates u (n scalars), on the branch signs given (one a block)."""

    def __init__(self, tree: Tree, plan: ClosurePlan, u: Sequence[Scalar], branch: Sequence[Scalar]) -> None:
        self.n = tree.n_active
        self.size = len(tree.coordinates)
        self.steps = plan.steps
        self.posture = given_posture(tree, list(u))
        self.margins: list[Scalar] = []
        self.blocks: list[Linearised] = []
        self._inverses: list[Inverse] = []
        for step, sign in zip(plan.steps, branch, strict=True):
            self.margins.append(step.solve(self.posture, sign))
            block = step.linearise(self.posture)
            self.blocks.append(block)
            self._inverses.append(Inverse([[row.get(k, 0.0) for k in step.unknowns] for row in block.rows]))

    def rates(self, du: Sequence[Scalar]) -> list[Scalar]:
        """s' from u'."""
        return self._complete(list(du), [[0.0] * len(step.unknowns) for step in self.steps])

    def accelerations(self, ddu: Sequence[Scalar], ds: Sequence[Scalar]) -> list[Scalar]:
        """s'' from u'' and s'; with u'' = 0 this is R' u'."""
        return self._complete(list(ddu), [step.bias(self.posture, ds) for step in self.steps])

    def _complete(self, known: list[Scalar], bias: list[list[Scalar]]) -> list[Scalar]:
        values: list[Scalar] = known + [0.0] * (self.size - self.n)
        for step, block, inverse, extra in zip(self.steps, self.blocks, self._inverses, bias, strict=True):
            rhs = []
            for row, term in zip(block.rows, extra, strict=True):
                total = term
                for k, coefficient in row.items():
                    if k not in step.unknowns:
                        total = total + coefficient * values[k]
                rhs.append(-total)
            for k, value in zip(step.unknowns, inverse.solve(rhs), strict=True):
                values[k] = value
        return values

    def velocity_map(self) -> list[list[Scalar]]:
        """R (rows in the order of s), Chu (2020), Eq. 20."""
        columns = [self.rates([1.0 if i == j else 0.0 for i in range(self.n)]) for j in range(self.n)]
        return [list(row) for row in zip(*columns, strict=True)]

    def project(self, forces: Sequence[Scalar]) -> tuple[list[Scalar], list[list[Scalar]]]:
        """R^T f for tree forces f along s, and mu = J_z^-T f_z of each block (the multipliers are -mu)."""
        f = list(forces)
        multipliers: list[list[Scalar]] = []
        for step, block, inverse in zip(self.steps[::-1], self.blocks[::-1], self._inverses[::-1], strict=True):
            mu = inverse.solve_transposed([f[k] for k in step.unknowns])
            for row, m in zip(block.rows, mu, strict=True):
                for k, coefficient in row.items():
                    if k not in step.unknowns:
                        f[k] = f[k] - coefficient * m
            multipliers.append(mu)
        return f[: self.n], multipliers[::-1]

    def determinants(self) -> list[tuple[Scalar, Scalar]]:
        """Per block: determinant of its J_z and the squared Frobenius norm, for the distance to a singularity."""
        result = []
        for step, block, inverse in zip(self.steps, self.blocks, self._inverses, strict=True):
            squares: Scalar = 0.0
            for row in block.rows:
                for k in step.unknowns:
                    entry = row.get(k, 0.0)
                    squares = squares + entry * entry
            result.append((inverse.determinant, squares))
        return result
