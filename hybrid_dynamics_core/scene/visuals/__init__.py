"""Visuals of links as triangles: primitive shapes, and meshes read by another process."""
