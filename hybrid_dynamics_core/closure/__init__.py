"""Closing the loops: each block of the plan solves a few unknowns from the coordinates before it.

The layers, from the top: closed_motion, plan, branch and mobility, loop_gap and toggle_range,
blocks, matching and rank, constraints. Imports go downward only.
"""
