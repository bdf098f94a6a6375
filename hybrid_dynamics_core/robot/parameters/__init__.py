"""Numbers of a robot's description as arguments."""

from .changed import with_parameters
from .family import RobotFamily
from .family_result import FamilyResult
from .free import FreeParameters

__all__ = ["FamilyResult", "FreeParameters", "RobotFamily", "with_parameters"]
