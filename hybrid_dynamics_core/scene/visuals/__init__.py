"""Visuals of links as triangles: primitive shapes, and meshes that a process of its own reads."""
