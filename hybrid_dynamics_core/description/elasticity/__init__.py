"""Compliance of drives, pins and links, as immutable data."""

from .beams import Beam, LinkMatrix, Section, box_section, tube_section
from .data import Elasticity
from .supports import Bearing, Belt, DriveStiffness, OilColumn

__all__ = [
    "Beam",
    "Bearing",
    "Belt",
    "DriveStiffness",
    "Elasticity",
    "LinkMatrix",
    "OilColumn",
    "Section",
    "box_section",
    "tube_section",
]
