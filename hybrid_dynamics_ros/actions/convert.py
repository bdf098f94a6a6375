"""The action ~/convert_trajectory: the service with feedback and cancellation."""

from __future__ import annotations

import math
from functools import partial
from typing import Any, Final

from hybrid_dynamics_msgs.action import ConvertTrajectory
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node

from ..services.answers import OK
from ..services.trajectory_steps import TrajectoryStep
from .goals import GoalServer, Outcome, tell
from .stepwise import Run, Stepwise

NAME: Final = "~/convert_trajectory"


class ConvertAction:
    """The action on a node."""

    def __init__(self, node: Node, run: Run) -> None:
        """Create the action server.

        Args:
            node: the node.
            run: has a call answered by a worker process.
        """
        self._run = run
        self._server = GoalServer(node, ConvertTrajectory, NAME, self._begin)

    def _begin(self, goal: ServerGoalHandle) -> None:
        work = Stepwise(
            self._run,
            lambda: not goal.is_cancel_requested,
            partial(self._on_step, goal),
            partial(self._on_end, goal),
        )
        work.start(goal.request)

    def _on_step(self, goal: ServerGoalHandle, step: TrajectoryStep.Response) -> None:
        feedback = ConvertTrajectory.Feedback(
            stage=step.stage,
            progress=step.progress,
            reached=step.reached,
            nearest_singularity=step.nearest,
        )
        tell(goal, feedback)

    def _on_end(self, goal: ServerGoalHandle, step: TrajectoryStep.Response | None) -> None:
        outcome = Outcome.CANCELED
        result = _empty()
        if step is not None:
            result = _result(step)
            outcome = Outcome.SUCCEEDED if result.error_code == OK else Outcome.ABORTED
        self._server.finish(goal, outcome, result)


def _empty() -> Any:
    return ConvertTrajectory.Result(
        first_bad=-1, first_bad_time=math.nan, nearest_singularity=math.nan
    )


def _result(step: TrajectoryStep.Response) -> Any:
    """The response of the service as a result of the action."""
    answer = step.answer
    if answer is None:
        result = _empty()
        result.error_code, result.error_text = step.error_code, step.error_text
        return result
    return ConvertTrajectory.Result(
        error_code=answer.error_code,
        error_text=answer.error_text,
        trajectory=answer.trajectory,
        first_bad=answer.first_bad,
        first_bad_time=answer.first_bad_time,
        nearest_singularity=answer.nearest_singularity,
    )
