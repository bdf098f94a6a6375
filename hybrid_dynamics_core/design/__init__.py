"""Design of robots: variables, duty cycles, objectives and constraints with exact gradients."""

from .cycle import Cycle, Duty
from .cylinders import BORES, Bore, size_bores
from .four_bar import Dyad, FourBar, burmester, centre, freudenstein, through_poses
from .problem import Design
from .quantity import Quantity, joined
from .solution import DesignResult
from .solvers import Method

__all__ = [
    "BORES",
    "Bore",
    "Cycle",
    "Design",
    "DesignResult",
    "Duty",
    "Dyad",
    "FourBar",
    "Method",
    "Quantity",
    "burmester",
    "centre",
    "freudenstein",
    "joined",
    "size_bores",
    "through_poses",
]
