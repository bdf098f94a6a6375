"""Robot files: a folder for each format, with its reader and its writer side by side."""

from .reader import read_description, read_urdf

__all__ = ["read_description", "read_urdf"]
