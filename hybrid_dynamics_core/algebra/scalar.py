"""Elementary functions of a float, an array (one entry a state) or any object with such methods.

The algorithms of this package are written once over such scalars. A traced symbol
(`kernels.graph.Symbol`) brings its own methods. Floats go to `math`, arrays to NumPy. A root of a
negative number is NaN everywhere.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

Scalar = Any  # float | NDArray[float64] | kernels.graph.Symbol
Scalars = Sequence[Scalar]


def sin(x: Scalar) -> Scalar:
    """Sine of an angle [rad]."""
    if isinstance(x, (float, int)):
        return math.sin(x)
    if isinstance(x, np.ndarray):
        return np.sin(x)
    return x.sin()


def cos(x: Scalar) -> Scalar:
    """Cosine of an angle [rad]."""
    if isinstance(x, (float, int)):
        return math.cos(x)
    if isinstance(x, np.ndarray):
        return np.cos(x)
    return x.cos()


def sqrt(x: Scalar) -> Scalar:
    """Square root; NaN below zero."""
    if isinstance(x, (float, int)):
        if x >= 0.0:
            return math.sqrt(x)
        return math.nan
    if isinstance(x, np.ndarray):
        with np.errstate(invalid="ignore"):
            return np.sqrt(x)
    return x.sqrt()


def atan2(y: Scalar, x: Scalar) -> Scalar:
    """Angle of the vector (x, y) [rad], in (-pi, pi]."""
    y_is_number = isinstance(y, (float, int))
    if y_is_number and isinstance(x, (float, int)):
        return math.atan2(y, x)
    if isinstance(y, np.ndarray) or isinstance(x, np.ndarray):
        return np.arctan2(y, x)
    if y_is_number:
        return x.atan2_of(y)
    return y.atan2(x)


def larger(a: Scalar, b: Scalar) -> Scalar:
    """The larger of two."""
    if hasattr(a, "absolute") or hasattr(b, "absolute"):
        return 0.5 * (a + b + absolute(a - b))
    return np.maximum(a, b)


def rint(x: Scalar) -> Scalar:
    """The nearest integer, with ties to even; its derivative counts as zero."""
    if isinstance(x, (float, int)):
        return float(np.rint(x))
    if isinstance(x, np.ndarray):
        return np.rint(x)
    return x.rint()


def absolute(x: Scalar) -> Scalar:
    """Absolute value."""
    if isinstance(x, (float, int)):
        return math.fabs(x)
    if isinstance(x, np.ndarray):
        return np.abs(x)
    return x.absolute()
