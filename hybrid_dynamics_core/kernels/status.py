"""Status codes that need no program: below zero, since a program's checks have positive ones of their own."""

GOOD = 0
# a state that closes, but not on a smooth way from the start: what follows motions gives it, no
# kernel does
JUMP = -1
NOT_FINITE = -2  # an input or a result is not a finite number
NOT_TAKEN = (
    -3
)  # a compiled function was called with other arrays than it takes: nothing was computed
