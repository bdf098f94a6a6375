"""Robot files: a folder for each format, with its reader and its writer side by side.

A new format is a folder. Its reader makes a `Document` of a file, and `reader` calls it. Its writer
makes the text of a robot, and `export` names it. Both share `extras_reader` and `extras_writer` for
what the format has no words for, `shapes` for what links are drawn as, and `xml`.
"""

from .reader import read_description, read_urdf

__all__ = ["read_description", "read_urdf"]
