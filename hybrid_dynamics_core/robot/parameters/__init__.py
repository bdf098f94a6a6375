"""Numbers of a robot's description as arguments."""

from .changed import with_parameters

__all__ = ["with_parameters"]
