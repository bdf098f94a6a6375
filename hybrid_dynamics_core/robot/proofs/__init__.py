"""What can be proved of a robot's states."""

from .certification import Certification

__all__ = ["Certification"]
