"""From active to all coordinates: positions, rates, accelerations, R and the projection of forces.

With s = [u; z] and J_s = [J_u, J_z] (Chu (2020), Eq. 16), J_s s' = 0 gives T = -J_z^-1 J_u
(Eq. 24), s' = R u' with R = [E; T] (Eq. 25), and s'' = R u'' + R' u' (Eq. 15). Each block needs
only the coordinates before it, so nothing larger than a block is inverted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..algebra.least_squares import LeastSquares
from ..algebra.linear import Rows, transposed, transposed_product, unit_vectors
from ..algebra.scalar import Scalar, Scalars, sqrt
from ..algebra.vector import add, scale
from ..mechanism.configuration import given_configuration
from ..mechanism.tree import Tree
from .blocks.block_solver import BlockSolver
from .constraints.equations import Equation, Linearised, LoopEquations, Row, coefficients, loops_of
from .plan import ClosurePlan, all_loops

# size of blocks, and most inputs, for which ratios of rates take the fewest operations
TRANSFERRED = 2
MOST_INPUTS = 2


class SolvedBlock:
    """A block of the plan at a closed configuration: its equations, linear in the rates.

    Attributes:
        solver: the block solver.
        margin: the margin that the solver gave.
        rows: rows of J_s of its equations, before their loops' `unit` is multiplied.
        jacobian: its part of J_z, (equations, unknowns), likewise.
        units: that factor of each equation; 1 if the rows have it.
        is_square: whether there are as many equations as unknowns, not more.
    """

    def __init__(
        self, solver: BlockSolver, margin: Scalar, rows: list[Row], units: Sequence[float] = ()
    ) -> None:
        self.solver = solver
        self.margin = margin
        self.rows = rows
        self.units = list(units) or [1.0] * len(rows)
        self.jacobian = [coefficients(row, solver.unknowns) for row in rows]
        self.is_square = len(rows) == len(solver.unknowns)
        self._system = LeastSquares(self.jacobian, solver.order)
        self._transfer = self._transferred()

    @property
    def equations(self) -> tuple[Equation, ...]:
        """Its equations."""
        return self.solver.equations

    def complete(self, values: list[Scalar], bias: Scalars) -> None:
        """Compute rates (or accelerations) of the unknowns from those of the coordinates before.

        Args:
            values: rates of all coordinates (n_s,); those of the unknowns are set.
            bias: terms of the equations besides J_s times the values, one for each equation.
        """
        rhs: list[Scalar] = []
        for row, term in zip(self.rows, bias, strict=True):
            total = term
            if not self._transfer:
                for k in self._inputs:
                    total = total + row.get(k, 0.0) * values[k]
            rhs.append(-total)
        solution = self._system.solve(rhs)
        for k, ratios in self._transfer.items():
            solution = list(add(solution, scale(values[k], ratios)))
        for k, value in zip(self.solver.unknowns, solution, strict=True):
            values[k] = value

    def project(self, forces: list[Scalar]) -> list[Scalar]:
        """Project the forces along the unknowns onto the coordinates before.

        Args:
            forces: along all coordinates (n_s,). Those before the block are changed.

        Returns:
            mu with J_z^T mu = f_z, one for each equation of `rows`; the least where there are more
            equations than unknowns.
        """
        along_unknowns = [forces[k] for k in self.solver.unknowns]
        multipliers = self._system.solve_transposed(along_unknowns)
        for k, ratios in self._transfer.items():
            for ratio, force in zip(ratios, along_unknowns, strict=True):
                forces[k] = forces[k] + ratio * force
        if not self._transfer:
            for row, multiplier in zip(self.rows, multipliers, strict=True):
                for k in self._inputs:
                    forces[k] = forces[k] - row.get(k, 0.0) * multiplier
        return multipliers

    def square_rows(self, size: int) -> Rows:
        """Rows of J_s (unknowns, size): of the equations, or of A^T times them if they are more."""
        rows: Rows = []
        for row, unit in zip(self.rows, self.units, strict=True):
            rows.append([unit * entry for entry in coefficients(row, range(size))])
        if self.is_square:
            return rows
        return transposed_product(self.jacobian, rows)

    def square_multipliers(self, multipliers: list[Scalar]) -> list[Scalar]:
        """The multipliers of `square_rows`, from those that `project` gives."""
        if self.is_square:
            return [m / unit for m, unit in zip(multipliers, self.units, strict=True)]
        return self._system.solve(multipliers)

    @property
    def _inputs(self) -> list[int]:
        """Coordinates of the equations besides the unknowns."""
        involved = dict.fromkeys(k for row in self.rows for k in row)
        return [k for k in involved if k not in self.solver.unknowns]

    def _transferred(self) -> dict[int, list[Scalar]]:
        """-J_z^-1 J_u by input, where it takes fewer operations than solving each time."""
        inputs = self._inputs
        sizes = len(self.rows), len(self.solver.unknowns)
        if sizes != (TRANSFERRED, TRANSFERRED) or len(inputs) > MOST_INPUTS:
            return {}
        transfer: dict[int, list[Scalar]] = {}
        for k in inputs:
            transfer[k] = self._system.solve([-row.get(k, 0.0) for row in self.rows])
        return transfer

    def distance(self, tree: Tree) -> Scalar:
        """Distance to a singularity: 1 at best, 0 where the Jacobian is singular.

        Displacements are divided by the loop's length, so the result does not depend on the robot's
        size.
        """
        if self._is_closed_form_of_one:
            return sqrt(self.margin)
        return self._system.conditioning(self._lengths(tree))

    def excess(self, tree: Tree, limit: float) -> Scalar:
        """A scalar that is positive if the distance to a singularity is above a limit.

        It takes no division up to two unknowns.
        """
        if self._is_closed_form_of_one:
            return self.margin - limit * limit
        return self._system.excess(self._lengths(tree), limit)

    @property
    def _is_closed_form_of_one(self) -> bool:
        return len(self.jacobian) == 1 and not self.solver.iterates

    def _lengths(self, tree: Tree) -> list[float]:
        """The unit of each unknown: 1 rad, or the loop's length."""
        length = self.solver.length
        if length is None:
            length = max(equation.loop.length for equation in self.equations)
        units: list[float] = []
        for k in self.solver.unknowns:
            unit = length
            if tree.is_revolute(k):
                unit = 1.0
            units.append(unit)
        return units


class ClosedMotion:
    """The closed mechanism at given coordinates.

    Attributes:
        given: the given coordinates of the plan.
        size: number of all coordinates, n_s.
        configuration: all coordinates.
        blocks: the blocks of the plan, solved.
        residuals: residuals of all equations, in lengths of their loops.
        guards: scalars that must be positive; none where a solver makes them so.
        surplus: residuals of the redundant equations.
    """

    def __init__(
        self,
        tree: Tree,
        plan: ClosurePlan,
        u: Scalars,
        branch: Scalars,
        guess: Scalars,
    ) -> None:
        """Close the mechanism.

        Args:
            tree: the spanning tree.
            plan: closure plan.
            u: the given coordinates of the plan (n,) [rad, m].
            branch: a sign for each block, then the chart of each ball or free joint, +1 or -1.
            guess: start of the iterations, all coordinates (n_s,) [rad, m].
        """
        self._tree = tree
        self.given = plan.given
        self.size = len(tree.coordinates)
        values = dict(zip(plan.given, u, strict=True))
        signs, charts = plan.split(branch)
        self.configuration = given_configuration(tree, values, charts)
        margins: list[Scalar] = []
        for block, sign in zip(plan.blocks, signs, strict=True):
            margins.append(block.solve(self.configuration, sign, guess))
        self.residuals: list[Scalar] = []
        self.guards: list[Scalar] = []
        linear: dict[LoopEquations, Linearised] = {}
        for loop in all_loops(plan.loops, plan.blocks):
            linear[loop] = loop.linearise(self.configuration)
            self.residuals += linear[loop].residual
        for loop in self._guarded(plan):
            self.guards += loop.guards(self.configuration)
        self.blocks: list[SolvedBlock] = []
        for block, margin in zip(plan.blocks, margins, strict=True):
            self.blocks.append(self._solved(block, margin, linear))
        self.surplus: list[Scalar] = []
        for equation in plan.redundant:
            residual = linear[equation.loop].residual
            self.surplus.append(residual[equation.index])

    def rates(self, du: Scalars) -> list[Scalar]:
        """s' from u'."""
        bias = [[0.0] * len(block.equations) for block in self.blocks]
        return self._complete(du, bias)

    def accelerations(self, ddu: Scalars, ds: Scalars) -> list[Scalar]:
        """s'' from u'' and s'; with u'' = 0 this is R' u'."""
        biases: dict[LoopEquations, list[Scalar]] = {}
        by_block: Rows = []
        for block in self.blocks:
            unscaled = _without_unit(block.solver)
            if unscaled is not None:
                by_block.append(unscaled.bias(self.configuration, ds))
                continue
            for loop in loops_of(block.equations):
                if loop not in biases:
                    biases[loop] = loop.bias(self.configuration, ds)
            terms = [biases[equation.loop][equation.index] for equation in block.equations]
            by_block.append(terms)
        return self._complete(ddu, by_block)

    def _complete(self, given: Scalars, bias: Rows) -> list[Scalar]:
        """Rates or accelerations of all coordinates."""
        values: list[Scalar] = [0.0] * self.size
        for k, value in zip(self.given, given, strict=True):
            values[k] = value
        for block, terms in zip(self.blocks, bias, strict=True):
            block.complete(values, terms)
        return values

    def _solved(
        self, block: BlockSolver, margin: Scalar, linear: Mapping[LoopEquations, Linearised]
    ) -> SolvedBlock:
        """A block with its rows; closed forms of one loop need no factor in them."""
        unscaled = _without_unit(block)
        if unscaled is None:
            rows = [linear[equation.loop].rows[equation.index] for equation in block.equations]
            return SolvedBlock(block, margin, rows)
        rows = unscaled.linearise(self.configuration).rows
        units = [equation.loop.unit for equation in block.equations]
        return SolvedBlock(block, margin, rows, units)

    def _guarded(self, plan: ClosurePlan) -> list[LoopEquations]:
        """The loops whose guards a solution may not meet."""
        met = [loops_of(block.equations) for block in plan.blocks if block.meets_guards]
        return [loop for loop in all_loops(plan.loops, plan.blocks) if [loop] not in met]

    def velocity_map(self) -> Rows:
        """R (n_s, n), Chu (2020), Eq. 25."""
        units = unit_vectors(len(self.given))
        return transposed([self.rates(unit) for unit in units])

    def project(self, forces: Scalars) -> tuple[list[Scalar], Rows]:
        """Project forces of the tree onto the given coordinates.

        Args:
            forces: f along s (n_s,).

        Returns:
            R^T f (n,), and mu = J_z^-T f_z of each block. The multipliers are -mu.
        """
        f = list(forces)
        multipliers = [block.project(f) for block in reversed(self.blocks)]
        return [f[k] for k in self.given], multipliers[::-1]

    def iterations(self) -> Scalar:
        """Number of iterations of all blocks together; 0 where everything has a closed form."""
        total: Scalar = 0.0
        for block in self.blocks:
            if block.solver.iterates:
                total = total + block.margin
        return total

    def distances(self) -> list[Scalar]:
        """Distance of each block to a singularity: 1 at best, 0 where it is singular."""
        return [block.distance(self._tree) for block in self.blocks]


def _without_unit(block: BlockSolver) -> LoopEquations | None:
    """The equations of a block without their unit, which cancels: for closed forms of one loop."""
    loop, *others = loops_of(block.equations)
    sizes = {len(block.equations), len(block.unknowns), loop.size}
    if block.iterates or others or len(sizes) > 1:
        return None
    return loop.unscaled()
