"""Kinematics and dynamics of hybrid robots: serial arms with closed loops, from the active joints alone.

>>> from hybrid_dynamics_core import load
>>> robot = load("forging_chu2020")
>>> state = robot.close([0.0, 0.1, 0.15, 0.0])
>>> tau = robot.inverse_dynamics(state, [0.0, 0.0, 0.0, 0.0])
"""

from .description.effects import Payload
from .dynamics.loads import JointEffects, Loads
from .errors import (
    ClosureError,
    DescriptionError,
    HybridDynamicsError,
    InputError,
    MassSingularityError,
    SingularityError,
)
from .kinematics.inverse import IKStatus
from .kinematics.pose import Pose
from .kinematics.solve import IKResult
from .library import load, shipped_robots
from .robot import Robot
from .state import ClosedState, ClosureStatus

__version__ = "0.1.0"

__all__ = [
    "ClosedState",
    "ClosureError",
    "ClosureStatus",
    "DescriptionError",
    "HybridDynamicsError",
    "IKResult",
    "IKStatus",
    "InputError",
    "JointEffects",
    "Loads",
    "MassSingularityError",
    "Payload",
    "Pose",
    "Robot",
    "SingularityError",
    "load",
    "shipped_robots",
]
