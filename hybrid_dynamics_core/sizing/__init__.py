"""Sizing of drives: the smallest cylinder or motor of a catalogue that meets a duty cycle."""

from .catalogue import Catalogue, CatalogueCylinder, CatalogueMotor, read_catalogue
from .checks import Candidate, Check, Margins
from .choice import Sizing, size_drive
from .cylinders import euler_load
from .demand import Demand, closed_duty, demand_of
from .duty import DutyCycle, read_duty
from .pins import pin_distance

__all__ = [
    "Candidate",
    "Catalogue",
    "CatalogueCylinder",
    "CatalogueMotor",
    "Check",
    "Demand",
    "DutyCycle",
    "Margins",
    "Sizing",
    "closed_duty",
    "demand_of",
    "euler_load",
    "pin_distance",
    "read_catalogue",
    "read_duty",
    "size_drive",
]
