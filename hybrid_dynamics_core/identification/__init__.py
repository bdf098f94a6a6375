"""Parameters from measured motion: what can be known at all, estimates with confidence, physical consistency."""

from .base import BaseParameters, base_parameters
from .estimate import Identification, TooLittleShownError, identify
from .excite import random_motion
from .outliers import noise_limit, robust_deviation

__all__ = [
    "BaseParameters",
    "Identification",
    "TooLittleShownError",
    "base_parameters",
    "identify",
    "noise_limit",
    "random_motion",
    "robust_deviation",
]
