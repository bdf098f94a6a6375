"""Functions over scalars besides Python's operators.

A scalar of a filter is a float, an array with one entry a joint, or a `doubles.Double`. All three
round after every operation, in the same order, so they agree to the last bit.
"""

from __future__ import annotations

import math
from typing import Any

Scalar = Any  # float | NDArray[float64] | doubles.Double
Scalars = Any  # a sequence of scalars, or an array of which each row is one


def exp(x: Scalar) -> Scalar:
    """Exponential function: that of the C library."""
    return math.exp(x) if isinstance(x, float) else x.exp()


def expm1(x: Scalar) -> Scalar:
    """exp(x) - 1, for x near 0 too: that of the C library."""
    return math.expm1(x) if isinstance(x, float) else x.expm1()


def choose(a: Scalar, b: Scalar, yes: Scalar, no: Scalar) -> Scalar:
    """`yes` if a > b, otherwise `no`, without a branch in compiled code; not for arrays."""
    if isinstance(a, float):
        return yes if a > b else no
    return a.choose(b, yes, no)


def choose_each(a: Scalar, b: Scalar, yes: Scalars, no: Scalars) -> Scalars:
    """The scalars of `yes` if a > b, otherwise those of `no`."""
    if isinstance(a, float):
        return yes if a > b else no
    return [a.choose(b, x, y) for x, y in zip(yes, no, strict=True)]
