"""Closed states that follow a changed geometry to first order."""

from __future__ import annotations

import numpy as np

from ..ground.arrays import Array
from .closed_rows import ClosedRows, Geometry, applied, inverse_of, others

# gap per relative change of the geometry [lengths of the loop] above which the loops do not follow
_UNFIT = 1e-4


class OverdeterminedLoopError(ArithmeticError):
    """A loop has more equations than unknowns, and does not close with the changed geometry."""


class FirstOrderMotion:
    """The passive coordinates follow by the implicit function of the closure.

    Attributes:
        rows: N closed states, at which the Jacobian is taken.
    """

    def __init__(self, rows: ClosedRows, given: Array) -> None:
        """Take the Jacobian.

        Args:
            rows: N closed states.
            given: indices of the given coordinates (n,).
        """
        self.rows = rows
        self._given = given
        self._unknowns = others(given, rows.s)
        _, jacobian = rows.geometry.linearised(rows.s, rows.charts)
        self._jacobian = jacobian[:, :, self._unknowns]
        self._inverse = inverse_of(self._jacobian)

    def moved(self, geometry: Geometry, values: Array, step: float) -> ClosedRows:
        """The states of a geometry that differs a little.

        Args:
            geometry: the changed geometry.
            values: the given coordinates (N, n) [rad, m].
            step: size of the change, as a share of the reach or in rad.

        Raises:
            OverdeterminedLoopError: a loop with more equations than unknowns stays open.
        """
        charts = self.rows.charts
        s = self.rows.s.copy()
        s[:, self._given] = values
        gaps, _ = geometry.linearised(s, charts)
        follow = applied(self._inverse, gaps)
        remaining = gaps - applied(self._jacobian, follow)
        if np.abs(remaining).max(initial=0.0) > _UNFIT * step:
            raise OverdeterminedLoopError
        s[:, self._unknowns] -= follow
        return ClosedRows(geometry, s, charts)
