"""Conversions of trajectories, piece by piece in a process beside the node."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

from ..services.table import TRAJECTORY_STEP, Service
from ..services.trajectory_steps import TrajectoryStep


class Run(Protocol):
    """Has a call answered beside the stream."""

    def __call__(
        self,
        service: Service,
        request: Any,
        give: Callable[[Any], None],
        *,
        is_begun: bool = False,
    ) -> None:
        """Have it answered.

        Args:
            service: what is asked.
            request: its request.
            give: gets the response, in some thread.
            is_begun: whether it goes on with what was begun: then no queue is too long for it.
        """


class Stepwise:
    """One conversion at work."""

    def __init__(
        self,
        run: Run,
        is_wanted: Callable[[], bool],
        on_step: Callable[[TrajectoryStep.Response], None],
        on_end: Callable[[TrajectoryStep.Response | None], None],
    ) -> None:
        """Nothing begins before `start`.

        Args:
            run: has a call answered.
            is_wanted: whether to go on; asked after every piece.
            on_step: is told of every piece but the last.
            on_end: gets the last piece, or None where it is wanted no more.
        """
        self._run, self._is_wanted = run, is_wanted
        self._on_step, self._on_end = on_step, on_end
        self._joints: Sequence[str] = ()

    def start(self, goal: Any, joints: Sequence[str] = ()) -> None:
        """Convert what a goal or a request of the service asks for."""
        self._joints = joints
        self._run(TRAJECTORY_STEP, TrajectoryStep.Request(goal, None, joints), self._take)

    def _take(self, step: TrajectoryStep.Response) -> None:
        if not self._is_wanted():
            self._on_end(None)
        elif step.task is None:
            self._on_end(step)
        else:
            self._on_step(step)
            request = TrajectoryStep.Request(None, step.task, self._joints)
            self._run(TRAJECTORY_STEP, request, self._take, is_begun=True)
