"""The words of SDFormat 1.7 to 1.12: what is read, what changes no robot, and what may have one value only.

http://sdformat.org/spec. Shapes, sensors, plugins and settings of one engine change no mass, no
place and no axis.
"""

from __future__ import annotations

import re
from itertools import combinations_with_replacement

from ..extras_reader import TAG
from ..xml.elements import XmlFile
from ..xml.tree import Element
from ..xml.vocabulary import WordCheck, Words, words

OLDEST = (1, 7)
CONVERT = "'gz sdf -p FILE' prints a file in the newest version"
ADVICE = f"; it may change the robot, so it is not passed over: take it out ({CONVERT})"
SEEN = (
    "visual collision sensor projector audio_sink audio_source battery light particle_emitter"
    " plugin self_collide"
)
ADDED_MASS = {"".join(pair): "0" for pair in combinations_with_replacement("xyzpqr", 2)}

WORLD = words(
    "name",
    "model gravity include frame light actor plugin road audio wind magnetic_field atmosphere gui"
    " physics scene spherical_coordinates state population",
)
ROBOT: dict[str, Words] = {
    "model": words(
        "name canonical_link namespace",
        f"link joint frame pose plugin gripper self_collide allow_auto_disable {TAG}",
        static="false",
        enable_wind="false",
        placement_frame="__model__",
    ),
    "link": words(
        "name",
        f"pose inertial velocity_decay {SEEN}",
        gravity="true",
        kinematic="false",
        enable_wind="false",
        must_be_base_link="false",
    ),
    "velocity_decay": words(linear="0", angular="0"),
    "inertial": words(
        "", "mass pose inertia fluid_added_mass density auto_inertia_params", auto="false"
    ),
    "inertia": words("", "ixx iyy izz ixy ixz iyz"),
    "fluid_added_mass": words(**ADDED_MASS),
    "joint": words(
        "name type",
        "parent child pose axis axis2 sensor plugin physics "
        # of types that are refused
        "gearbox_ratio gearbox_reference_body thread_pitch screw_thread_pitch",
    ),
    "axis": words(
        "", "xyz limit dynamics mimic", use_parent_model_frame="false", initial_position="0"
    ),
    "xyz": words("expressed_in"),
    "limit": words("", "lower upper effort velocity stiffness dissipation"),
    "dynamics": words("", "damping friction spring_reference spring_stiffness"),
    "mimic": words("joint", "multiplier offset reference", axis="axis"),
    "frame": words("name attached_to", "pose"),
    "pose": words("relative_to rotation_format degrees", frame=""),
    "model/pose": words("rotation_format degrees", relative_to="world", frame=""),
    "inertial/pose": words("rotation_format degrees", relative_to="", frame=""),
}


def check_version(xml: XmlFile) -> None:
    """Raise a DescriptionError at a version that counts axes in other frames: up to 1.4 always, to 1.6 where told."""
    told = xml.root.attributes.get("version", "")
    found = re.fullmatch(r"\s*(\d+)\.(\d+)(\.\d+)?\s*", told)
    if found is None or (int(found[1]), int(found[2])) < OLDEST:
        problem = (
            f"is '{told}'; expected 1.7 or later, since older files give poses and axes in other"
            f" frames; {CONVERT}"
        )
        raise xml.error(xml.root, ("version",), problem)


def check_words(xml: XmlFile, model: Element, world: Element | None) -> None:
    """Raise a DescriptionError at the first entry of the robot's model, or of its world, that may change the robot."""
    WordCheck(xml, ROBOT, ADVICE).check(model)
    if world is not None:
        WordCheck(xml, {"world": WORLD}, ADVICE).check(world)
