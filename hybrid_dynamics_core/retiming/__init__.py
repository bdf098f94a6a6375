"""Motions along paths, as fast as the limits of drives, cylinders and pumps allow."""

from .motion import MotionPoint, TimedMotion
from .point_to_point import JerkLimitedMotion, point_to_point
from .retime import retime

__all__ = ["JerkLimitedMotion", "MotionPoint", "TimedMotion", "point_to_point", "retime"]
