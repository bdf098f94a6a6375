"""Design of robots: variables, duty cycles, objectives and constraints with exact gradients."""

from .cycle import Cycle, Duty
from .cylinders import BORES, Bore, size_bores
from .four_bar import Dyad, FourBar, burmester, centre, freudenstein, through_poses
from .problem import Design
from .quantity import Quantity, joined
from .recipes import (
    Recipe,
    keep_regular,
    level_force,
    ranged,
    swept_measure,
    widest_workspace,
)
from .solution import DesignResult
from .solvers import Method
from .straight_line import (
    StraightLine,
    Straightness,
    chebyshev_lambda,
    straight_line,
    straightness,
)

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
    "Recipe",
    "StraightLine",
    "Straightness",
    "burmester",
    "centre",
    "chebyshev_lambda",
    "freudenstein",
    "joined",
    "keep_regular",
    "level_force",
    "ranged",
    "size_bores",
    "straight_line",
    "straightness",
    "swept_measure",
    "through_poses",
    "widest_workspace",
]
