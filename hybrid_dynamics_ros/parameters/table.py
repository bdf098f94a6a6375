"""All parameters of the node."""

from __future__ import annotations

import re
from typing import Any, Final

from . import diagnostics, frames, inputs, outputs, robot, services
from .row import Parameter

TABLE: Final[tuple[Parameter[Any], ...]] = (
    *robot.ROWS,
    *inputs.ROWS,
    *outputs.ROWS,
    *frames.ROWS,
    *services.ROWS,
    *diagnostics.ROWS,
)

# Parameters that rclpy declares, which may be in files with all parameters of a node.
ROS_NAMES: Final = re.compile(r"use_sim_time|start_type_description_service|qos_overrides\..+")
