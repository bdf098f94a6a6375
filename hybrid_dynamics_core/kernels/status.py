"""Status codes that belong to no block of a closure plan.

They are zero or negative: the checks of a program have positive codes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

GOOD = 0
# The state closes, but not continuously from the start. Continuation sets it, no kernel does.
JUMP = -1
# An input or a result is not a finite number.
NOT_FINITE = -2
# A compiled function was called with unsuitable arrays. Nothing was computed.
NOT_TAKEN = -3
# M-bar is singular: some motion of the active joints moves no mass.
MASS_SINGULAR = -4
# An integrator found no step that is short enough. Only its kernels set it.
NO_STEP = -5


def any_failed(codes: NDArray[np.int64]) -> bool:
    """Whether a state of status codes () or (N,) has no answer."""
    if codes.ndim == 0:
        return codes.item() != GOOD  # far quicker than `any`
    return bool(codes.any())
