"""Motions along paths, as fast as the limits of drives, cylinders and pumps allow."""

from .motion import MotionPoint, TimedMotion
from .retime import retime

__all__ = ["MotionPoint", "TimedMotion", "retime"]
