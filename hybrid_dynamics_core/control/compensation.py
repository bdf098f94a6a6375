"""A controller that carries what its model does not know: efforts found by a momentum observer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ..closed_state.state import ClosedState
from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arguments import real_number, require_type
from .momentum_observer import MomentumObserver

Controller = Callable[[float, ClosedState], Array]


@dataclass(eq=False)
class ForceCompensation:
    """Adds to a controller what holds the external efforts, such as those of an unknown load.

    tau = controller(t, state) - share r, with the residual r of the observer. The observer takes
    this tau as the measured one. A call with an earlier time starts the observer anew; one with the
    same time does not change it.

    Attributes:
        controller: the controller, a function of time and state.
        observer: the momentum observer of the same robot, with the loads of the controller.
        share: from 0 for the controller alone to 1 for all.
        residual: (n,) the newest external efforts [N m, N].

    Raises:
        InputError: the share is not from 0 to 1.
    """

    controller: Controller
    observer: MomentumObserver
    share: float = 1.0
    residual: Array = field(init=False)
    _time: float = field(init=False, default=-np.inf)

    def __post_init__(self) -> None:
        require_type("observer", self.observer, MomentumObserver, "MomentumObserver(robot)")
        if not 0.0 <= real_number("share", self.share) <= 1.0:
            raise InputError(f"share is {self.share:g}; expected 0 to 1")
        self.residual = self.observer.residual

    def __call__(self, t: float, state: ClosedState) -> Array:
        """Efforts tau (n,) [N m or N] at a time [s] in a measured state."""
        wanted = self.controller(t, state)
        idle = [name in self.observer.robot.idle for name in self.observer.robot.active]
        tau = np.where(idle, 0.0, wanted - self.share * self.residual)
        if t < self._time:
            self.observer.reset()
        if t != self._time:
            self.residual = self.observer.step(t, state, tau)
        self._time = t
        return np.asarray(tau)
