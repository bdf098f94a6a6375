"""The model's answers as programs over scalars: the one text of closure, kinematics and minimal-form dynamics.

A program takes named vectors of scalars and returns named outputs with the checks that guard them. It runs on floats
as it stands, on arrays (one array a scalar), or traced into a kernel. Chu (2020) gives the equations.
"""

from .closure import ACCELERATIONS, CLOSE, MOTION
from .dynamics import INVERSE_DYNAMICS, MINIMAL_FORM
from .kinematics import forward_kinematics, jacobian
from .model import Inputs, Model, Program, closure_code, singular_code

__all__ = [
    "ACCELERATIONS",
    "CLOSE",
    "INVERSE_DYNAMICS",
    "MINIMAL_FORM",
    "MOTION",
    "Inputs",
    "Model",
    "Program",
    "closure_code",
    "forward_kinematics",
    "jacobian",
    "singular_code",
]
