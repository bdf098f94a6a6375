"""What measurements of a machine show: load and force at its tool, with honest intervals."""

from .payload import PayloadEstimate, estimate_payload
from .run import MeasuredRun
from .sensors import SensorError
from .tolerances import Tolerances
from .tool_force import ToolForceModel, ToolForceObserver, ToolForceOptions, tool_force
from .wrench import ToolForce
from .zeroing import Deviation, deviation_of

__all__ = [
    "Deviation",
    "MeasuredRun",
    "PayloadEstimate",
    "SensorError",
    "Tolerances",
    "ToolForce",
    "ToolForceModel",
    "ToolForceObserver",
    "ToolForceOptions",
    "deviation_of",
    "estimate_payload",
    "tool_force",
]
