"""Kinematics and dynamics of hybrid robots: serial arms with closed loops.

>>> from hybrid_dynamics_core import load
>>> robot = load("forging_chu2020")
>>> state = robot.close([0.0, 0.1, 0.15, 0.0])
>>> tau = robot.inverse_dynamics(state, [0.0, 0.0, 0.0, 0.0])
"""

from .closed_state.state import ClosedState, ClosureStatus
from .description.actuators import HydraulicCylinder
from .description.effects import Payload
from .dynamics.centroidal import Centroidal
from .dynamics.dae import SpanningTerms
from .dynamics.distribution import Distribution
from .dynamics.energy import Energy
from .dynamics.hydraulics import (
    CylinderState,
    chamber_flows,
    chamber_pressures,
    cylinder_force,
    force_range,
)
from .dynamics.loads import JointEffects, Loads
from .dynamics.parameters import Parameters
from .dynamics.reactions import JointReaction, PinReaction, Reactions
from .errors import (
    ClosureError,
    DescriptionError,
    HybridDynamicsError,
    InputError,
    MassSingularityError,
    SingularityError,
    StateError,
    UndecidedModeError,
)
from .kinematics.ik_batch import IKBatch
from .kinematics.ik_descent import IKStatus
from .kinematics.inverse_kinematics import IKResult
from .kinematics.pose import Pose
from .kinematics.workspace import Margins, SampleStatus, Workspace
from .library import load, shipped_robots
from .robot.joint_poses import TwistMap
from .robot.robot import Robot

__version__ = "0.1.0"

__all__ = [
    "Centroidal",
    "ClosedState",
    "ClosureError",
    "ClosureStatus",
    "CylinderState",
    "DescriptionError",
    "Distribution",
    "Energy",
    "HybridDynamicsError",
    "HydraulicCylinder",
    "IKBatch",
    "IKResult",
    "IKStatus",
    "InputError",
    "JointEffects",
    "JointReaction",
    "Loads",
    "Margins",
    "MassSingularityError",
    "Parameters",
    "Payload",
    "PinReaction",
    "Pose",
    "Reactions",
    "Robot",
    "SampleStatus",
    "SingularityError",
    "SpanningTerms",
    "StateError",
    "TwistMap",
    "UndecidedModeError",
    "Workspace",
    "chamber_flows",
    "chamber_pressures",
    "cylinder_force",
    "force_range",
    "load",
    "shipped_robots",
]
