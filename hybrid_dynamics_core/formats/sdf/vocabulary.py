"""The vocabulary of SDFormat 1.3 to 1.12: what is read, and what is left out with a note.

http://sdformat.org/spec. Shapes, sensors, plugins and settings of one engine change no mass, no
place and no axis.
"""

from __future__ import annotations

import re
from itertools import combinations_with_replacement

from ..extras_reader import TAG
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from ..xml.vocabulary import Vocabulary, VocabularyCheck, vocabulary

Version = tuple[int, int]

NAMED_FRAMES: Version = (1, 7)  # from then on a pose or an axis can name its frame
JOINT_AXES: Version = (1, 5)  # from then on an axis is in the frame of its joint
_OLDEST: Version = (1, 3)
_CONVERT = "'gz sdf -p FILE' prints a file in the newest version"
_ADVICE = f"; it may change the robot, so it is not passed over: take it out ({_CONVERT})"
_OMITTED = (
    "visual collision sensor projector audio_sink audio_source battery light particle_emitter"
    " plugin self_collide"
)
_ADDED_MASS = {"".join(pair): "0" for pair in combinations_with_replacement("xyzpqr", 2)}
_ROTATION = "rotation_format degrees"
_FORCES_OF_DRAKE = re.compile("drake:.*(constraint|bushing|acceleration)")

_WORLD = vocabulary(
    "name",
    "model gravity",
    "include frame light actor plugin road audio wind magnetic_field atmosphere gui physics scene"
    " spherical_coordinates state population",
)
_AXIS = vocabulary(
    "", "xyz limit dynamics mimic", use_parent_model_frame="false", initial_position="0"
)
_OLDER_AXIS = vocabulary("", "xyz limit dynamics use_parent_model_frame", initial_position="0")
_MODEL: dict[str, Vocabulary] = {
    "model": vocabulary(
        "name canonical_link",
        f"link joint frame pose {TAG}",
        "namespace plugin gripper self_collide allow_auto_disable",
        static="false",
        enable_wind="false",
        placement_frame="__model__",
    ),
    "link": vocabulary(
        "name",
        "pose inertial velocity_decay",
        _OMITTED,
        gravity="true",
        kinematic="false",
        enable_wind="false",
        must_be_base_link="false",
    ),
    "velocity_decay": vocabulary(linear="0", angular="0"),
    "inertial": vocabulary(
        "", "mass pose inertia fluid_added_mass", "density auto_inertia_params", auto="false"
    ),
    "inertia": vocabulary("", "ixx iyy izz ixy ixz iyz"),
    "fluid_added_mass": vocabulary(**_ADDED_MASS),
    "joint": vocabulary(
        "name type",
        "parent child pose axis axis2 thread_pitch screw_thread_pitch",
        "sensor plugin physics gearbox_ratio gearbox_reference_body",
    ),
    "axis": _AXIS,
    "axis2": _AXIS,
    "xyz": vocabulary("expressed_in"),
    "limit": vocabulary("", "lower upper effort velocity", "stiffness dissipation"),
    "dynamics": vocabulary("", "damping friction spring_reference spring_stiffness"),
    "mimic": vocabulary("joint", "multiplier offset reference", axis="axis"),
    "frame": vocabulary("name attached_to", "pose"),
    "pose": vocabulary(f"relative_to {_ROTATION}", frame=""),
    "model/pose": vocabulary(_ROTATION, relative_to="world", frame=""),
    "inertial/pose": vocabulary(_ROTATION, relative_to="", frame=""),
}


def read_version(xml: XmlReader) -> Version:
    """The version of a file, which says in what frame its axes are.

    Raises:
        DescriptionError: its version is older than 1.3, or none.
    """
    version = xml.root.get("version")
    match = re.fullmatch(r"\s*(\d+)\.(\d+)(\.\d+)?\s*", version)
    if match is None or (int(match[1]), int(match[2])) < _OLDEST:
        problem = f"is '{version}'; expected 1.3 or later; {_CONVERT}"
        raise xml.error(xml.root, ("version",), problem)
    return int(match[1]), int(match[2])


def check_vocabulary(
    xml: XmlReader, model: LocatedElement, world: LocatedElement | None, version: Version
) -> None:
    """Check a model, and the world around it, for entries that may change the robot.

    Raises:
        DescriptionError: the first one that is not covered.
    """
    if world is not None:
        _check(xml, {"world": _WORLD}, world)
        for other in world.all("model"):
            if other is not model:
                xml.note(other, f"model {other.get('name')} is left out: it has no joints")
        _refuse_forces(xml, world)
    table = dict(_MODEL)
    if version < NAMED_FRAMES:
        table |= dict.fromkeys(("axis", "axis2"), _OLDER_AXIS)
    _check(xml, table, model)
    _refuse_forces(xml, model)


def _check(xml: XmlReader, table: dict[str, Vocabulary], element: LocatedElement) -> None:
    check = VocabularyCheck(xml, table, _ADVICE)
    check.check(element)
    check.add_notes()


def _refuse_forces(xml: XmlReader, element: LocatedElement) -> None:
    """Refuse what Drake's own words tie or hold; other words of other programs change nothing."""
    for child in element.children:
        if _FORCES_OF_DRAKE.fullmatch(child.tag):
            problem = f"<{child.tag}> is not covered{_ADVICE}"
            raise xml.error(child, (child.tag,), problem)
