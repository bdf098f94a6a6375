"""Model-based control: trajectories of the active joints, and controllers that a simulation or a machine can call."""

from .controllers import ComputedTorque, FeedForward, GravityCompensation, efforts_along
from .trajectory import JointTrajectory, Reference

__all__ = [
    "ComputedTorque",
    "FeedForward",
    "GravityCompensation",
    "JointTrajectory",
    "Reference",
    "efforts_along",
]
