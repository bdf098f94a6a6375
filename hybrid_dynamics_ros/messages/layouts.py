"""Layouts of the messages that go out for every input, the live node's and those of recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from hybrid_dynamics_core import Robot

from .cdr import Template


def joint_state(names: Sequence[str], *, velocity: bool, effort: bool) -> Template:
    """A sensor_msgs/JointState: slots `position`, `velocity`, `effort`; the last two as far as they are known."""
    count = len(names)
    template = Template().header().strings(names).sequence("position", count)
    for name, known in (("velocity", velocity), ("effort", effort)):
        template = template.sequence(name, count) if known else template.length(0)
    return template


def closed_state(
    robot: Robot, ending: Sequence[str], branch: Mapping[str, str], nearest: str
) -> Template:
    """A ClosedState: slots `residual`, `singularity`, `nearest`, `lower`, `upper`.

    Args:
        robot: the robot.
        ending: joints whose motion ends.
        branch: assembly mode of each loop.
        nearest: the loop nearest to its singularity.
    """
    template = Template().header().slot("residual", "<f8").strings(robot.loops)
    template.strings([branch.get(loop, "") for loop in robot.loops])
    template.sequence("singularity", len(robot.loops)).slot("nearest", "<f8").string(nearest)
    return template.strings(ending).sequence("lower", len(ending)).sequence("upper", len(ending))


def pose(robot: Robot) -> Template:
    """A geometry_msgs/PoseStamped of the end effector: slots `position` and `turn` (x y z w)."""
    return Template().header(robot.base_frame).slot("position", "<f8", 3).slot("turn", "<f8", 4)


def twist(robot: Robot) -> Template:
    """A geometry_msgs/TwistStamped of the end effector: slot `twist`, linear and angular."""
    return Template().header(robot.base_frame).slot("twist", "<f8", 6)


def transforms(robot: Robot) -> Template:
    """A tf2_msgs/TFMessage of all joints: slots `place 0`, `turn 0` (x y z w), `place 1` ... in their order."""
    template = Template().length(len(robot.coordinates))
    for k, name in enumerate(robot.coordinates):
        joint = robot.description.joints[name]
        template.header(joint.parent).string(joint.child).slot(f"place {k}", "<f8", 3).slot(
            f"turn {k}", "<f8", 4
        )
    return template
