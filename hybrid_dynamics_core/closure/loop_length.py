"""Lengths that make loop equations dimensionless; they do not depend on the choice of frames."""

from __future__ import annotations

from collections.abc import Sequence

from ..mechanism.configuration import Configuration
from .constraints.equations import LoopEquations

NO_LENGTH = 1e-9  # share of the longest loop below which an extent is rounding


def measure(loops: Sequence[LoopEquations], configuration: Configuration) -> None:
    """Set the length of each loop to its extent, or to the longest extent if it has none.

    Args:
        loops: the loops of a mechanism.
        configuration: a closed configuration, floats.
    """
    extents = [loop.extent(configuration) for loop in loops]
    longest = max(extents, default=0.0)
    for loop, extent in zip(loops, extents, strict=True):
        if not loop.has_length:
            continue
        if extent > NO_LENGTH * longest:
            loop.length = extent
        else:
            loop.length = longest or 1.0
