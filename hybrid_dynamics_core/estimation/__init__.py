"""What measurements of a machine show: the load at its tool, with honest intervals."""

from .payload import PayloadEstimate, estimate_payload
from .run import MeasuredRun
from .sensors import SensorError
from .tolerances import Tolerances

__all__ = ["MeasuredRun", "PayloadEstimate", "SensorError", "Tolerances", "estimate_payload"]
