"""The vocabulary of SDFormat 1.7 to 1.12: what is read, and what changes no robot.

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

_OLDEST = (1, 7)
_CONVERT = "'gz sdf -p FILE' prints a file in the newest version"
_ADVICE = f"; it may change the robot, so it is not passed over: take it out ({_CONVERT})"
_WITHOUT_EFFECT = (
    "visual collision sensor projector audio_sink audio_source battery light particle_emitter"
    " plugin self_collide"
)
_ADDED_MASS = {"".join(pair): "0" for pair in combinations_with_replacement("xyzpqr", 2)}

_WORLD = vocabulary(
    "name",
    "model gravity include frame light actor plugin road audio wind magnetic_field atmosphere gui"
    " physics scene spherical_coordinates state population",
)
_MODEL: dict[str, Vocabulary] = {
    "model": vocabulary(
        "name canonical_link namespace",
        f"link joint frame pose plugin gripper self_collide allow_auto_disable {TAG}",
        static="false",
        enable_wind="false",
        placement_frame="__model__",
    ),
    "link": vocabulary(
        "name",
        f"pose inertial velocity_decay {_WITHOUT_EFFECT}",
        gravity="true",
        kinematic="false",
        enable_wind="false",
        must_be_base_link="false",
    ),
    "velocity_decay": vocabulary(linear="0", angular="0"),
    "inertial": vocabulary(
        "", "mass pose inertia fluid_added_mass density auto_inertia_params", auto="false"
    ),
    "inertia": vocabulary("", "ixx iyy izz ixy ixz iyz"),
    "fluid_added_mass": vocabulary(**_ADDED_MASS),
    "joint": vocabulary(
        "name type",
        "parent child pose axis axis2 sensor plugin physics "
        # of types that are refused
        "gearbox_ratio gearbox_reference_body thread_pitch screw_thread_pitch",
    ),
    "axis": vocabulary(
        "", "xyz limit dynamics mimic", use_parent_model_frame="false", initial_position="0"
    ),
    "xyz": vocabulary("expressed_in"),
    "limit": vocabulary("", "lower upper effort velocity stiffness dissipation"),
    "dynamics": vocabulary("", "damping friction spring_reference spring_stiffness"),
    "mimic": vocabulary("joint", "multiplier offset reference", axis="axis"),
    "frame": vocabulary("name attached_to", "pose"),
    "pose": vocabulary("relative_to rotation_format degrees", frame=""),
    "model/pose": vocabulary("rotation_format degrees", relative_to="world", frame=""),
    "inertial/pose": vocabulary("rotation_format degrees", relative_to="", frame=""),
}


def check_version(xml: XmlReader) -> None:
    """Check that a file counts poses and axes as this library does.

    Raises:
        DescriptionError: its version is older than 1.7, or none.
    """
    version = xml.root.get("version")
    match = re.fullmatch(r"\s*(\d+)\.(\d+)(\.\d+)?\s*", version)
    if match is None or (int(match[1]), int(match[2])) < _OLDEST:
        raise xml.error(
            xml.root,
            ("version",),
            f"is '{version}'; expected 1.7 or later, since older files give poses and axes in other"
            f" frames; {_CONVERT}",
        )


def check_vocabulary(xml: XmlReader, model: LocatedElement, world: LocatedElement | None) -> None:
    """Check a model, and the world around it, for entries that may change the robot.

    Raises:
        DescriptionError: the first one that is not covered.
    """
    VocabularyCheck(xml, _MODEL, _ADVICE).check(model)
    if world is not None:
        VocabularyCheck(xml, {"world": _WORLD}, _ADVICE).check(world)
