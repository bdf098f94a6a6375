"""Numbers of a description by name or path: list, read and change them."""

from .paths import parameter_paths, parameter_value, with_parameters

__all__ = ["parameter_paths", "parameter_value", "with_parameters"]
