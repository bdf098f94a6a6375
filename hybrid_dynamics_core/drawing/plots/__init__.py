"""Plots over time: a simulation, and scales that hide rounding."""
