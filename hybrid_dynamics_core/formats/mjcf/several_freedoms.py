"""Ball and free joints: three hinges in a row, or three slides and three hinges.

All that the reader knows of joints of several degrees of freedom stands here.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...description.geometry import Transform
from ...ground.arrays import Array, frozen
from ..xml.located_xml import LocatedElement
from .compiler.compiled import Joint
from .compiler.model import MjcfModel
from .joints import Freedom
from .poses import rotation_of

WIDTHS = {"free": 7, "ball": 4, "hinge": 1, "slide": 1}  # numbers in qpos
_AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
_EFFECTS = ("armature", "damping", "frictionloss", "stiffness")


def several_freedoms(model: MjcfModel, joint: Joint, name: str, body: Transform) -> list[Freedom]:
    """The freedoms of a ball or free joint.

    Args:
        model: of which it is a joint.
        joint: ball or free.
        name: of the joint.
        body: pose of its body, in the body around it.

    Raises:
        DescriptionError: it has what acts on the whole turn.
    """
    element = model.joint_element(joint)
    _refuse_effects(model, joint, name, element)
    if joint.kind == "free":
        return _free(model, name, body, element)
    if joint.is_limited:
        model.xml.note(element, f"joint {name}: the range of a ball joint is left out")
    hinges = _listed(name, "")
    model.xml.note(element, f"joint {name} is a ball; taken: hinges {hinges} in a row")
    place = Transform(translation=frozen(joint.pos))
    return _hinges(name, place, place.inverse())


def coordinates(joint: Joint, drawn: Transform, numbers: Sequence[float]) -> list[float]:
    """Coordinates of the freedoms of a joint, from its numbers in qpos.

    Args:
        joint: of any kind.
        drawn: pose of its body in the world, where it is free.
        numbers: of the joint.
    """
    if joint.kind == "ball":
        return _angles(rotation_of(numbers))
    if joint.kind == "free":
        position = np.array(numbers[:3]) - drawn.translation
        turned = drawn.rotation.T @ rotation_of(numbers[3:])
        return [*position.tolist(), *_angles(turned)]
    return list(numbers)


def _free(model: MjcfModel, name: str, body: Transform, element: LocatedElement) -> list[Freedom]:
    """Slides along the axes of the world, then hinges from the pose in which it is drawn."""
    freedoms: list[Freedom] = []
    before = Transform(translation=body.translation)
    for letter, axis in _AXES.items():
        entry = {"type": "prismatic", "axis": list(axis)}
        freedoms.append(Freedom(f"{name}_along_{letter}", entry, before))
        before = Transform()
    text = (
        f"joint {name} is free; taken: slides {_listed(name, 'along_')} and hinges"
        f" {_listed(name, '')} in a row, zero as drawn"
    )
    model.xml.note(element, text)
    return [*freedoms, *_hinges(name, Transform(body.rotation), Transform())]


def _hinges(name: str, before: Transform, after: Transform) -> list[Freedom]:
    """Hinges about x, y and z, whose axes meet."""
    freedoms: list[Freedom] = []
    for letter, axis in _AXES.items():
        entry = {"type": "revolute", "axis": list(axis)}
        freedoms.append(Freedom(f"{name}_{letter}", entry, before))
        before = Transform()
    last = freedoms.pop()
    freedoms.append(Freedom(last.name, last.entry, last.before, after))
    return freedoms


def _refuse_effects(model: MjcfModel, joint: Joint, name: str, element: LocatedElement) -> None:
    """Refuse what acts on the whole turn of a ball, which three hinges cannot say."""
    for word in _EFFECTS:
        value = getattr(joint, word)
        if not (value or joint.is_polynomial):
            continue
        from_class = ""
        if element.get("type") == "free":
            from_class = " (a <freejoint> has no defaults)"
        problem = (
            f"{word} of a ball or free joint is {value:g}, which acts on its angular velocity, not"
            f" on hinges in a row; expected 0: take it out, or write three hinges{from_class}"
        )
        raise model.xml.error(element, ("joints", name, word), problem)


def _listed(name: str, prefix: str) -> str:
    return ", ".join(f"{name}_{prefix}{letter}" for letter in _AXES)


def _angles(rotation: Array) -> list[float]:
    """Angles [rad] of hinges about x, y and z in a row that make up a rotation (3, 3)."""
    pitch = float(np.arcsin(np.clip(rotation[0, 2], -1.0, 1.0)))
    roll = float(np.arctan2(-rotation[1, 2], rotation[2, 2]))
    yaw = float(np.arctan2(-rotation[0, 1], rotation[0, 0]))
    return [roll, pitch, yaw]
