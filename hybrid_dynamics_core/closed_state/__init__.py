"""From active coordinates to a closed state.

Solving, continuation, assembly modes, and why a loop does not close.
"""
