"""What a robot is: a file becomes frozen data, checked where it is made. Nothing here solves anything."""

from .model import Closure, Frame, Joint, Link, Loop, RobotDescription
from .reader import read_description

__all__ = ["Closure", "Frame", "Joint", "Link", "Loop", "RobotDescription", "read_description"]
