"""A design: variables with bounds, a duty cycle, an objective and constraints, and its solution."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ..errors import InputError
from ..ground.arrays import Array, frozen
from ..ground.suggestions import no_such_name
from ..robot.robot import Robot
from .cycle import Cycle, Duty
from .program import Function, Functions, Goals, Program
from .solution import DesignResult, result_of
from .solvers import METHODS, Method

Bounds = Mapping[str, tuple[float, float]]


class Design:
    """A design problem of a robot.

    Attributes:
        names: names of the variables.
        lower: their lower bounds (k,).
        upper: their upper bounds (k,).
        start: their values in the description (k,).
    """

    def __init__(
        self,
        robot: Robot,
        variables: Bounds,
        duty: Sequence[Duty],
        given: Sequence[str] | None = None,
    ) -> None:
        """Check the variables and the duty cycle.

        Args:
            robot: the robot to start from.
            variables: (lower, upper) bound in SI units, by name of `parameters:` or path.
            duty: points of the duty cycle.
            given: coordinates that the points name; the active ones if None.

        Raises:
            InputError: a name is unknown, or a bound is not on its side of the start.
        """
        if not duty:
            raise InputError("a design needs at least one point of duty")
        self._robot = robot
        self._duty = tuple(duty)
        self.names = tuple(variables)
        self._family = robot.free(*self.names, given=given).interpreted()
        self._driven = self._family
        if self._family.coordinates != robot.active:
            self._driven = robot.free(*self.names).interpreted()
        self.start = self._family.values
        self.lower, self.upper = self._bounds(variables)
        self._reference = self._family.reference
        for point in self._duty:
            for name in (*point.at, *point.rates, *point.accelerations):
                if name not in self._family.coordinates:
                    raise InputError(
                        no_such_name("given coordinate", name, self._family.coordinates)
                    )

    def cycle(self, values: Sequence[float] | Array | None = None) -> Cycle:
        """The duty cycle at values (k,) of the variables; at the start if None."""
        at = self.start if values is None else np.asarray(values, dtype=np.float64)
        return Cycle(self._family, self._duty, self._reference, self._robot, at, self._driven)

    def minimise(
        self,
        objective: Function,
        at_least: Functions | None = None,
        equal: Functions | None = None,
        starts: int = 1,
        method: Method = "SLSQP",
    ) -> DesignResult:
        """The values of the variables with the least objective.

        Args:
            objective: function of the cycle, one number.
            at_least: functions of the cycle whose entries are zero or above, by name.
            equal: functions whose entries are zero, by name.
            starts: number of starts: the description, then points spread over the bounds.
            method: SciPy's SLSQP or trust-constr, or ipopt.

        Returns:
            The best design of all starts, with active constraints and their sensitivities.

        Raises:
            InputError: the loops do not close at the start, `starts` is below 1, or the solver is
                not installed.
        """
        goals = Goals(objective, at_least or {}, equal or {})
        return self._solved(goals, starts, method)

    def minimise_largest(
        self,
        objective: Function,
        at_least: Functions | None = None,
        equal: Functions | None = None,
        starts: int = 1,
        method: Method = "SLSQP",
    ) -> DesignResult:
        """The values of the variables for which the largest entry of a function is least.

        A further variable t is minimised, and no entry is above it. So gradients stay exact where
        the largest entry changes.

        Args:
            objective: function of the cycle, with entries of one unit.
            at_least: as in `minimise`.
            equal: as in `minimise`.
            starts: as in `minimise`.
            method: as in `minimise`.

        Returns:
            As `minimise`. The constraint `largest` has the entries that meet the bound.

        Raises:
            InputError: as in `minimise`.
        """
        goals = Goals(objective, at_least or {}, equal or {}, of_largest=True)
        return self._solved(goals, starts, method)

    def _solved(self, goals: Goals, starts: int, method: Method) -> DesignResult:
        if starts < 1:
            raise InputError(f"starts is {starts}; expected 1 or more")
        if method not in METHODS:
            raise InputError(no_such_name("method", method, METHODS))
        if not self.cycle().closes:
            raise InputError(
                "the loops do not close at every point of duty with the start's values"
            )
        program = Program(self.cycle, (self.lower, self.upper), self.start, goals)
        runs = [program.solve(start, method) for start in self._starts(starts)]
        return result_of(self._robot, self.names, program, runs)

    def has_limits(self, name: str) -> bool:
        """Whether a coordinate has limits on both sides in the description."""
        lower, upper = self._robot.description.joints[name].limits
        return math.isfinite(upper - lower)

    # -- variables

    def _bounds(self, variables: Bounds) -> tuple[Array, Array]:
        lower: list[float] = []
        upper: list[float] = []
        if len(self._family.names) != len(self.names):
            raise InputError("a variable is one number; name each number of a list by its index")
        for name, start in zip(self.names, self.start, strict=True):
            low, high = (float(bound) for bound in variables[name])
            if not low <= start <= high or not math.isfinite(high - low):
                raise InputError(
                    f"{name}: bounds [{low:g}, {high:g}] do not contain its value {start:g}"
                )
            if low == high:
                raise InputError(f"{name}: bounds [{low:g}, {high:g}] leave no room")
            lower.append(low)
            upper.append(high)
        return frozen(lower), frozen(upper)

    def _starts(self, count: int) -> list[Array]:
        """The description's values, then a fixed set of others within the bounds."""
        from scipy.stats import qmc  # noqa: PLC0415  slow to import

        starts = [np.array(self.start)]
        room = self.upper - self.lower
        sequence = qmc.Halton(len(self.names), seed=0)
        for _ in range(count - 1):
            (point,) = sequence.random(1)
            starts.append(self.lower + room * point)
        return starts
