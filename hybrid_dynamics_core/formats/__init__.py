"""Robot files: a folder for each format, with its reader and its writer side by side.

A new format is a folder. Its reader turns a file into a `Document`, and `reader` calls it. Its
writer turns a robot into a text, and `export` offers it. All share `extras_reader` and
`extras_writer` for data that a format cannot express, `shapes` for the shapes of links, and `xml`.
"""

from .reader import read_description, read_urdf

__all__ = ["read_description", "read_urdf"]
