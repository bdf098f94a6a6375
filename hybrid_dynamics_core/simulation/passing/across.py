"""Integration across a change point, where the equations of motion are interpolated.

On one branch u'' is a smooth function of u, u' and the efforts. At the change point it is 0 / 0. So
it is evaluated at places on both sides, which differ from u along the motion, and interpolated.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ...closed_state.passages.crossing import Crossing, PassageKind
from ...closed_state.passages.interpolation import weights
from ...closed_state.passages.recorded import Passed
from ...closed_state.state import ClosedState, ClosureStatus
from ...dynamics.energy import Energy
from ...ground.arrays import Array
from ...robot.robot import Robot
from ..search import Step, bisected
from .anchors import Anchors
from .coordinates import Coordinates, Recorded

TINY = 1e-12
OUTERMOST = 0.95  # of the last place: up to there it is interpolated
SLACK = 1.1  # of the place of entry, where it is farther than the nearest places
STEPS = 4  # least number of steps between the places nearest to the change point
FIELDS = ("s", "ds", "R", "bias")


class AcrossPlace(Coordinates):
    """Coordinates of a motion across a change point.

    Args:
        base: the coordinates before it.
        crossing: the smooth way through it.
    """

    def __init__(
        self,
        base: Coordinates,
        crossing: Crossing,
    ) -> None:
        self.base = base
        self._crossing = crossing
        self._x = crossing.places.x
        self._states = base.robot.singular_places.states_of(crossing)
        self._motions = [base.robot.motion_near(state, base.loads) for state in self._states]
        names = [base.robot.loops.index(loop) for loop in self._singular_loops()]
        self._signs = np.ones((len(self._x), len(base.robot.loops)))
        self._signs[:, names] = np.sign(self._x)[:, None]
        super().__init__(
            base.robot,
            base.anchor,
            base.loads,
        )
        entry = abs(float(self.x_of(base.anchor.u)))
        self._reach = max(crossing.room, SLACK * entry)

    def _singular_loops(self) -> set[str]:
        names = self.base.robot.singular_places.block_names
        return {names[k] for k in self._crossing.blocks}

    @property
    def simulated(self) -> Robot:
        """The robot that is simulated."""
        return self.base.simulated

    def move_to(self, anchor: ClosedState) -> None:
        """Note the last state; the places stay as they are."""
        self.anchor = anchor

    def x_of(self, u: Array) -> Array:
        """Places (...) of active coordinates (..., n) along the motion; 0 at the change point."""
        line = self._crossing.line
        shares = (u - line.origin) @ line.way / (line.way @ line.way)
        return np.asarray(shares - self._crossing.share)

    def is_inside(self, u: Array) -> bool:
        """Whether u (n,) is so near to the change point that it is interpolated."""
        reach = min(self._reach, OUTERMOST * float(self._x[-1]))
        return abs(float(self.x_of(u))) < reach

    def leave(self, state: ClosedState) -> ClosedState:
        """The closed state on the side on which a state is."""
        nearest = int(np.abs(self._x - self.x_of(state.u)).argmin())
        return self.robot.close(
            state.u,
            state.du,
            near=self._states[nearest],
        )

    def longest(self, du: Array) -> float:
        """The longest step at rates du [s]: some steps for the room between the places."""
        way = self._crossing.line.way
        speed = abs(float(du @ way / (way @ way)))
        return 2.0 * self._crossing.room / STEPS / max(speed, TINY)

    def _beside(self, u: Array) -> Array:
        """u (N, n) moved along the motion to each place: (places, N, n)."""
        moves = self._x[:, None] - self.x_of(u)
        return np.asarray(u + moves[:, :, None] * self._crossing.line.way)

    def _weights(self, u: Array) -> Array:
        """Weights of the places (N, places) in values at u (N, n); NaN beyond the places."""
        rows: list[Array] = []
        for x in self.x_of(u).tolist():
            row = weights(self._x, x)
            if abs(x) > self._x[-1]:
                row = np.full_like(row, np.nan)
            rows.append(row)
        return np.array(rows)

    def _closed_beside(
        self,
        u: Array,
        du: Array,
    ) -> list[ClosedState]:
        """The states (N,) at each place, for u and du (N, n)."""
        states: list[ClosedState] = []
        for goal, near in zip(
            self._beside(u),
            self._states,
            strict=True,
        ):
            states.append(
                self.robot.close(
                    goal,
                    du,
                    check=False,
                    near=near,
                )
            )
        return states

    def near(
        self,
        u: Array,
        du: Array,
    ) -> ClosedState:
        """The states at u and u', (n,) or (N, n), interpolated."""
        if u.ndim == 1:
            return self._interpolated(u[None], du[None]).rows(0)
        return self._interpolated(u, du)

    def _interpolated(
        self,
        u: Array,
        du: Array,
    ) -> ClosedState:
        beside = self._closed_beside(u, du)
        shares = self._weights(u)
        fields: dict[str, Any] = {}
        for name in FIELDS:
            values = np.array([getattr(state, name) for state in beside])
            fields[name] = np.einsum(
                "km,mk...->k...",
                shares,
                values,
            )
        signed = np.array([state.distances for state in beside]) * self._signs[:, None]
        distances = np.abs(
            np.einsum(
                "km,mk...->k...",
                shares,
                signed,
            )
        )
        closed = np.isfinite(fields["s"]).all(axis=1)
        status = np.where(
            closed,
            ClosureStatus.OK,
            ClosureStatus.UNREACHABLE,
        )
        return replace(
            beside[0],
            u=u,
            du=du,
            residual=np.zeros(len(u)),
            distances=distances,
            status=status,
            **fields,
        )

    def motion(
        self,
        u: Array,
        du: Array,
        tau: Array,
    ) -> tuple[Array, float]:
        """u'' (n,) and power [W] at u, u' and efforts tau (n,), interpolated."""
        along = tau
        if self.base.simulated is not self.base.robot:
            along = self.base.efforts(self.near(u, du), tau)
        (shares,) = self._weights(u[None])
        ddu, power = np.zeros_like(u), 0.0
        for share, goal, motion in zip(
            shares,
            self._beside(u[None]),
            self._motions,
            strict=True,
        ):
            part, watts = motion(
                goal[0],
                du,
                along,
            )
            ddu = ddu + share * part
            power += share * watts
        return ddu, power

    def ordered(self, values: Array) -> Array:
        """Values of all coordinates (..., n_s), in the order of the simulated robot."""
        return self.base.ordered(values)

    def simulated_state(self, state: ClosedState) -> ClosedState:
        """A state of these coordinates, or a batch, in the active ones of the simulated robot."""
        if self.base.simulated is not self.base.robot:
            return self.base.simulated_state(state)
        if state.u.ndim == 1:
            return self.simulated_state(ClosedState.joined([state])).rows(0)
        is_beyond = self.x_of(state.u) > 0.0
        signs = np.where(
            is_beyond[:, None],
            self._crossing.beyond,
            self._crossing.before,
        )
        return self.simulated.singular_places.states_beside(state, signs)

    def passed(self, step: Step) -> list[tuple[float, Passed]]:
        """The change point, if it is passed in a step, with its time [s]."""
        n = len(self.anchor.u)

        def x_at(time: float) -> float:
            return float(self.x_of(step.dense(time)[:n]))

        begin, end = float(step.times[0]), float(step.times[-1])
        ahead = np.sign(x_at(end))
        if x_at(begin) * ahead >= 0.0:
            return []
        _, time = bisected(
            begin,
            end,
            lambda time: x_at(time) * ahead > 0.0,
        )
        return [(time, self._passage(step.at(time), is_ahead=ahead > 0.0))]

    def _passage(
        self,
        state: ClosedState,
        *,
        is_ahead: bool,
    ) -> Passed:
        """The passage at a state."""
        places = self.simulated.singular_places
        ends = [places.signs_at(self.ordered(s)) for s in self._crossing.places.s[[0, -1]]]
        if not is_ahead:
            ends.reverse()
        before, after = ends
        blocks = np.flatnonzero(before != after).tolist() or self._crossing.blocks.tolist()
        s, ds = self.ordered(state.s), self.ordered(state.ds)
        return Passed(
            PassageKind.CHANGE_POINT,
            blocks,
            s,
            ds,
            before,
            after,
        )

    def recorded(
        self,
        y: Array,
        _anchors: Anchors,
        tau: Array,
    ) -> Recorded:
        """What is recorded of samples."""
        n = len(self.anchor.u)
        u, du = y[:, :n], y[:, n : 2 * n]
        state = self.near(u, du)
        ddu = np.array(
            [
                self.motion(*row)[0]
                for row in zip(
                    u,
                    du,
                    tau,
                    strict=True,
                )
            ]
        )
        accelerations = (
            np.einsum(
                "kij,kj->ki",
                state.R,
                ddu,
            )
            + state.bias
        )
        shares = self._weights(u)
        parts = [self.robot.energy(beside, self.loads) for beside in self._closed_beside(u, du)]
        energies = np.einsum(
            "km,mek->ek",
            shares,
            np.array(parts),
        )
        active = self.ordered(accelerations)[:, :n]
        return Recorded(
            self.simulated_state(state),
            active,
            Energy(*energies),
        )
