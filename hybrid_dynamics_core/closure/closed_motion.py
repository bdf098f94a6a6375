"""From active to all coordinates: positions by the plan, then rates, accelerations, R and force projection.

With s = [u; z] and J_s s' = 0 (Chu (2020), Eq. 18):  s' = R u',  R = [E; -J_z^-1 J_u] (Eq. 20),
s'' = R u'' + R' u'. Each block needs only the coordinates before it, so nothing larger than a block
is inverted.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..algebra.linear import Inverse
from ..algebra.scalar import Scalar, sqrt
from ..mechanism.configuration import given_configuration
from ..mechanism.tree import Tree
from .constraints.equations import Linearised, LoopEquations
from .plan import ClosurePlan


class ClosedMotion:
    """The closed mechanism at given coordinates (u of the plan), on the branch signs given (one a step).

    `guess`: all coordinates s, where iterations start.
    """

    def __init__(
        self,
        tree: Tree,
        plan: ClosurePlan,
        u: Sequence[Scalar],
        branch: Sequence[Scalar],
        guess: Sequence[Scalar],
    ) -> None:
        self._tree = tree
        self.given = plan.given
        self.size = len(tree.coordinates)
        self.blocks = plan.blocks
        self.configuration = given_configuration(tree, dict(zip(plan.given, u, strict=True)))
        self.margins = [
            step.solve(self.configuration, sign, guess)
            for step, sign in zip(plan.blocks, branch, strict=True)
        ]
        self.loops = plan.loops
        self.residuals: list[Scalar] = []
        self.guards: list[Scalar] = []
        linear: dict[LoopEquations, Linearised] = {}
        for loop in dict.fromkeys(
            (*plan.loops, *(e.loop for step in plan.blocks for e in step.equations))
        ):
            linear[loop] = loop.linearise(self.configuration)
            self.residuals += linear[loop].residual
            self.guards += loop.guards(self.configuration)
        self.rows = [[linear[e.loop].rows[e.index] for e in step.equations] for step in plan.blocks]
        self.jacobians = [
            [[row.get(k, 0.0) for k in step.unknowns] for row in rows]
            for step, rows in zip(plan.blocks, self.rows, strict=True)
        ]
        self._inverses = [Inverse(block) for block in self.jacobians]
        self.surplus = [linear[e.loop].residual[e.index] for e in plan.redundant]

    def rates(self, du: Sequence[Scalar]) -> list[Scalar]:
        """s' from u'."""
        return self._complete(du, [[0.0] * len(step.unknowns) for step in self.blocks])

    def accelerations(self, ddu: Sequence[Scalar], ds: Sequence[Scalar]) -> list[Scalar]:
        """s'' from u'' and s'; with u'' = 0 this is R' u'."""
        biases: dict[LoopEquations, list[Scalar]] = {}
        for equation in (e for step in self.blocks for e in step.equations):
            if equation.loop not in biases:
                biases[equation.loop] = equation.loop.bias(self.configuration, ds)
        return self._complete(
            ddu, [[biases[e.loop][e.index] for e in step.equations] for step in self.blocks]
        )

    def _complete(self, given: Sequence[Scalar], bias: list[list[Scalar]]) -> list[Scalar]:
        values: list[Scalar] = [0.0] * self.size
        for k, value in zip(self.given, given, strict=True):
            values[k] = value
        for step, rows, inverse, extra in zip(
            self.blocks, self.rows, self._inverses, bias, strict=True
        ):
            rhs = []
            for row, term in zip(rows, extra, strict=True):
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
        n = len(self.given)
        columns = [self.rates([1.0 if i == j else 0.0 for i in range(n)]) for j in range(n)]
        return [list(row) for row in zip(*columns, strict=True)]

    def project(self, forces: Sequence[Scalar]) -> tuple[list[Scalar], list[list[Scalar]]]:
        """R^T f for tree forces f along s, and mu = J_z^-T f_z of each step (the multipliers are -mu)."""
        f = list(forces)
        multipliers: list[list[Scalar]] = []
        for step, rows, inverse in zip(
            self.blocks[::-1], self.rows[::-1], self._inverses[::-1], strict=True
        ):
            mu = inverse.solve_transposed([f[k] for k in step.unknowns])
            for row, m in zip(rows, mu, strict=True):
                for k, coefficient in row.items():
                    if k not in step.unknowns:
                        f[k] = f[k] - coefficient * m
            multipliers.append(mu)
        return [f[k] for k in self.given], multipliers[::-1]

    def iterations(self) -> Scalar:
        """Number of iterations of all steps together; 0 where everything has a closed form."""
        total: Scalar = 0.0
        for step, margin in zip(self.blocks, self.margins, strict=True):
            total = total + margin if step.iterates else total
        return total

    def distances(self) -> list[Scalar]:
        """Per step: distance to a singularity, 1 at best and 0 where J_z of the step is singular.

        A displacement counts in lengths of the loop, so the size of the robot does not matter.
        """
        result = []
        parts = zip(self.blocks, self.jacobians, self._inverses, self.margins, strict=True)
        for step, block, inverse, margin in parts:
            closed_form = len(block) == 1 and not step.iterates
            length = max(equation.loop.length for equation in step.equations)
            units = [1.0 if self._tree.is_revolute(k) else length for k in step.unknowns]
            result.append(sqrt(margin) if closed_form else inverse.conditioning(block, units))
        return result
