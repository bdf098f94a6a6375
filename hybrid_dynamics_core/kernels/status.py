"""Status codes that belong to no block of a closure plan.

They are zero or negative: the checks of a program have positive codes.
"""

GOOD = 0
# The state closes, but not continuously from the start. Continuation sets it, no kernel does.
JUMP = -1
# An input or a result is not a finite number.
NOT_FINITE = -2
# A compiled function was called with unsuitable arrays. Nothing was computed.
NOT_TAKEN = -3
# M-bar is singular: some motion of the active joints moves no mass.
MASS_SINGULAR = -4
