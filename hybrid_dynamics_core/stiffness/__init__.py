"""Stiffness with drives locked: compliance of drives, pins and links at a frame, and modes."""

from ..description.elasticity import (
    Beam,
    Bearing,
    Belt,
    DriveStiffness,
    Elasticity,
    LinkMatrix,
    OilColumn,
    Section,
    box_section,
    tube_section,
)
from .loaded.stiffness import LoadedStiffness
from .modes import Modes
from .stiffness import Deflection, Stiffness, stiffness_at
from .stiffness_map import StiffnessMap, stiffness_map

__all__ = [
    "Beam",
    "Bearing",
    "Belt",
    "Deflection",
    "DriveStiffness",
    "Elasticity",
    "LinkMatrix",
    "LoadedStiffness",
    "Modes",
    "OilColumn",
    "Section",
    "Stiffness",
    "StiffnessMap",
    "box_section",
    "stiffness_at",
    "stiffness_map",
    "tube_section",
]
