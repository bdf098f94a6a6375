"""Parameters from measured motion: what can be known at all, estimates with confidence, physical consistency."""

from .base import BaseParameters, base_parameters
from .estimate import Identification, TooLittleShownError, identify
from .excite import random_motion

__all__ = ["BaseParameters", "Identification", "TooLittleShownError", "base_parameters", "identify", "random_motion"]
