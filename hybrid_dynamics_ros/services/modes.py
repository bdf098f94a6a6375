"""Assembly modes, and what the robot is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from hybrid_dynamics_msgs.msg import AssemblyMode
from hybrid_dynamics_msgs.srv import DescribeRobot, ListAssemblyModes, SwitchAssemblyMode
from std_msgs.msg import Header

from hybrid_dynamics_core import ClosedState, HybridDynamicsError, Robot
from hybrid_dynamics_core.closed_state.assembly_modes import no_such_mode
from hybrid_dynamics_core.ground.suggestions import no_such_name, suggestion
from hybrid_dynamics_core.ground.wording import counted, one_line

from ..messages import conversions
from ..messages.joint_samples import FloatArray, JointOrder, RejectedError, RejectionCode
from ..stream.conditions import NewMode
from ..stream.situation import Context
from ..stream.stroke_margins import joint_limits

_TOLD = 12  # modes of a loop in a message
_SAME = 1e-6  # [rad or m] configurations nearer than this are one


def list_assembly_modes(
    context: Context, request: ListAssemblyModes.Request, response: ListAssemblyModes.Response
) -> None:
    """Every way in which the loops close."""
    robot = context.robot
    given = request.active_joints
    newest = not given.name and not given.position
    if newest:
        u = context.newest(", or name the active joints in the call")
    else:
        u = JointOrder(robot.active).arrange(conversions.sample_of_state(given)).position
    modes = robot.assembly_modes(u)
    if not modes:
        raise RejectedError(RejectionCode.UNREACHABLE, _why_not(context, u))
    response.modes = [_message(robot, mode.state) for mode in modes]
    try:
        now = context.close(u).s
    except HybridDynamicsError:
        now = np.full(len(robot.coordinates), np.nan)
    response.current = next(
        (k for k, mode in enumerate(modes) if _same(robot, mode.state.s, now)), -1
    )


def switch_assembly_mode(
    context: Context, request: SwitchAssemblyMode.Request, response: SwitchAssemblyMode.Response
) -> NewMode:
    """The stream closes its loops on other modes from now on."""
    if context.situation.moving:
        raise RejectedError(
            RejectionCode.REFUSED, "the robot moves: assembly modes change only while it stands"
        )
    if not request.loops or len(request.loops) != len(request.branches):
        given = (
            f"{counted(len(request.loops), 'loop')} and"
            f" {counted(len(request.branches), 'branch', 'branches')}"
        )
        text = f"{given}; expected one branch for each loop"
        raise RejectedError(RejectionCode.WRONG_LENGTH, text)
    robot, asked = context.robot, dict(zip(request.loops, request.branches, strict=True))
    _require_modes(robot, asked)
    u = context.newest(
        ", which say where the robot stands; the assembly modes to begin with stand in the robot"
        " file"
    )
    wanted = {**context.close(u).branch, **asked}
    modes = robot.assembly_modes(u)
    chosen = next((mode.state for mode in modes if dict(mode.branch) == wanted), None)
    if chosen is None:
        raise RejectedError(
            RejectionCode.BAD_REQUEST, _how_else(asked, [mode.branch for mode in modes])
        )
    response.mode = _message(robot, chosen)
    return NewMode(chosen)


def _require_modes(robot: Robot, asked: Mapping[str, str]) -> None:
    """Refuse loops that the robot has not, and modes that a loop has nowhere.

    Raises:
        RejectedError: it has not this one.
    """
    for loop, name in asked.items():
        if loop not in robot.loops:
            raise RejectedError(RejectionCode.BAD_REQUEST, no_such_name("loop", loop, robot.loops))
        known = robot.mode_names.get(loop)
        slips = [] if known is None else [part for part in name.split("+") if part not in known]
        if known and slips:
            raise RejectedError(RejectionCode.BAD_REQUEST, no_such_mode(loop, slips[0], known))


def _how_else(asked: Mapping[str, str], there: Sequence[Mapping[str, str]]) -> str:
    """Why modes are not there that the robot may have: a loop does not close so, or they do not go together."""
    for loop, name in asked.items():
        names = list(dict.fromkeys(branch[loop] for branch in there if loop in branch))
        if name not in names:
            told = ", ".join(names[:_TOLD]) or "in no way"
            return (
                f"loop '{loop}' does not close as '{name}' here{suggestion(name, names)}; it closes as"
                f" {told}"
            )
    return (
        f"the loops close in {counted(len(there), 'way')} here, and so together in none of them;"
        " list_assembly_modes lists them"
    )


def describe_robot(
    context: Context, _request: DescribeRobot.Request, response: DescribeRobot.Response
) -> None:
    """Names, types, limits."""
    robot = context.robot
    response.name, response.base_frame, response.end_effector = (
        robot.name,
        robot.base_frame,
        robot.end_effector,
    )
    response.joints = list(robot.coordinates)
    response.types = [str(robot.joint_types[name]) for name in robot.coordinates]
    response.lower, response.upper = (conversions.to_field(ends) for ends in joint_limits(robot))
    response.active, response.drives = list(robot.active), list(robot.drives)
    response.measured = list(context.situation.measured)
    response.cylinders, response.loops = list(robot.cylinders), list(robot.loops)
    response.frames = list(robot.frames)
    response.reference = conversions.to_field(robot.reference)
    response.notes = list(robot.description.notes)


def _message(robot: Robot, state: ClosedState) -> AssemblyMode:
    return AssemblyMode(
        loops=list(state.branch),
        branches=[str(name) for name in state.branch.values()],
        joint_state=conversions.joint_state(Header(), robot.coordinates, state.s),
    )


def _same(robot: Robot, one: FloatArray, other: FloatArray) -> bool:
    """Whether two configurations are one; whole turns do not count."""
    away = one - other
    turns = np.array([robot.joint_types[name] == "revolute" for name in robot.coordinates])
    away = np.where(turns, np.remainder(away + np.pi, 2.0 * np.pi) - np.pi, away)
    return bool(np.abs(away).max() < _SAME)


def _why_not(context: Context, u: FloatArray) -> str:
    try:
        context.robot.close(u)
    except HybridDynamicsError as error:
        return one_line(error)
    return "the loops close in no way"
