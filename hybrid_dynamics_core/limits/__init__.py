"""Limits of a robot and its drives: what is beyond, by how much, and what drives give within."""

from .limits import Limits
from .margins import LimitMargins, Margin, limit_margins
from .saturation import saturated

__all__ = ["LimitMargins", "Limits", "Margin", "limit_margins", "saturated"]
