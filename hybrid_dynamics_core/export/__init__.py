"""Robots in the formats of other tools; `load` reads back all that carry loops."""

from .gepetto import Pair, to_gepetto
from .mjcf import to_mjcf
from .sdf import to_sdf
from .urdf import to_urdf
from .urdf_plus import to_urdf_plus

__all__ = ["Pair", "to_gepetto", "to_mjcf", "to_sdf", "to_urdf", "to_urdf_plus"]
