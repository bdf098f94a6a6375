"""Robots in the formats of other tools, and their model as C99, FMU and ros2_control package."""

from ..formats.c.writer import to_c
from ..formats.fmu.writer import FunctionalMockupUnit, to_fmu
from ..formats.gepetto.writer import Pair, to_gepetto
from ..formats.mjcf.writer import to_mjcf
from ..formats.ros2_control.writer import to_ros2_control
from ..formats.sdf.writer import to_sdf
from ..formats.urdf.plus_writer import to_urdf_plus
from ..formats.urdf.writer import to_urdf
from ..formats.yaml.writer import to_yaml

__all__ = [
    "FunctionalMockupUnit",
    "Pair",
    "to_c",
    "to_fmu",
    "to_gepetto",
    "to_mjcf",
    "to_ros2_control",
    "to_sdf",
    "to_urdf",
    "to_urdf_plus",
    "to_yaml",
]
