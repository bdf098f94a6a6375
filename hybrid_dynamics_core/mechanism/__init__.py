"""The spanning tree behind a description: bodies, joints and the coordinates u, z, s."""

from .tree import Body, Tree, build_tree

__all__ = ["Body", "Tree", "build_tree"]
