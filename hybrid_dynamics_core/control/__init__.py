"""Model-based control: trajectories of the active joints, and controllers that follow them."""

from .compensation import ForceCompensation
from .controllers import ComputedTorque, FeedForward, GravityCompensation, efforts_along
from .momentum_observer import MomentumObserver, Residuals
from .trajectory import JointTrajectory, Reference

__all__ = [
    "ComputedTorque",
    "FeedForward",
    "ForceCompensation",
    "GravityCompensation",
    "JointTrajectory",
    "MomentumObserver",
    "Reference",
    "Residuals",
    "efforts_along",
]
