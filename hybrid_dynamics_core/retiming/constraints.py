"""Constraints along a path in s' and s'': a s'' + b s'^2 + c <= 0 near a given s'.

Forces of drives and accelerations of joints along a path are linear in s'' and s'^2, by the minimal
form. Viscous friction, powers and tables of efforts are not: their tangents are taken.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..closed_state.state import ClosedState, ClosureStatus
from ..dynamics.loads import Loads
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.units import effort_unit
from ..limits import Limits
from .curve import Curve
from .robot_interface import RetimedRobot

_SPEEDS = ("rate", "flow", "pump_flow")  # kinds of rows that grow with s' alone
_NO_EFFORT = 1e-9  # share of the largest effort that is rounding
_HALVINGS = 40  # of a stretch in which a rate changes its sign
_NEAR = 1e-3  # share of s'^2 over which slopes are taken


class Rows(NamedTuple):
    """Rows a s'' + b s'^2 + c <= 0 at each station: (N, k) each."""

    a: Array
    b: Array
    c: Array


class Constraints:
    """The constraints of a robot along a path."""

    def __init__(
        self,
        robot: RetimedRobot,
        curve: Curve,
        loads: Loads | None,
        near: ClosedState | None,
        share: float,
    ) -> None:
        """Collect the constraints.

        Args:
            robot: the robot.
            curve: the path.
            loads: loads besides the actuators; those of the description if None.
            near: state whose assembly modes are kept.
            share: share of each limit that is used.
        """
        self.robot = robot
        self.curve = curve
        self.limits = Limits(robot)
        self.loads = loads
        self.near = near
        self.share = share
        self._speed_rows: list[int] = []
        self._acceleration_rows: list[int] = []
        for k, row in enumerate(self.limits.rows):
            if row.kind in _SPEEDS:
                self._speed_rows.append(k)
            if row.kind == "acceleration":
                self._acceleration_rows.append(k)

    def state(self, s: Array, x: Array) -> ClosedState:
        """States (M,) at parameters (M,) with squares x (M,) of s'.

        Raises:
            InputError: a loop does not close.
        """
        u = self.curve.at(s)
        slope = self.curve.at(s, 1)
        du = slope * np.sqrt(x)[:, None]
        state = self.robot.close(u, du, check=False, near=self.near)
        bad = np.flatnonzero(np.atleast_1d(state.status) != ClosureStatus.OK)
        if bad.size:
            place = self.curve.between(float(s[bad[0]]))
            alone = self._error_at(u[bad[0]])
            raise InputError(f"{place}, a loop does not close: {alone}")
        return state

    def _error_at(self, u: Array) -> str:
        try:
            self.robot.close(u, near=self.near)
        except ArithmeticError as error:
            return " ".join(str(error).split())
        return "the loops are near a singular place"

    def residuals(self, s: Array, x: Array, dds: Array) -> Array:
        """Residuals (M, k), not above zero within limits; minus infinity without one.

        Args:
            s: parameters (M,).
            x: squares (M,) of s'.
            dds: s'' (M,).
        """
        state = self.state(s, x)
        slope = self.curve.at(s, 1)
        curvature = self.curve.at(s, 2)
        ddu = slope * dds[:, None] + curvature * x[:, None]
        tau = self.robot.inverse_dynamics(state, ddu, self.loads)
        forces = self.limits.forces(state, tau)
        lower, upper = self.limits.force_bounds(state)
        size = _sizes(lower, upper)
        parts = [forces - self.share * upper, self.share * lower - forces]
        parts = [part / size for part in parts]
        if self._acceleration_rows:
            all_values = self.limits.values(state, tau, ddu)
            values = all_values[:, self._acceleration_rows]
            most = np.array([self.limits.rows[k].upper for k in self._acceleration_rows])
            ratio = values / most
            parts += [ratio - self.share, -ratio - self.share]
        residuals = np.concatenate(parts, axis=1)
        return np.asarray(residuals)

    def check_idle(self, tau: Array) -> None:
        """Raise InputError where efforts (M, n) [N m, N] act along an idle coordinate."""
        largest = np.abs(tau).max(initial=0.0)
        for k, name in enumerate(self.robot.active):
            most = float(np.abs(tau[:, k]).max(initial=0.0))
            if name in self.robot.idle and most > _NO_EFFORT * largest:
                unit = effort_unit(self.robot.joint_types[name])
                problem = f"the path takes up to {most:.4g} {unit} along it, which no drive gives"
                raise InputError(f"{name} is idle: {problem}")

    def turns(self, dense: Array) -> Array:
        """Parameters at which a cylinder or drive turns back: its pressures jump there.

        Args:
            dense: ascending parameters (M,) between which turns are searched.
        """
        names = {*self.robot.description.actuators, *self.limits.drives}
        places = [k for k, name in enumerate(self.robot.coordinates) if name in names]
        rates = self._rates(dense)[:, places]
        changes = np.sign(rates[1:]) * np.sign(rates[:-1]) < 0.0
        index, which = np.nonzero(changes)
        low, high = dense[index], dense[index + 1]
        if not len(low):
            return low
        columns = np.array(places)[which]
        rows = np.arange(len(low))
        before = rates[index, which] > 0.0
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            same = (self._rates(middle)[rows, columns] > 0.0) == before
            low = np.where(same, middle, low)
            high = np.where(same, high, middle)
        return 0.5 * (low + high)

    def _rates(self, s: Array) -> Array:
        """Rates (M, n_s) of all coordinates at s' = 1."""
        return self.state(s, np.ones(len(s))).ds

    def fastest(self, s: Array) -> Array:
        """Largest squares (M,) of s' within rates and flows, infinite without such a limit."""
        ratio = self.speed_ratio(s, np.ones(len(s)))
        with np.errstate(divide="ignore"):
            return np.asarray((self.share / ratio) ** 2)

    def speed_ratio(self, s: Array, x: Array) -> Array:
        """Largest share (M,) of a limit of rates or flows."""
        if not self._speed_rows:
            return np.zeros(len(s))
        state = self.state(s, x)
        tau = np.zeros_like(state.u)
        values = np.abs(self.limits.values(state, tau))
        _, upper = self.limits.bounds(state)
        ratios = values[:, self._speed_rows] / upper[:, self._speed_rows]
        return np.asarray(ratios.max(axis=1))

    def rows(self, s: Array, x: Array) -> Rows:
        """Rows (N, k) that touch the constraints at squares x (N,) of s'."""
        zero = np.zeros(len(s))
        step = _NEAR * x
        here = self.residuals(s, x, zero)
        at_unit_dds = self.residuals(s, x, zero + 1.0)
        above = self.residuals(s, x + step, zero)
        below = self.residuals(s, x - step, zero)
        # what has no limit becomes the row -1 <= 0
        has_limit = np.isfinite(here) & np.isfinite(above) & np.isfinite(below)
        here = np.where(has_limit, here, -1.0)
        a = np.subtract(at_unit_dds, here, out=np.zeros_like(here), where=has_limit)
        rise = np.subtract(above, below, out=np.zeros_like(here), where=has_limit)
        b = rise / (2.0 * step[:, None])
        c = here - b * x[:, None]
        return Rows(a, b, c)

    def name_of(self, k: int) -> str:
        """The drive or joint of a residual."""
        drives = self.limits.drives
        if k < 2 * len(drives):
            return drives[k % len(drives)]
        place = (k - 2 * len(drives)) % len(self._acceleration_rows)
        return self.limits.rows[self._acceleration_rows[place]].name


def _sizes(lower: Array, upper: Array) -> Array:
    """Sizes (M, m) of ranges of forces; one where nothing limits."""
    ends = np.maximum(np.abs(lower), np.abs(upper))
    ends = np.where(np.isfinite(ends), ends, 0.0)
    largest = ends.max(axis=0, initial=0.0)
    sizes = np.where(largest > 0.0, largest, 1.0)
    return np.broadcast_to(sizes, lower.shape)
