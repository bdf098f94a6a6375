"""Robots in the formats of other tools."""

from .urdf import to_urdf

__all__ = ["to_urdf"]
