"""Parameters: thresholds of diagnostics, and periods of logging."""

from __future__ import annotations

from typing import Any, Final

from .row import LARGE, ChangeTime, Parameter


def _threshold(name: str, default: float, text: str, unit: str) -> Parameter[float]:
    """A threshold above which diagnostics warn or report an error."""
    return Parameter(
        f"diagnostics.{name}", default, text, unit, (0.0, LARGE), change=ChangeTime.ANY_TIME
    )


DIAGNOSTICS_PERIOD: Final = Parameter[float](
    "diagnostics.period",
    1.0,
    "Time between two messages on /diagnostics.",
    unit="s",
    bounds=(0.05, 3600.0),
    change=ChangeTime.NEVER,
)
LEAST_RATE: Final = _threshold(
    "least_rate", 0.0, "Warn where the rate of the input is lower than this.", "Hz"
)
LATEST_AGE: Final = _threshold(
    "latest_age", 1.0, "Warn where the newest stamp is off the node's clock by more than this.", "s"
)
LATENCY: Final = _threshold(
    "latency", 0.02, "Warn where more than 1 % of the inputs take the node longer than this.", "s"
)
RESIDUAL: Final = _threshold(
    "residual", 1e-6, "Error where the residual of the loops is larger than this.", "1"
)
SINGULARITY_WARN: Final = _threshold(
    "singularity_warn", 0.1, "Warn nearer to a singularity than this: 0 singular, 1 best.", "1"
)
SINGULARITY_ERROR: Final = _threshold(
    "singularity_error", 0.02, "Error nearer to a singularity than this: 0 singular, 1 best.", "1"
)
STROKE_WARN: Final = _threshold(
    "stroke_warn", 0.01, "Warn nearer to the end of a stroke than this.", "rad or m"
)
STROKE_ERROR: Final = _threshold(
    "stroke_error", 0.0, "Error nearer to the end of a stroke than this; 0: beyond it.", "rad or m"
)
LOG_PERIOD: Final = Parameter[float](
    "log_period",
    5.0,
    "Least time between two log lines of the same kind about bad input.",
    unit="s",
    bounds=(0.0, 3600.0),
    change=ChangeTime.ANY_TIME,
)

ROWS: Final[tuple[Parameter[Any], ...]] = (
    DIAGNOSTICS_PERIOD,
    LEAST_RATE,
    LATEST_AGE,
    LATENCY,
    RESIDUAL,
    SINGULARITY_WARN,
    SINGULARITY_ERROR,
    STROKE_WARN,
    STROKE_ERROR,
    LOG_PERIOD,
)
