"""Conversion of trajectories in pieces, by a worker process."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

from ..services.table import TRAJECTORY_STEP, Service
from ..services.trajectory_steps import TrajectoryStep


class Run(Protocol):
    """Function that submits a call to a worker process."""

    def __call__(
        self,
        service: Service,
        request: Any,
        give: Callable[[Any], None],
        *,
        is_begun: bool = False,
    ) -> None:
        """Submit a call.

        Args:
            service: the service.
            request: its request.
            give: receives the response, in any thread.
            is_begun: whether the call continues a job, which is never refused for a full queue.
        """


class Stepwise:
    """One running conversion, piece by piece."""

    def __init__(
        self,
        run: Run,
        is_wanted: Callable[[], bool],
        on_step: Callable[[TrajectoryStep.Response], None],
        on_end: Callable[[TrajectoryStep.Response | None], None],
    ) -> None:
        """Store the arguments; `start` begins the conversion.

        Args:
            run: function that submits a call to a worker process.
            is_wanted: whether to continue; called after every piece.
            on_step: called with every piece except the last.
            on_end: called with the last piece, or with None if it was cancelled.
        """
        self._run, self._is_wanted = run, is_wanted
        self._on_step, self._on_end = on_step, on_end
        self._joints: Sequence[str] = ()

    def start(self, goal: Any, joints: Sequence[str] = ()) -> None:
        """Convert the trajectory of a goal or a request."""
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
