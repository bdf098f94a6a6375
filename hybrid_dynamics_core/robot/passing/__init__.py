"""Motions through singular places: other independent coordinates, and crossings ahead."""

from .other_coordinates import better_coordinates, with_active
from .singular_places import SingularPlaces

__all__ = ["SingularPlaces", "better_coordinates", "with_active"]
