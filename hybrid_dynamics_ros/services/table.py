"""The table of all services."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any, Final

from hybrid_dynamics_msgs import srv

from .answers import Answer
from .dynamics import forward_dynamics, inverse_dynamics, minimal_form, set_payload, zero_payload
from .kinematics import close_loops, compute_jacobian, solve_fk, solve_ik
from .modes import describe_robot, list_assembly_modes, switch_assembly_mode
from .trajectory import convert_trajectory
from .trajectory_steps import PointsOfJoints, TrajectoryStep, points_of_joints, trajectory_step


class Lane(Enum):
    """The worker of a call.

    Short calls never wait for long ones, and the stream never waits for calls.
    """

    HERE = (
        "in the node, between two messages: a few microseconds; changes are then made in a thread"
        " beside the stream"
    )
    SHORT = "in a process beside it: milliseconds"
    SEARCH = "in another one, for inverse kinematics alone: milliseconds, seconds where it fails"
    LONG = "in a third one: up to seconds, and trajectories of any length"


@dataclass(frozen=True)
class Service:
    """One service: name below `~/`, type, function and lane."""

    name: str
    kind: Any  # has Request and Response
    answer: Answer
    lane: Lane


TABLE: Final = (
    Service("solve_fk", srv.SolveFK, solve_fk, Lane.SHORT),
    Service("solve_ik", srv.SolveIK, solve_ik, Lane.SEARCH),
    Service("inverse_dynamics", srv.InverseDynamics, inverse_dynamics, Lane.SHORT),
    Service("forward_dynamics", srv.ForwardDynamics, forward_dynamics, Lane.SHORT),
    Service("compute_jacobian", srv.ComputeJacobian, compute_jacobian, Lane.SHORT),
    Service("minimal_form", srv.MinimalForm, minimal_form, Lane.SHORT),
    Service("close_loops", srv.CloseLoops, close_loops, Lane.SHORT),
    Service("set_payload", srv.SetPayload, set_payload, Lane.HERE),
    Service("zero_payload", srv.ZeroPayload, zero_payload, Lane.HERE),
    Service("list_assembly_modes", srv.ListAssemblyModes, list_assembly_modes, Lane.LONG),
    Service("switch_assembly_mode", srv.SwitchAssemblyMode, switch_assembly_mode, Lane.LONG),
    Service("convert_trajectory", srv.ConvertTrajectory, convert_trajectory, Lane.LONG),
    Service("describe_robot", srv.DescribeRobot, describe_robot, Lane.HERE),
)
# Calls of actions, not offered as services.
TRAJECTORY_STEP: Final = Service("trajectory_step", TrajectoryStep, trajectory_step, Lane.LONG)
POINTS_OF_JOINTS: Final = Service("points_of_joints", PointsOfJoints, points_of_joints, Lane.SHORT)
BY_NAME: Final = {service.name: service for service in (*TABLE, TRAJECTORY_STEP, POINTS_OF_JOINTS)}
