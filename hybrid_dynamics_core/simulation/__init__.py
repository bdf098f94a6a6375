"""Simulation: integration in minimal coordinates, with events and a record of the motion."""

from .events import Event
from .integrate import simulate
from .result import Simulation, load_simulation
from .settings import Settings

__all__ = ["Event", "Settings", "Simulation", "load_simulation", "simulate"]
