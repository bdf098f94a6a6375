"""Inverse and forward dynamics, minimal form, payload."""

from __future__ import annotations

from hybrid_dynamics_msgs.srv import ForwardDynamics, InverseDynamics, MinimalForm, SetPayload
from std_msgs.msg import Header

from hybrid_dynamics_core.errors import InputError
from hybrid_dynamics_core.ground.wording import one_line

from ..messages import conversions
from ..messages.joint_samples import (
    JointOrder,
    JointSample,
    RejectedError,
    RejectionCode,
    wrong_length,
)
from ..stream.conditions import NewPayload, PayloadBody, loads_of
from .context import ServiceContext, require_finite
from .kinematics import require_frames


def inverse_dynamics(
    context: ServiceContext, request: InverseDynamics.Request, response: InverseDynamics.Response
) -> None:
    """Efforts of the active joints for a motion with accelerations."""
    robot, given = context.robot, request.motion
    sample = conversions.sample_of_motion(given)
    position, velocity, acceleration = JointOrder(robot.active).arrange(sample).complete()
    state = context.close(position, velocity)
    efforts = robot.inverse_dynamics(state, acceleration, context.loads)
    require_finite(state.s, state.ds, efforts)

    header = Header(stamp=given.header.stamp)
    response.efforts = conversions.joint_state(header, robot.active, position, velocity, efforts)
    response.joint_state = conversions.joint_state(header, robot.coordinates, state.s, state.ds)


def forward_dynamics(
    context: ServiceContext, request: ForwardDynamics.Request, response: ForwardDynamics.Response
) -> None:
    """Accelerations of all joints for efforts of the active ones."""
    robot, given = context.robot, request.active_joints
    order = JointOrder(robot.active)
    motion = order.arrange(conversions.sample_of_state(given))
    # Efforts in place of positions: names, length and finite numbers are checked alike.
    efforts = conversions.from_field(given.effort)
    if efforts.size != len(given.name):
        text = wrong_length("effort", efforts.size, len(given.name))
        raise RejectedError(RejectionCode.WRONG_LENGTH, text)
    tau = order.arrange(JointSample(0, given.name, efforts)).position
    state = context.close(motion.position, motion.velocity)
    ddu = robot.forward_dynamics(state, tau, context.loads)
    dds = robot.accelerations(state, ddu)
    require_finite(state.s, state.ds, dds)
    header = Header(stamp=given.header.stamp)
    response.motion = conversions.joint_motion(header, robot.coordinates, state.s, state.ds, dds)


def minimal_form(
    context: ServiceContext, request: MinimalForm.Request, response: MinimalForm.Response
) -> None:
    """M, C u' and G over the active joints."""
    robot = context.robot
    motion = context.active_motion(request.active_joints)
    state = context.close(motion.position, motion.velocity)
    inertia, coriolis, gravity = robot.minimal_form(state, context.loads)
    passive = robot.passive_forces(state, context.loads)
    require_finite(inertia, coriolis, gravity, passive)
    response.joints = list(robot.active)
    response.inertia = conversions.to_field(inertia.ravel())
    response.coriolis = conversions.to_field(coriolis)
    response.gravity = conversions.to_field(gravity)
    response.passive = conversions.to_field(passive)


def set_payload(
    context: ServiceContext, request: SetPayload.Request, _response: SetPayload.Response
) -> NewPayload:
    """Another payload at a frame, from now on."""
    frame = request.frame or context.robot.end_effector
    require_frames(context.robot, frame)
    inertia, com = request.inertia, request.inertia.com
    moments = (inertia.ixx, inertia.ixy, inertia.ixz, inertia.iyy, inertia.iyz, inertia.izz)
    if not inertia.m >= 0.0:
        raise RejectedError(
            RejectionCode.BAD_REQUEST, f"the mass is {inertia.m} kg, expected 0 or more"
        )
    body = PayloadBody(inertia.m, (com.x, com.y, com.z), moments)
    change = NewPayload(frame, body)
    try:
        loads_of(context.robot, change.applied(context.situation.conditions))
    except InputError as error:
        raise RejectedError(RejectionCode.BAD_REQUEST, one_line(error)) from error
    return change
