"""Geometry of a robot from measurements: lengths, pins, axes, encoder offsets, frames."""

from .adjustable import AdjustableRobot, FreeParameter
from .calibrate import calibrate
from .choice import PoseChoice, choose_poses
from .new_file import new_text
from .result import Calibration, Estimate, Misfit, OutlyingRow
from .unseen import Unseen
from .validation import Validation, validate

__all__ = [
    "AdjustableRobot",
    "Calibration",
    "Estimate",
    "FreeParameter",
    "Misfit",
    "OutlyingRow",
    "PoseChoice",
    "Unseen",
    "Validation",
    "calibrate",
    "choose_poses",
    "new_text",
    "validate",
]
