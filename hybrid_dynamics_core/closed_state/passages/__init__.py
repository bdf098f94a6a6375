"""Singular places that a motion passes: change points, and toggles where given coordinates turn.

On its own branch a mechanism moves smoothly through both. What fails there is the division by J_z.
So nothing is computed at the place itself: configurations at both sides of it are interpolated.
"""
