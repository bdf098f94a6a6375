"""Ball and free joints of MJCF.

All code of the reader for joints of several degrees of freedom is here.
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
        joints: reader of limits and effects of joints.
        joint: ball or free.
        name: name of the joint.
        body: pose of its body in the parent body.

    Raises:
        DescriptionError: it has friction that cannot be represented.
    """
    model = joints.model
    _require_isotropic(model, joint, name)
    if joint.is_limited:
        element = model.joint_element(joint)
        model.xml.note(element, f"joint {name}: the range of a ball joint is left out")
    entry: Data = {"type": joint.kind, **joints.effects(joint, name)}
    if "spring" in entry:  # at rest as drawn
        entry["spring"] = {"stiffness": joint.stiffness}
    if joint.kind == "free":
        return Freedom(name, entry, body)
    place = Transform(translation=frozen(joint.pos))
    return Freedom(name, entry, place, place.inverse())


def pose_in_keyframe(joint: Joint, drawn: Transform, numbers: Sequence[float]) -> Data:
    """The pose of a ball or free joint relative to its drawn pose, from its numbers in qpos.

    Args:
        joint: ball or free.
        drawn: drawn pose of its body in the world, for a free joint.
        numbers: numbers of the joint in qpos.
    """
    if joint.kind == "ball":
        return {"quat": quat_entry(rotation_of(numbers))}
    moved = drawn.inverse() @ pose_of(numbers[:3], numbers[3:])
    return {"xyz": moved.translation.tolist(), "quat": quat_entry(moved.rotation)}


def _require_isotropic(model: MjcfModel, joint: Joint, name: str) -> None:
    """Refuse friction that cannot be represented."""
    problem = ""
    if joint.kind == "free" and joint.frictionloss:
        problem = f"frictionloss of a free joint is {joint.frictionloss:g}; expected 0"
    if problem:
        element = model.joint_element(joint)
        raise model.xml.error(element, ("joints", name), f"{problem}: take it out")
