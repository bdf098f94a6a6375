"""One goal of the proxy, from conversion to its end."""

from __future__ import annotations

from collections.abc import Callable, Collection
from functools import partial
from threading import Lock
from typing import Any, Final

from action_msgs.msg import GoalStatus
from hybrid_dynamics_msgs.srv import ConvertTrajectory
from rclpy.action.client import ActionClient
from rclpy.node import Node

from ..services.answers import OK
from ..services.table import POINTS_OF_JOINTS
from ..services.trajectory_steps import PointsOfJoints, TrajectoryStep
from .follow_tolerances import active_tolerances
from .goals import GoalServer, Outcome, tell
from .stepwise import Run, Stepwise

_OUTCOMES: Final = {
    GoalStatus.STATUS_SUCCEEDED: Outcome.SUCCEEDED,
    GoalStatus.STATUS_CANCELED: Outcome.CANCELED,
}


class Controller:
    """The client of the controller's action, called in threads of the executor."""

    def __init__(self, node: Node, kind: Any, name: str) -> None:
        """Create the client; the controller may start later.

        Args:
            node: the node.
            kind: type of the action.
            name: name of the action.
        """
        self.kind, self.name, self._node = kind, name, node
        self._client = ActionClient(node, kind, name)

    @property
    def is_there(self) -> bool:
        """Whether the action server is available."""
        return bool(self._client.server_is_ready())

    def send(self, goal: Any, on_feedback: Callable[[Any], None], on_answer: Any) -> None:
        """Send a goal; `on_answer` gets the future of the controller's response."""

        def send_now() -> None:
            future = self._client.send_goal_async(goal, on_feedback)
            future.add_done_callback(on_answer)

        self.later(send_now)

    def later(self, work: Callable[[], None]) -> None:
        """Call a function in a thread of the executor."""
        if self._node.executor is not None:
            self._node.executor.create_task(work)

    def destroy(self) -> None:
        """Destroy the client."""
        self._client.destroy()


class FollowedGoal:
    """A goal in progress."""

    def __init__(self, server: GoalServer, controller: Controller, handle: Any, run: Run) -> None:
        """Store the arguments; `begin` sends the goal.

        Args:
            server: server of the proxy.
            controller: client of the controller.
            handle: handle of the goal.
            run: has a call answered by a worker process.
        """
        self._server, self._controller, self._handle, self._run = server, controller, handle, run
        self._sent: Any = None  # the controller's goal handle
        self._lock = Lock()
        self._is_translating = False  # a feedback is being converted
        self.ended: Callable[[], Any] = lambda: None

    def begin(self, joints: Collection[str]) -> None:
        """Convert the goal, then send it.

        Args:
            joints: all joints that it may name.
        """
        goal, kind = self._handle.request, self._controller.kind.Result
        unknown = [name for name in goal.trajectory.joint_names if name not in joints]
        if unknown:
            text = f"there is no joint '{unknown[0]}'; known: {', '.join(sorted(joints))}"
            self._abort(kind.INVALID_JOINTS, text)
        elif goal.multi_dof_trajectory.points:
            self._abort(kind.INVALID_GOAL, "trajectories of joints with one freedom are taken")
        else:
            work = Stepwise(self._run, self._is_wanted, lambda _: None, self._on_converted)
            request = ConvertTrajectory.Request(joints=goal.trajectory)
            work.start(request, tuple(goal.trajectory.joint_names))

    def cancel(self) -> None:
        """Cancel the goal, also at the controller if it has it."""
        if self._sent is not None:
            self._controller.later(self._sent.cancel_goal_async)

    def _is_wanted(self) -> bool:
        return not self._handle.is_cancel_requested

    def _on_converted(self, step: TrajectoryStep.Response | None) -> None:
        kind = self._controller.kind.Result
        if step is None:
            self._end(Outcome.CANCELED, kind())
        elif step.answer is None:
            self._abort(kind.INVALID_GOAL, step.error_text)
        elif step.answer.error_code != OK:
            self._abort(kind.INVALID_GOAL, step.answer.error_text)
        elif not self._controller.is_there:
            text = f"nobody offers the action {self._controller.name}: is the controller active?"
            self._abort(kind.INVALID_GOAL, text)
        else:
            self._controller.send(self._goal_of(step), self._on_feedback, self._on_answer)

    def _goal_of(self, step: TrajectoryStep.Response) -> Any:
        """The goal in active joints."""
        asked, answer = self._handle.request, step.answer
        goal = self._controller.kind.Goal()
        if answer is not None:
            goal.trajectory = answer.trajectory
        goal.goal_time_tolerance = asked.goal_time_tolerance
        if step.maps is not None:
            maps = step.maps
            goal.path_tolerance = active_tolerances(asked.path_tolerance, maps, maps.on_the_way)
            goal.goal_tolerance = active_tolerances(asked.goal_tolerance, maps, maps.at_the_end)
        return goal

    def _on_answer(self, future: Any) -> None:
        sent = future.result()
        if not sent.accepted:
            text = f"{self._controller.name} did not accept the trajectory"
            self._abort(self._controller.kind.Result.INVALID_GOAL, text)
            return
        self._sent = sent
        sent.get_result_async().add_done_callback(self._on_result)
        if not self._is_wanted():  # cancelled in the meantime
            sent.cancel_goal_async()

    def _on_result(self, future: Any) -> None:
        response = future.result()
        outcome, result = _OUTCOMES.get(response.status, Outcome.ABORTED), response.result
        if outcome is Outcome.CANCELED and self._is_wanted():
            outcome = Outcome.ABORTED
            result.error_string = f"{self._controller.name} was cancelled by somebody else"
        self._end(outcome, result)

    def _on_feedback(self, message: Any) -> None:
        """Convert feedback in a worker process; feedback that arrives meanwhile is dropped."""
        with self._lock:
            if self._is_translating:
                return
            self._is_translating = True
        feedback, joints = message.feedback, self._handle.request.trajectory.joint_names
        points = [feedback.desired, feedback.actual]
        request = PointsOfJoints.Request(feedback.joint_names, points, joints)
        self._run(POINTS_OF_JOINTS, request, partial(self._on_translated, feedback))

    def _on_translated(self, feedback: Any, response: PointsOfJoints.Response) -> None:
        self._is_translating = False
        if response.error_code != OK:
            return
        desired, actual = response.points
        translated = self._controller.kind.Feedback(
            header=feedback.header,
            joint_names=self._handle.request.trajectory.joint_names,
            desired=desired,
            actual=actual,
            error=_difference(desired, actual),
        )
        tell(self._handle, translated)

    def _abort(self, code: int, text: str) -> None:
        result = self._controller.kind.Result(error_code=code, error_string=text)
        self._end(Outcome.ABORTED, result)

    def _end(self, outcome: Outcome, result: Any) -> None:
        self.ended()
        self._server.finish(self._handle, outcome, result)


def _difference(desired: Any, actual: Any) -> Any:
    """Desired minus actual values, where both are given."""
    error = type(desired)(time_from_start=actual.time_from_start)
    for part in ("positions", "velocities", "accelerations"):
        wanted, reached = getattr(desired, part), getattr(actual, part)
        if len(wanted) == len(reached):
            pairs = zip(wanted, reached, strict=True)
            setattr(error, part, [one - other for one, other in pairs])
    return error
