"""What goes out for each input: one table of topics, each with the function that fills its message.

Messages that go out for every input are filled in as bytes (`cdr`), which costs a fifth of a
message object; the names of all are written once. Knows no rclpy.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, PoseStamped, TwistStamped, Vector3, Wrench
from hybrid_dynamics_msgs.msg import ClosedState, CylinderStates, LoopReactions
from sensor_msgs.msg import JointState

from hybrid_dynamics_core import ClosedState as Closed
from hybrid_dynamics_core import CylinderState, Robot
from hybrid_dynamics_core.errors import SingularityError

from ..messages import layouts
from ..messages.cdr import Template
from ..messages.conversions import ns_to_stamp, to_field
from ..messages.joint_samples import FloatArray
from ..messages.link_transforms import quaternion
from .results import MotionResult
from .stroke_margins import Strokes

Fill = Callable[
    [MotionResult], Any | None
]  # the message or its bytes, or None where this result has none


@dataclass(frozen=True)
class Output:
    """One topic: its name below ``~/``, its type, and what makes its filler for a robot."""

    topic: str
    kind: type
    filler: Callable[[Robot], Fill]


def joint_states(robot: Robot) -> Fill:
    """All joints: position, velocity, and the effort of the drives, zero where nothing drives."""
    along = _efforts_along_joints(robot)

    @cache
    def layout(velocity: bool, effort: bool) -> Template:
        return layouts.joint_state(robot.coordinates, velocity=velocity, effort=effort)

    def fill(result: MotionResult) -> bytes:
        efforts = None if result.efforts is None else along(result, result.efforts)
        known = [part for part in (result.position, result.velocity, efforts) if part is not None]
        return layout(result.velocity is not None, efforts is not None).message(
            result.stamp_ns, known
        )

    return fill


def required_efforts(robot: Robot) -> Fill:
    """Torques and forces of the active joints; nothing before accelerations are known."""
    layout = layouts.joint_state(robot.active, velocity=True, effort=True)

    def fill(result: MotionResult) -> bytes | None:
        u, du, _ = result.active
        if result.efforts is None or du is None:
            return None
        return layout.message(result.stamp_ns, (u, du, result.efforts))

    return fill


def closed_state(robot: Robot) -> Fill:
    """Residual, assembly modes, distances to singularities and to the ends of strokes."""
    strokes = Strokes(robot)
    known: dict[str, Template] = {}
    told: Mapping[str, str] = {}

    def fill(result: MotionResult) -> bytes:
        nonlocal told
        if told is not result.branch and told != result.branch:
            told = result.branch
            known.clear()
        distance, loop = result.nearest
        if loop not in known:
            known[loop] = layouts.closed_state(robot, strokes.joints, told, loop)
        values = (result.residual, result.distances, distance, *strokes.left(result.position))
        return known[loop].message(result.stamp_ns, values)

    return fill


def closed_state_message(robot: Robot, state: Closed, stamp: Time) -> ClosedState:
    """What `closed_state` sends, as an object."""
    strokes = Strokes(robot)
    lower, upper = strokes.left(state.s)
    message = ClosedState(
        residual=float(state.residual),
        loops=list(robot.loops),
        branches=[state.branch.get(loop, "") for loop in robot.loops],
        singularity=to_field(state.distances),
        nearest_singularity=float(state.singularity),
        nearest_loop=str(state.singular_loop),
        stroke_joints=list(strokes.joints),
        to_lower=to_field(lower),
        to_upper=to_field(upper),
    )
    message.header.stamp = stamp
    return message


def end_effector_pose(robot: Robot) -> Fill:
    """Pose of the end effector in the base frame."""
    layout = layouts.pose(robot)

    def fill(result: MotionResult) -> bytes:
        pose = result.pose
        return layout.message(result.stamp_ns, (pose.position, np.array(quaternion(pose.rotation))))

    return fill


def end_effector_twist(robot: Robot) -> Fill:
    """Velocity of the end effector's origin and its rotation, base axes; nothing before rates are known."""
    layout = layouts.twist(robot)

    def fill(result: MotionResult) -> bytes | None:
        if not result.moving:
            return None
        return layout.message(result.stamp_ns, (robot.jacobian(result.state) @ result.state.du,))

    return fill


def loop_reactions(robot: Robot) -> Fill:
    """Force and moment in every pin; nothing before accelerations are known."""
    message = LoopReactions()
    message.header.frame_id = robot.base_frame

    def fill(result: MotionResult) -> LoopReactions | None:
        if result.active.acceleration is None or not result.moving:
            return None
        pins = robot.reactions(result.state, result.active.acceleration, result.loads).pins
        message.header.stamp = ns_to_stamp(result.stamp_ns)
        message.pins = list(pins)
        message.link_a, message.link_b = ([pin.links[k] for pin in pins.values()] for k in (0, 1))
        message.places = [
            Point(x=x, y=y, z=z) for x, y, z in (pin.place.tolist() for pin in pins.values())
        ]
        message.wrenches = [
            Wrench(force=_vector(pin.force.tolist()), torque=_vector(pin.moment.tolist()))
            for pin in pins.values()
        ]
        return message

    return fill


def cylinder_states(robot: Robot) -> Fill:
    """Pressures and flows of the cylinders; nothing before accelerations are known, or where no areas are given."""
    message = CylinderStates(name=list(robot.cylinders))
    numbers = [name for name in CylinderState.__dataclass_fields__ if name != "overloaded"]

    def fill(result: MotionResult) -> CylinderStates | None:
        if result.efforts is None or not robot.cylinders:
            return None
        states = robot.hydraulics(result.state, result.efforts).values()
        message.header.stamp = ns_to_stamp(result.stamp_ns)
        for name in numbers:
            setattr(message, name, to_field(np.array([float(getattr(s, name)) for s in states])))
        message.overloaded = [bool(s.overloaded) for s in states]
        return message

    return fill


TABLE: Final = (
    Output("joint_states", JointState, joint_states),
    Output("required_efforts", JointState, required_efforts),
    Output("closed_state", ClosedState, closed_state),
    Output("end_effector_pose", PoseStamped, end_effector_pose),
    Output("end_effector_twist", TwistStamped, end_effector_twist),
    Output("loop_reactions", LoopReactions, loop_reactions),
    Output("cylinder_states", CylinderStates, cylinder_states),
)


def _efforts_along_joints(robot: Robot) -> Callable[[MotionResult, FloatArray], FloatArray | None]:
    size, active = len(robot.coordinates), len(robot.active)
    if set(robot.drives) == set(robot.active):

        def own(_result: MotionResult, tau: FloatArray) -> FloatArray:
            along = np.zeros(size)
            along[:active] = tau
            return along

        return own
    places = [robot.coordinates.index(name) for name in robot.drives]

    def driven(result: MotionResult, tau: FloatArray) -> FloatArray | None:
        along = np.zeros(size)
        try:
            along[places] = [
                float(force) for force in robot.drive_forces(result.state, tau).values()
            ]
        except SingularityError:
            return None  # as they stand, the drives cannot give these forces
        return along

    return driven


def _vector(values: Sequence[float]) -> Vector3:
    x, y, z = values
    return Vector3(x=x, y=y, z=z)
