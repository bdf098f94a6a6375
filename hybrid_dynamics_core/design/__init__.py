"""Design of robots: variables, duty cycles, objectives and constraints with exact gradients."""

from .cycle import Cycle, Duty
from .cylinders import BORES, Bore, size_bores
from .four_bar import Dyad, FourBar, burmester, centre, freudenstein, through_poses
from .problem import Design
from .quantity import Quantity
from .solution import DesignResult

__all__ = [
    "BORES",
    "Bore",
    "Cycle",
    "Design",
    "DesignResult",
    "Duty",
    "Dyad",
    "FourBar",
    "Quantity",
    "burmester",
    "centre",
    "freudenstein",
    "size_bores",
    "through_poses",
]
