"""The design procedure of Chu et al. (2020): from classes, types and dimensions to a robot."""

from .classes import CLASSES, RobotClass, robot_text
from .outcome import Outcome, outcome_of
from .report import report_text
from .usual_cycle import cycle_text, usual_cycle

__all__ = [
    "CLASSES",
    "Outcome",
    "RobotClass",
    "cycle_text",
    "outcome_of",
    "report_text",
    "robot_text",
    "usual_cycle",
]
