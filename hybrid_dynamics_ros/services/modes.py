"""Services: assembly modes, and description of the robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from hybrid_dynamics_msgs.msg import AssemblyMode
from hybrid_dynamics_msgs.srv import DescribeRobot, ListAssemblyModes, SwitchAssemblyMode
from std_msgs.msg import Header

from hybrid_dynamics_core import ClosedState, HybridDynamicsError, Robot
from hybrid_dynamics_core.closed_state.assembly_modes import no_such_mode
from hybrid_dynamics_core.ground.suggestions import no_such_name, suggestion
from hybrid_dynamics_core.ground.wording import counted, one_line

from ..messages import conversions
from ..messages.joint_samples import FloatArray, RejectedError, RejectionCode
from ..stream.conditions import NewMode
from ..stream.floating.first_charts import in_file_charts, in_first_charts
from ..stream.stroke_margins import joint_limits
from .context import ServiceContext

_MOST_LISTED: Final = 12  # modes of a loop listed in a text
_TOLERANCE: Final = 1e-6  # [rad or m] configurations closer than this are the same


def list_assembly_modes(
    context: ServiceContext,
    request: ListAssemblyModes.Request,
    response: ListAssemblyModes.Response,
) -> None:
    """All assembly modes at given active coordinates."""
    robot, given = context.robot, request.active_joints
    if given.name or given.position:
        u = context.active_motion(given).position
    else:
        u = context.newest(", or name the active joints in the call")
    modes = robot.assembly_modes(in_file_charts(robot, u))
    if not modes:
        raise RejectedError(RejectionCode.UNREACHABLE, _why_not(context, u))
    response.modes = [_message(robot, mode.state) for mode in modes]
    response.current = _current(context, u, [mode.state for mode in modes])


def _current(context: ServiceContext, u: FloatArray, states: Sequence[ClosedState]) -> int:
    """Index of the state with the stream's assembly modes; -1 if there is none."""
    try:
        now, _ = in_first_charts(context.robot, context.close(u))
    except HybridDynamicsError:
        return -1
    for k, state in enumerate(states):
        there, _ = in_first_charts(context.robot, state)
        if _is_same(context.robot, there, now):
            return k
    return -1


def switch_assembly_mode(
    context: ServiceContext,
    request: SwitchAssemblyMode.Request,
    response: SwitchAssemblyMode.Response,
) -> NewMode:
    """The change of the stream's assembly modes, to be applied by the caller."""
    if context.situation.moving:
        raise RejectedError(
            RejectionCode.REFUSED, "the robot moves: assembly modes change only while it stands"
        )
    requested = _requested_modes(context.robot, request)
    u = context.newest(
        ", which say where the robot stands; the assembly modes to begin with stand in the robot"
        " file"
    )
    wanted = {**context.close(u).branch, **requested}
    modes = context.robot.assembly_modes(in_file_charts(context.robot, u))
    for mode in modes:
        if dict(mode.branch) == wanted:
            response.mode = _message(context.robot, mode.state)
            return NewMode(mode.state)
    text = _why_no_mode(requested, [mode.branch for mode in modes])
    raise RejectedError(RejectionCode.BAD_REQUEST, text)


def _requested_modes(robot: Robot, request: SwitchAssemblyMode.Request) -> dict[str, str]:
    """Requested mode of each named loop.

    Raises:
        RejectedError: the numbers of names and loops differ, or a loop or mode is unknown.
    """
    if not request.loops or len(request.loops) != len(request.branches):
        loops = counted(len(request.loops), "loop")
        branches = counted(len(request.branches), "branch", "branches")
        text = f"{loops} and {branches}; expected one branch for each loop"
        raise RejectedError(RejectionCode.WRONG_LENGTH, text)
    requested = dict(zip(request.loops, request.branches, strict=True))
    for loop, name in requested.items():
        if loop not in robot.loops:
            raise RejectedError(RejectionCode.BAD_REQUEST, no_such_name("loop", loop, robot.loops))
        _require_mode(loop, name, robot.mode_names.get(loop))
    return requested


def _require_mode(loop: str, name: str, names: Sequence[str] | None) -> None:
    """Raise for a mode that a loop never has, if the loop's modes have names."""
    for part in name.split("+"):
        if names and part not in names:
            raise RejectedError(RejectionCode.BAD_REQUEST, no_such_mode(loop, part, names))


def _why_no_mode(requested: Mapping[str, str], branches: Sequence[Mapping[str, str]]) -> str:
    """Text on why requested modes are not among the branches at this configuration.

    A loop does not close on a mode, or the modes cannot be combined.
    """
    for loop, name in requested.items():
        names = list(dict.fromkeys(branch[loop] for branch in branches if loop in branch))
        if name not in names:
            senses = ", ".join(names[:_MOST_LISTED]) or "in no way"
            hint = suggestion(name, names)
            return f"loop '{loop}' does not close as '{name}' here{hint}; it closes as {senses}"
    return (
        f"the loops close in {counted(len(branches), 'way')} here, and so together in none of"
        " them; list_assembly_modes lists them"
    )


def describe_robot(
    context: ServiceContext, _request: DescribeRobot.Request, response: DescribeRobot.Response
) -> None:
    """Names, types and limits of the robot's joints."""
    robot = context.robot
    lower, upper = joint_limits(robot)
    response.name = robot.name
    response.base_frame = context.frames.base
    response.end_effector = robot.end_effector
    response.joints = list(robot.coordinates)
    response.types = [str(robot.joint_types[name]) for name in robot.coordinates]
    response.lower = conversions.to_field(lower)
    response.upper = conversions.to_field(upper)
    response.active = list(robot.active)
    response.drives = list(robot.drives)
    response.measured = list(context.situation.measured)
    response.cylinders = list(robot.cylinders)
    response.loops = list(robot.loops)
    response.frames = list(robot.frames)
    response.reference = conversions.to_field(context.reference)
    response.notes = list(robot.description.notes)


def _message(robot: Robot, state: ClosedState) -> AssemblyMode:
    s, _ = in_first_charts(robot, state)
    return AssemblyMode(
        loops=list(state.branch),
        branches=list(map(str, state.branch.values())),
        joint_state=conversions.joint_state(Header(), robot.coordinates, s),
    )


def _is_same(robot: Robot, one: FloatArray, other: FloatArray) -> bool:
    """Whether two configurations are equal up to whole turns."""
    is_revolute = np.array([robot.joint_types[name] == "revolute" for name in robot.coordinates])
    difference = one - other
    turned = np.remainder(difference + np.pi, 2.0 * np.pi) - np.pi
    return bool(np.abs(np.where(is_revolute, turned, difference)).max() < _TOLERANCE)


def _why_not(context: ServiceContext, u: FloatArray) -> str:
    try:
        context.robot.close(in_file_charts(context.robot, u))
    except HybridDynamicsError as error:
        return one_line(error)
    return "the loops close in no way"
