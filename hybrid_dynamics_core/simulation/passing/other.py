"""Integration in other independent coordinates, where those of the robot turn back at a toggle.

Configurations near a toggle are a smooth manifold, and another joint parametrises it. With s' = R v
for its rates v, and P the rows of R that belong to the robot's own coordinates, u' = P v. Virtual
work gives the efforts along v: P^T tau.
"""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np

from ...closed_state.passages.crossing import PassageKind
from ...closed_state.passages.recorded import Passed
from ...closed_state.state import ClosedState, ClosureStatus
from ...dynamics.loads import JointEffects, Loads
from ...ground.arrays import Array
from ...robot.robot import Robot
from ..search import Step, bisected
from .anchors import Anchors
from .coordinates import Coordinates, Recorded


class OtherCoordinates(Coordinates):
    """Other independent coordinates of a robot.

    Args:
        simulated: the robot that is simulated.
        robot: the same mechanism with other active coordinates.
        anchor: closed state of that one to follow from.
        loads: loads besides the actuators; those of the description if None.
    """

    def __init__(
        self,
        simulated: Robot,
        robot: Robot,
        anchor: ClosedState,
        loads: Loads | None,
    ) -> None:
        acting = simulated.loads if loads is None else loads
        super().__init__(
            robot,
            anchor,
            _reordered(
                acting,
                simulated,
                robot,
            ),
        )
        self._simulated = simulated
        self._order = [robot.coordinates.index(name) for name in simulated.coordinates]
        self._active = self._order[: len(simulated.active)]

    @property
    def simulated(self) -> Robot:
        """The robot that is simulated."""
        return self._simulated

    def motion(
        self,
        u: Array,
        du: Array,
        tau: Array,
    ) -> tuple[Array, float]:
        """u'' (n,) and power [W] at u, u' and efforts tau (n,) of the simulated robot."""
        state = self.near(u, du)
        if state.status is not ClosureStatus.OK:
            return np.full_like(u, np.nan), np.nan
        return self.motion_from_anchor(
            u,
            du,
            self.efforts(state, tau),
        )

    def ordered(self, values: Array) -> Array:
        """Values of all coordinates (..., n_s), in the order of the simulated robot."""
        return values[..., self._order]

    def efforts(
        self,
        state: ClosedState,
        tau: Array,
    ) -> Array:
        """Efforts along these coordinates, from those of the simulated robot; (n,) or (N, n)."""
        rows = state.R[..., self._active, :]
        along: Array = np.einsum(
            "...ij,...i->...j",
            rows,
            tau,
        )
        return along

    def simulated_state(self, state: ClosedState) -> ClosedState:
        """A state of these coordinates, or a batch, in the active ones of the simulated robot."""
        if state.u.ndim == 1:
            return self._simulated_batch(ClosedState.joined([state])).rows(0)
        return self._simulated_batch(state)

    def _simulated_batch(self, state: ClosedState) -> ClosedState:
        places = self._simulated.singular_places
        s, ds = state.s[:, self._order], state.ds[:, self._order]
        n = len(self._active)
        velocity_map, bias = self._simulated_maps(state)
        signs = np.array([places.signs_at(row) for row in s])
        closed = replace(
            state,
            u=s[:, :n],
            du=ds[:, :n],
            s=s,
            ds=ds,
            R=velocity_map,
            bias=bias,
            signs=signs,
        )
        return places.states_beside(closed, signs)

    def _simulated_maps(self, state: ClosedState) -> tuple[Array, Array]:
        """R (N, n_s, n) and R' u' (N, n_s) of the simulated robot; NaN where u' says nothing."""
        maps = state.R[:, self._order]
        active = state.R[:, self._active]
        inverse = np.full_like(active, np.nan)
        regular = np.abs(np.linalg.det(active)) > 0.0
        inverse[regular] = np.linalg.inv(active[regular])
        velocity_map = maps @ inverse
        bias = state.bias[:, self._order]
        along = np.einsum(
            "kij,kj->ki",
            velocity_map,
            bias[:, : len(self._active)],
        )
        return velocity_map, bias - along

    def passed(self, step: Step) -> list[tuple[float, Passed]]:
        """The toggles that are passed in a step: where P is singular, with their times [s]."""
        turns = self._turn(step.states)
        times = step.times
        met: list[tuple[float, Passed]] = []
        for k in range(1, len(times)):
            if turns[k - 1] * turns[k] >= 0.0:
                continue
            time = self._time_of_turn(
                step,
                float(times[k - 1]),
                float(times[k]),
            )
            met.append((time, self._passage(step, time)))
        return met

    def _time_of_turn(
        self,
        step: Step,
        begin: float,
        end: float,
    ) -> float:
        """The time in an interval at which P is singular [s]."""
        sign = float(np.sign(self._turn(step.at(end))))

        def has_turned(time: float) -> bool:
            return sign * float(self._turn(step.at(time))) > 0.0

        _, time = bisected(
            begin,
            end,
            has_turned,
        )
        return time

    def _turn(self, state: ClosedState) -> Array:
        """det P, whose sign changes at a toggle."""
        return np.asarray(np.linalg.det(state.R[..., self._active, :]))

    def _passage(
        self,
        step: Step,
        time: float,
    ) -> Passed:
        """The passage at a time in a step."""
        state = step.at(time)
        places = self._simulated.singular_places
        rows = step.states.s[[0, -1]][:, self._order]
        before, after = places.signs_at(rows[0]), places.signs_at(rows[1])
        s = state.s[self._order]
        blocks = np.flatnonzero(before != after).tolist()
        return Passed(
            PassageKind.TOGGLE,
            blocks,
            s,
            state.ds[self._order],
            before,
            after,
        )

    def recorded(
        self,
        y: Array,
        anchors: Anchors,
        tau: Array,
    ) -> Recorded:
        """What is recorded of samples."""
        state = self.closed(y, anchors)
        ddv = self.robot.forward_dynamics(
            state,
            self.efforts(state, tau),
            self.loads,
        )
        accelerations = (
            np.einsum(
                "kij,kj->ki",
                state.R,
                ddv,
            )
            + state.bias
        )
        energy = self.robot.energy(state, self.loads)
        return Recorded(
            self.simulated_state(state),
            accelerations[:, self._active],
            energy,
        )


def _reordered(
    loads: Loads,
    simulated: Robot,
    robot: Robot,
) -> Loads:
    """Loads of a robot, along the same joints of another one."""
    order = [simulated.coordinates.index(name) for name in robot.coordinates]
    effects = asdict(loads.effects)
    along = {name: values[order] for name, values in effects.items()}
    return replace(loads, effects=JointEffects(**along))
