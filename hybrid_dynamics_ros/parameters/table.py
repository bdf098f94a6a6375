"""All parameters of the node."""

from __future__ import annotations

from typing import Any, Final

from . import diagnostics, inputs, outputs, robot, services
from .row import Parameter

TABLE: Final[tuple[Parameter[Any], ...]] = (
    *robot.ROWS,
    *inputs.ROWS,
    *outputs.ROWS,
    *services.ROWS,
    *diagnostics.ROWS,
)
