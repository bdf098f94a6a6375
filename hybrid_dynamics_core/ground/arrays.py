"""Read-only arrays and immutable data."""

from __future__ import annotations

from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def frozen(values: ArrayLike) -> Array:
    """A read-only float64 copy; numbers that stand for arguments of programs stay what they are."""
    array = np.array(values)
    if array.dtype != np.float64 and not _has_symbols(array):
        array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def _has_symbols(array: NDArray[Any]) -> bool:
    if array.dtype != object:
        return False
    return any(hasattr(entry, "symbol") for entry in array.flat)


class Picklable:
    """Base of immutable data with read-only mappings and arrays.

    Without it, pickle and copy refuse the mappings and give writeable arrays.
    """

    def __getstate__(self) -> dict[str, Any]:
        """The fields, with plain mappings in place of read-only ones."""
        state = dict(vars(self))
        for name, value in state.items():
            if isinstance(value, MappingProxyType):
                state[name] = dict(value)
        return state

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore the fields, read-only again."""
        for name, value in state.items():
            restored = value
            if isinstance(value, dict):
                restored = MappingProxyType(value)
            elif isinstance(value, np.ndarray):
                # compiled code identifies a dtype by its object, and pickle makes a new one
                restored = value.astype(value.dtype.type)
                restored.flags.writeable = False
            object.__setattr__(self, name, restored)
