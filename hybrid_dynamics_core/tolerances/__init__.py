"""Errors of the tool from tolerances of lengths and play of pins, through closed loops."""

from .analysis import ToleranceAnalysis
from .entries import Play, Tolerance
from .linear import Contribution, LinearErrors
from .monte_carlo import SampledErrors
from .table_text import table_of

__all__ = [
    "Contribution",
    "LinearErrors",
    "Play",
    "SampledErrors",
    "Tolerance",
    "ToleranceAnalysis",
    "table_of",
]
