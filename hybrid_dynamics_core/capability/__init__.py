"""What a robot can do within the limits of its drives: forces, accelerations, speeds, loads."""

from .capability import Capability, Largest, capability_at
from .lifting import LiftingChart, lifting_chart
from .polytope import Polytope

__all__ = ["Capability", "Largest", "LiftingChart", "Polytope", "capability_at", "lifting_chart"]
