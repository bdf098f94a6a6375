"""From active coordinates to a closed state.

It solves the closure, follows motions, lists assembly modes, and explains why a loop does not
close.
"""
