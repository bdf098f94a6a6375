"""Services: inverse and forward dynamics, minimal form, payload.

Each function fills the response, or raises an error that `answers.guarded` converts to an error
code and text. A RejectedError is for a wrong request, a StateError for loops that do not close or
are singular.
"""

from __future__ import annotations

from hybrid_dynamics_msgs.srv import (
    ForwardDynamics,
    InverseDynamics,
    MinimalForm,
    SetPayload,
    ZeroPayload,
)
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from hybrid_dynamics_core.errors import InputError
from hybrid_dynamics_core.ground.wording import one_line

from ..messages import conversions
from ..messages.joint_samples import (
    FloatArray,
    JointOrder,
    RejectedError,
    RejectionCode,
    active_order,
)
from ..parameters import PAYLOAD_COM, PAYLOAD_INERTIA, PAYLOAD_MASS, ParameterError, checked
from ..stream.conditions import NewPayload, NewZero, PayloadBody, loads_of
from ..stream.estimates.payload import LEAST
from .context import ServiceContext, require_finite
from .kinematics import require_frames


def inverse_dynamics(
    context: ServiceContext, request: InverseDynamics.Request, response: InverseDynamics.Response
) -> None:
    """Efforts of the active joints for their motion, and the state of all joints.

    Args:
        context: the robot with its present loads and assembly modes.
        request: `motion` names the active joints, with position [rad or m], velocity and
            acceleration of each.
        response: receives `efforts` [N m or N] and `joint_state`.

    Raises:
        RejectedError: the motion is incomplete or not finite, or the result is not finite.
        StateError: a loop does not close, or is singular.
    """
    robot, given = context.robot, request.motion
    sample = conversions.sample_of_motion(given)
    position, velocity, acceleration = active_order(robot).arrange(sample).complete()
    state = context.close(position, velocity)
    efforts = robot.inverse_dynamics(state, acceleration, context.loads)
    require_finite(efforts)
    s, ds, _ = context.motion_of(state)

    header = Header(stamp=given.header.stamp)
    response.efforts = conversions.joint_state(header, robot.active, position, velocity, efforts)
    response.joint_state = conversions.joint_state(header, robot.coordinates, s, ds)


def forward_dynamics(
    context: ServiceContext, request: ForwardDynamics.Request, response: ForwardDynamics.Response
) -> None:
    """Accelerations of all joints for efforts of the active ones.

    Args:
        context: the robot with its present loads and assembly modes.
        request: `active_joints` names the active joints, with position [rad or m] and effort
            [N m or N] of each; velocities are zero if missing.
        response: receives `motion` of all joints.

    Raises:
        RejectedError: a field has a wrong length or is not finite, or the result is not finite.
        StateError: a loop does not close, or is singular.
    """
    robot, given = context.robot, request.active_joints
    order = active_order(robot)
    motion = order.arrange(conversions.sample_of_state(given))
    tau = _efforts_of(order, given)
    state = context.close(motion.position, motion.velocity)
    ddu = robot.forward_dynamics(state, tau, context.loads)
    motion_of_all = context.motion_of(state, robot.accelerations(state, ddu))
    header = Header(stamp=given.header.stamp)
    response.motion = conversions.joint_motion(header, robot.coordinates, *motion_of_all.complete())


def _efforts_of(order: JointOrder, message: JointState) -> FloatArray:
    """Efforts (n,) [N m or N] of a message in the order of joints.

    Raises:
        RejectedError: as in `JointOrder.arrange`.
    """
    efforts = conversions.from_field(message.effort)
    return order.pick("effort", message.name, efforts)


def minimal_form(
    context: ServiceContext, request: MinimalForm.Request, response: MinimalForm.Response
) -> None:
    """M-bar, C-bar u', G-bar and passive forces over the n active joints.

    Args:
        context: the robot with its present loads and assembly modes.
        request: `active_joints` names the active joints, with position [rad or m] of each;
            velocities are zero if missing.
        response: receives `inertia` (n, n), row by row, and `coriolis`, `gravity` and `passive`
            (n,) [N m or N].

    Raises:
        RejectedError: a field has a wrong length or is not finite, or the result is not finite.
        StateError: a loop does not close, or is singular.
    """
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
    """The change of the payload at a frame, to be applied by the caller.

    Args:
        context: the robot with its present loads.
        request: `frame`, by default the end effector, and `inertia`: mass [kg], centre of mass [m]
            and the inertia about it [kg m^2], in frame axes.
        _response: not changed.

    Returns:
        The change.

    Raises:
        RejectedError: the frame is unknown, a number is beyond the bounds of the parameter
            `payload`, or the inertia is impossible.
    """
    frame = request.frame or context.robot.end_effector
    require_frames(context.robot, frame)
    inertia, com = request.inertia, request.inertia.com
    entries = (inertia.ixx, inertia.ixy, inertia.ixz, inertia.iyy, inertia.iyz, inertia.izz)
    body = PayloadBody(inertia.m, (com.x, com.y, com.z), entries)
    _require_bounds(body)
    change = NewPayload(frame, body)
    try:
        loads_of(context.robot, change.applied(context.situation.conditions))
    except InputError as error:
        raise RejectedError(RejectionCode.BAD_REQUEST, one_line(error)) from error
    return change


def zero_payload(
    context: ServiceContext, request: ZeroPayload.Request, response: ZeroPayload.Response
) -> NewZero:
    """The newest motion as one of the empty tool, to be taken by the caller.

    Args:
        context: the robot with its present motion.
        request: `clear`, to forget the empty tool instead.
        response: receives `duration` of the motion [s].

    Returns:
        The change.

    Raises:
        RejectedError: there is no motion with measured forces, or too little of it.
    """
    weighed = context.situation.weighed
    if not request.clear:
        if weighed < LEAST:
            text = (
                f"{weighed:.1f} s of motion with pressures on ~/cylinder_pressures; expected"
                f" {LEAST:g} s or more"
            )
            raise RejectedError(RejectionCode.NOT_READY, text)
        response.duration = weighed
    return NewZero(request.clear)


def _require_bounds(body: PayloadBody) -> None:
    """Check a payload against the bounds of the parameters.

    Raises:
        RejectedError: a number is not finite, or out of bounds.
    """
    try:
        checked(PAYLOAD_MASS, body.mass)
        checked(PAYLOAD_COM, body.com)
        checked(PAYLOAD_INERTIA, body.inertia)
    except ParameterError as error:
        raise RejectedError(RejectionCode.BAD_REQUEST, f"as {error}") from error
