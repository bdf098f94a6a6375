"""Closing the loops: each block of the plan solves a few unknown coordinates from those already known."""
