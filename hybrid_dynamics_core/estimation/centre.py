"""The centre of mass of a load: given, or from its first moment."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError
from ..ground.arrays import Array
from ..ground.check_arrays import real_array
from .fit import Fit


def place_of(com: ArrayLike) -> Array:
    """A centre of mass (3,) [m]; raises InputError."""
    values = real_array("com", com)
    if values.shape != (3,) or not np.isfinite(values).all():
        raise InputError(f"com has shape {values.shape}; expected 3 finite numbers")
    return values


def centre_of_mass(fit: Fit, reach: float) -> tuple[Array, Array]:
    """Centre of mass (3,) [m], and covariance (4, 4) of mass and centre of mass.

    They are NaN along axes of which the measurement says little.

    Args:
        fit: the fit.
        reach: deviation of the centre of mass before the measurement [m].
    """
    mass = float(fit.values[0])
    com = np.full(3, np.nan)
    covariance = np.full((4, 4), np.nan)
    covariance[0, 0] = fit.covariance[0, 0]
    if mass <= 0.0:
        return com, covariance
    com = fit.values[1:4] / mass
    # of com = first moment / mass, by mass and first moment
    gradient = np.zeros((4, 4))
    gradient[0, 0] = 1.0
    gradient[1:, 0] = -com / mass
    gradient[1:, 1:] = np.eye(3) / mass
    covariance = gradient @ fit.covariance[:4, :4] @ gradient.T
    deviation = np.sqrt(np.diagonal(covariance))
    is_shown = deviation < 0.5 * reach
    is_shown[0] = True
    both_shown = is_shown[:, None] & is_shown
    covariance = np.where(both_shown, covariance, np.nan)
    com = np.where(is_shown[1:], com, np.nan)
    return com, covariance
