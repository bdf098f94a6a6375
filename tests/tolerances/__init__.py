"""Tolerances of lengths and play of pins."""
