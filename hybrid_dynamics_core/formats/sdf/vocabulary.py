"""The vocabulary of SDFormat 1.2 to 1.12: words that are read, or left out with a note.

http://sdformat.org/spec. Collisions, sensors, plugins and engine settings are left out: they change
no mass, pose or axis.
"""

from __future__ import annotations

import re
from itertools import combinations_with_replacement

from ..extras_reader import TAG
from ..xml.located_xml import LocatedElement
from ..xml.reader import XmlReader
from ..xml.vocabulary import Vocabulary, VocabularyCheck, vocabulary
from .versions import CONVERT, NAMED_FRAMES, Version

_ADVICE = f"; it may change the robot, so it is not passed over: take it out ({CONVERT})"
_OMITTED = (
    "collision sensor projector audio_sink audio_source battery light particle_emitter"
    " plugin self_collide contact enable_wind velocity_decay static"
)
_ADDED_MASS = {"".join(pair): "0" for pair in combinations_with_replacement("xyzpqr", 2)}
_ROTATION = "rotation_format degrees"
_NAMED = ("link", "joint", "frame", "model")
WELD = "drake:weld_constraint"
_FORCES_OF_DRAKE = re.compile("drake:.*(constraint|bushing|acceleration)")

_WORLD = vocabulary(
    "name",
    "model include joint frame gravity",
    "light actor plugin road audio wind magnetic_field atmosphere gui physics scene"
    " spherical_coordinates state population",
)
INCLUDE = vocabulary("merge", "uri name pose placement_frame static", "plugin")
_AXIS = vocabulary(
    "", "xyz limit dynamics mimic", "initial_position pose", use_parent_model_frame="false"
)
_OLDER_AXIS = vocabulary(
    "", "xyz limit dynamics mimic use_parent_model_frame", "initial_position pose"
)
_MODEL: dict[str, Vocabulary] = {
    "model": vocabulary(
        "name canonical_link placement_frame",
        f"model include link joint frame pose {TAG}",
        "namespace plugin gripper self_collide allow_auto_disable enable_wind",
        static="false",
    ),
    "link": vocabulary(
        "name",
        "pose inertial gravity visual kinematic",
        _OMITTED,
        must_be_base_link="false",
    ),
    "inertial": vocabulary(
        "auto", "mass pose inertia fluid_added_mass density", "auto_inertia_params"
    ),
    "inertia": vocabulary("", "ixx iyy izz ixy ixz iyz"),
    "fluid_added_mass": vocabulary(**_ADDED_MASS),
    "joint": vocabulary(
        "name type",
        "parent child pose axis axis2 thread_pitch screw_thread_pitch gearbox_ratio"
        " gearbox_reference_body",
        "sensor plugin physics",
    ),
    "axis": _AXIS,
    "axis2": _AXIS,
    "xyz": vocabulary("expressed_in"),
    "limit": vocabulary("", "lower upper effort velocity", "stiffness dissipation"),
    "dynamics": vocabulary("", "damping friction spring_reference spring_stiffness"),
    "mimic": vocabulary("joint", "multiplier offset reference", axis="axis"),
    "frame": vocabulary("name attached_to", "pose"),
    "pose": vocabulary(f"relative_to {_ROTATION}", frame=""),
    "inertial/pose": vocabulary(f"relative_to {_ROTATION}", frame=""),
}


def check_world(xml: XmlReader, world: LocatedElement) -> None:
    """Check the world around a model for unsupported content that may change the robot.

    Raises:
        DescriptionError: the first unsupported entry.
    """
    check_words(xml, _WORLD, world)
    _refuse_forces(xml, world)


def check_model(xml: XmlReader, model: LocatedElement, version: Version) -> None:
    """Check a model, and nested models, for unsupported content that may change the robot.

    Raises:
        DescriptionError: the first unsupported element.
    """
    table = dict(_MODEL)
    if version < NAMED_FRAMES:
        table |= dict.fromkeys(("axis", "axis2"), _OLDER_AXIS)
    _check(xml, table, model)
    _check_names(xml, model, version)


def check_words(xml: XmlReader, words: Vocabulary, element: LocatedElement) -> None:
    """Check one element alone."""
    _check(xml, {element.tag: words}, element)


def _check_names(xml: XmlReader, model: LocatedElement, version: Version) -> None:
    """Refuse duplicate names, since the version in which names refer to frames."""
    _refuse_forces(xml, model)
    named: dict[str, LocatedElement] = {}
    for element in model.children:
        if element.tag == "model":
            _check_names(xml, element, version)
        if element.tag not in _NAMED or version < NAMED_FRAMES:
            continue
        other = named.setdefault(element.get("name"), element)
        if other is not element:
            problem = f"has the name of a {other.tag} (line {other.line}); rename one of the two"
            raise xml.error_at(element, problem)


def _check(xml: XmlReader, table: dict[str, Vocabulary], element: LocatedElement) -> None:
    check = VocabularyCheck(xml, table, _ADVICE)
    check.check(element)
    check.add_notes()


def _refuse_forces(xml: XmlReader, element: LocatedElement) -> None:
    """Refuse Drake's constraints and force elements; other foreign elements have no effect."""
    for child in element.children:
        if _FORCES_OF_DRAKE.fullmatch(child.tag) and child.tag != WELD:
            problem = f"<{child.tag}> is not covered{_ADVICE}"
            raise xml.error(child, (child.tag,), problem)
