"""Independent coordinates given by name, with rates and accelerations, for closure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..closed_state.state import ClosedState
from ..errors import InputError, StateError
from ..ground.arrays import Array
from ..ground.check_arrays import mapping_of, vectors_by_name


@dataclass(frozen=True, eq=False)
class GivenMotion:
    """Given coordinates with rates and accelerations.

    Attributes:
        names: the n given coordinates.
        values: (n,) or (N, n) [rad, m].
        rates: rates of the same shape [rad/s, m/s].
        accelerations: accelerations of the same shape [rad/s^2, m/s^2].
    """

    names: tuple[str, ...]
    values: Array
    rates: Array
    accelerations: Array

    @classmethod
    def by_name(
        cls,
        values: Mapping[str, ArrayLike],
        rates: Mapping[str, ArrayLike] | None,
        accelerations: Mapping[str, ArrayLike] | None,
        coordinates: tuple[str, ...],
    ) -> GivenMotion:
        """Check and combine the arguments of a call.

        Args:
            values: given coordinates by name, each a number or (N,).
            rates: their rates; zero where left out.
            accelerations: their accelerations; zero where left out.
            coordinates: all coordinates of the robot, for messages.

        Raises:
            InputError: a name, shape or length is wrong, or a value is not finite.
        """
        names = tuple(mapping_of("values", values))
        parts: dict[str, Array] = {}
        labelled = {"values": values, "rates": rates, "accelerations": accelerations}
        for label, given in labelled.items():
            parts[label] = vectors_by_name(label, given, names, coordinates)
        shape = _common_shape(parts)
        for label, part in parts.items():
            parts[label] = np.broadcast_to(part, shape)
        return cls(names, **parts)

    @property
    def rows(self) -> int:
        """Length of the batch; -1 for one state."""
        return len(self.values) if self.values.ndim == 2 else -1

    def row(self, k: int) -> GivenMotion:
        """One state of a batch."""
        return GivenMotion(self.names, self.values[k], self.rates[k], self.accelerations[k])


def close_rows(
    close: Callable[[GivenMotion, ClosedState | None], ClosedState],
    motion: GivenMotion,
    near: ClosedState | None,
) -> ClosedState:
    """Close each row of a batch independently.

    Args:
        close: closes one state from another one, or from the reference if None.
        motion: the batch.
        near: states from which the motion is followed, one or one for each row.

    Raises:
        InputError: the batch is empty, or a result is not finite.
        StateError: a row does not close; `index` is that of the first one.
    """
    if not motion.rows:
        raise InputError("values: the batch is empty; expected one row or more")
    states: list[ClosedState] = []
    for k in range(motion.rows):
        start = near
        if near is not None and near.u.ndim == 2:
            start = near.rows(k)
        try:
            states.append(close(motion.row(k), start))
        except StateError as error:
            error.place_in_row(k)
            raise
    return ClosedState.joined(states)


def _common_shape(parts: Mapping[str, Array]) -> tuple[int, ...]:
    """The common shape of values, rates and accelerations after broadcasting."""
    batches = {label: part.shape for label, part in parts.items() if part.ndim == 2}
    if len(set(batches.values())) > 1:
        lengths = ", ".join(f"{label} {shape[0]}" for label, shape in batches.items())
        raise InputError(f"lengths differ ({lengths}); expected one for all")
    return next(iter(batches.values()), parts["values"].shape)
