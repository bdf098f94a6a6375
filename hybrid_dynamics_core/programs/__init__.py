"""Closure, kinematics and minimal-form dynamics as programs over scalars.

A program takes named vectors of scalars and returns named outputs with the checks that guard them.
It runs on floats as it is, on arrays (one array a scalar), or traced into a kernel. Chu (2020)
gives the equations.
"""

from . import sensing
from .actuation import HYDRAULICS, generalised_forces, hydraulics
from .centroidal import centroidal
from .closure import ACCELERATIONS, CLOSE, MOTION
from .derivatives import (
    directional,
    forward_dynamics_derivatives,
    inverse_dynamics_derivatives,
    slopes,
)
from .dynamics import (
    closed_inverse_dynamics,
    inverse_dynamics,
    minimal_form,
    passive_forces,
)
from .energy import energy, motion, motion_and_configuration
from .forward import forward_dynamics
from .kinematics import forward_kinematics, jacobian, pose_and_jacobian
from .matrices import coriolis_matrix, spanning_terms
from .model import SINGULAR, Inputs, Model, Program
from .outcome import Outcome, OutcomeKind, kinds
from .reactions import reactions
from .regressor import regressor
from .rounded import SLACK_32, of_rounded
from .steps import TARGET, ik_step
from .warm_start import PLACE, STEP, warm_started

__all__ = [
    "ACCELERATIONS",
    "CLOSE",
    "HYDRAULICS",
    "MOTION",
    "PLACE",
    "SINGULAR",
    "SLACK_32",
    "STEP",
    "TARGET",
    "Inputs",
    "Model",
    "Outcome",
    "OutcomeKind",
    "Program",
    "centroidal",
    "closed_inverse_dynamics",
    "coriolis_matrix",
    "directional",
    "energy",
    "forward_dynamics",
    "forward_dynamics_derivatives",
    "forward_kinematics",
    "generalised_forces",
    "hydraulics",
    "ik_step",
    "inverse_dynamics",
    "inverse_dynamics_derivatives",
    "jacobian",
    "kinds",
    "minimal_form",
    "motion",
    "motion_and_configuration",
    "of_rounded",
    "passive_forces",
    "pose_and_jacobian",
    "reactions",
    "regressor",
    "sensing",
    "slopes",
    "spanning_terms",
    "warm_started",
]
