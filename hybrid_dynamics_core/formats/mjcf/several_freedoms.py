"""Ball and free joints of MJCF.

All that the reader knows of joints of several degrees of freedom stands here.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...description.document import Data
from ...description.geometry import Transform
from ...ground.arrays import frozen
from .compiler.compiled import Joint
from .compiler.model import MjcfModel
from .joints import Freedom, JointReader
from .poses import pose_of, quat_entry, rotation_of

WIDTHS = {"free": 7, "ball": 4, "hinge": 1, "slide": 1}  # numbers in qpos


def several_freedoms(joints: JointReader, joint: Joint, name: str, body: Transform) -> Freedom:
    """A ball or free joint.

    Args:
        joints: reads what acts along joints.
        joint: ball or free.
        name: of the joint.
        body: pose of its body, in the body around it.

    Raises:
        DescriptionError: it has a spring, or friction that has no axes here.
    """
    model = joints.model
    _require_linear(model, joint, name)
    if joint.is_limited:
        element = model.joint_element(joint)
        model.xml.note(element, f"joint {name}: the range of a ball joint is left out")
    entry: Data = {"type": joint.kind, **joints.effects(joint, name)}
    if joint.kind == "free":
        return Freedom(name, entry, body)
    place = Transform(translation=frozen(joint.pos))
    return Freedom(name, entry, place, place.inverse())


def pose_in_keyframe(joint: Joint, drawn: Transform, numbers: Sequence[float]) -> Data:
    """The pose of a ball or free joint from where it is drawn, from its numbers in qpos.

    Args:
        joint: ball or free.
        drawn: pose of its body in the world, where it is free.
        numbers: of the joint.
    """
    if joint.kind == "ball":
        return {"quat": quat_entry(rotation_of(numbers))}
    moved = drawn.inverse() @ pose_of(numbers[:3], numbers[3:])
    return {"xyz": moved.translation.tolist(), "quat": quat_entry(moved.rotation)}


def _require_linear(model: MjcfModel, joint: Joint, name: str) -> None:
    """Refuse what has no words for a whole turn."""
    problem = ""
    if joint.stiffness:
        problem = f"stiffness of a {joint.kind} joint is {joint.stiffness:g}; expected 0"
    elif joint.kind == "free" and joint.frictionloss:
        problem = f"frictionloss of a free joint is {joint.frictionloss:g}; expected 0"
    if problem:
        element = model.joint_element(joint)
        raise model.xml.error(element, ("joints", name), f"{problem}: take it out")
