"""Boxes of coordinates and efforts, by interval arithmetic over traced graphs."""
