"""What a robot is, as frozen data, checked where it is made. Nothing here solves anything."""

from .model import Closure, Frame, Joint, Link, Loop, Mimic, RobotDescription

__all__ = ["Closure", "Frame", "Joint", "Link", "Loop", "Mimic", "RobotDescription"]
