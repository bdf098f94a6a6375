"""Arrays and data that do not change."""

from __future__ import annotations

from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def frozen(values: ArrayLike) -> Array:
    """A read-only float64 copy."""
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


class Picklable:
    """Data with read-only mappings, which pickle and copy alone do not know; arrays stay read-only too."""

    def __getstate__(self) -> dict[str, Any]:
        """Plain mappings in place of read-only ones."""
        return {k: dict(v) if isinstance(v, MappingProxyType) else v for k, v in vars(self).items()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """And back."""
        for name, value in state.items():
            restored = MappingProxyType(value) if isinstance(value, dict) else value
            if isinstance(restored, np.ndarray):
                restored.flags.writeable = False
            object.__setattr__(self, name, restored)
