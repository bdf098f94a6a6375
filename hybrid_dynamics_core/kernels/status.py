"""Status codes that every kernel knows; a program's checks have positive ones of their own."""

GOOD = 0
NOT_FINITE = -2  # an input or a result is not a finite number
NOT_TAKEN = -3  # a compiled function was called with other arrays than it takes: nothing was computed
