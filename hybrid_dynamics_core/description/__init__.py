"""What a robot is: a file becomes frozen data, checked where it is made. Nothing here solves anything."""

from .model import Closure, Frame, Joint, Link, Loop, Mimic, RobotDescription
from .reader import read_description, read_urdf

__all__ = ["Closure", "Frame", "Joint", "Link", "Loop", "Mimic", "RobotDescription", "read_description", "read_urdf"]
