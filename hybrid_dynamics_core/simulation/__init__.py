"""Motion in time from forces: integration in minimal coordinates, watched and recorded."""

from .events import Event
from .integrate import simulate
from .result import Simulation, load_simulation
from .settings import Settings

__all__ = ["Event", "Settings", "Simulation", "load_simulation", "simulate"]
