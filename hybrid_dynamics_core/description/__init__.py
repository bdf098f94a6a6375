"""Robot descriptions: immutable data, checked when built. Nothing here solves equations."""

from .model import Closure, Frame, Joint, Link, Loop, Mimic, RobotDescription

__all__ = ["Closure", "Frame", "Joint", "Link", "Loop", "Mimic", "RobotDescription"]
