"""What a robot can do within the limits of its drives: forces, accelerations, speeds, loads."""

from .capability import Capability, Largest
from .polytope import Polytope

__all__ = ["Capability", "Largest", "Polytope"]
