"""Model-based control: trajectories of the active joints, and controllers that follow them."""

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
