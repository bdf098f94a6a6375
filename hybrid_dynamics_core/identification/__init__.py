"""Parameters from measured motion: base parameters, estimates with confidence, consistency."""

from .base import BaseParameters, base_parameters
from .estimate import Identification, TooLittleShownError, identify
from .excite import random_motion
from .outliers import least_deviation, noise_limit, robust_deviation

__all__ = [
    "BaseParameters",
    "Identification",
    "TooLittleShownError",
    "base_parameters",
    "identify",
    "least_deviation",
    "noise_limit",
    "random_motion",
    "robust_deviation",
]
