"""The proof that the loops are closed: everything after closure takes a ClosedState, never a raw vector."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..ground.arrays import Array, Picklable
from ..kernels.run import Codes
from ..programs import OutcomeKind, kinds

_COLUMNS: Final = ("u", "du", "s", "ds", "R", "bias", "residual", "distances", "status")


class ClosureStatus(IntEnum):
    """Outcome of closing one state: closed, out of reach, or too near a singular place."""

    OK = 0
    UNREACHABLE = 1
    SINGULAR = 2


@dataclass(frozen=True, eq=False)
class ClosedState(Picklable):
    """A state with its loops closed; for a batch every array has a leading N.

    Coordinates s = [u; z] in the order of `robot.coordinates`, [rad] or [m], rates per second.

    Attributes:
        u, du: active coordinates and rates (n,).
        s, ds: all coordinates and rates (n_s,).
        R: (n_s, n) with s' = R u', Chu (2020), Eq. 20.
        bias: R' u' (n_s,), the accelerations with u'' = 0.
        residual: largest error of the loop equations, in lengths of the loop (dimensionless) or
        radians.
        branch: assembly mode of each loop by name.
        distances: (loops,) distance of each loop to its nearest singularity, 0 singular, 1 best:
            2 |det J_z| / ||J_z||_F^2 with J_z made dimensionless.
        iterations: of the closure; 0 where every loop has a closed form. (N,) for a batch.
        dds: (n_s,) accelerations of all coordinates where they were given (`close_given`), else
        None.
        status: ClosureStatus (an int array for a batch); only `close(..., check=False)` returns
        others than OK.
    """

    u: Array
    du: Array
    s: Array
    ds: Array
    R: Array
    bias: Array
    residual: float | Array
    branch: Mapping[str, str]
    signs: Array
    loops: tuple[str, ...]
    distances: Array
    status: ClosureStatus | np.ndarray
    iterations: int | np.ndarray = 0
    dds: Array | None = None

    def __post_init__(self) -> None:
        for array in (self.s, self.ds, self.R, self.bias, self.distances):
            array.flags.writeable = False

    def __repr__(self) -> str:
        """Coordinates and rates (of a batch their shapes), and the evidence: the worst of all rows."""
        parts = [f"{name}={_told(getattr(self, name))}" for name in ("u", "du", "z", "dz")]
        residual, nearest = (
            np.max(self.residual, initial=0.0),
            np.min(self.singularity, initial=1.0),
        )
        met = "+".join(ClosureStatus(code).name for code in np.unique(self.status))
        parts += [
            f"residual={residual:.2g}",
            f"singularity={nearest:.3g}",
            f"branch={dict(self.branch)}",
            f"status={met}",
        ]
        return f"ClosedState({', '.join(parts)})"

    @property
    def n(self) -> int:
        """Number of active coordinates."""
        return int(self.u.shape[-1])

    @property
    def z(self) -> Array:
        """Passive coordinates (n_z,)."""
        return self.s[..., self.n :]

    @property
    def dz(self) -> Array:
        """Passive rates (n_z,)."""
        return self.ds[..., self.n :]

    @property
    def singularity(self) -> float | Array:
        """Distance of the nearest loop to its singularity, in [0, 1]; 1 for a robot without loops."""
        if not self.loops:
            return 1.0 if self.u.ndim == 1 else np.ones(len(self.u))
        nearest = self.distances.min(axis=-1)
        return float(nearest) if self.u.ndim == 1 else nearest

    @property
    def singular_loop(self) -> str | list[str]:
        """Name of the loop nearest to its singularity ('' for a robot without loops)."""
        if not self.loops:
            return "" if self.u.ndim == 1 else [""] * len(self.u)
        if self.u.ndim == 1:
            distances = [-1.0 if math.isnan(d) else d for d in self.distances.tolist()]
            return self.loops[distances.index(min(distances))]
        nearest = np.argmin(np.nan_to_num(self.distances, nan=-1.0), axis=-1)
        return [self.loops[int(k)] for k in nearest]

    def rows(self, which: Any) -> ClosedState:
        """Some states of a batch, in the order of `which`, which indexes an axis (N,); one state for an integer.

        Raises InputError for one state, which has no rows.
        """
        if self.u.ndim == 1:
            raise InputError("this is one closed state, not a batch: it has no rows to choose from")
        parts = {name: values[which] for name, values in _columns(self).items()}
        if self.signs.ndim == 1:  # the same for all
            parts["signs"] = self.signs
        if parts["u"].ndim == 2:
            return replace(self, **parts)
        residual, status, iterations = (
            parts.pop(name).item() for name in ("residual", "status", "iterations")
        )
        return replace(
            self, **parts, residual=residual, status=ClosureStatus(status), iterations=iterations
        )

    @staticmethod
    def joined(states: Sequence[ClosedState]) -> ClosedState:
        """One batch of states and batches of one robot, in their order; `branch` is that of the last."""
        columns = [_columns(state) for state in states]
        names = set.intersection(*(set(entry) for entry in columns))
        parts: dict[str, Any] = {"dds": None}
        parts |= {name: np.concatenate([entry[name] for entry in columns]) for name in names}
        signs = states[0].signs
        if signs.ndim == 1 and all(state.signs is signs for state in states):
            parts["signs"] = signs
        return replace(states[-1], **parts)


def _told(values: Array) -> str:
    """Values of one state, the shape of those of many."""
    if values.ndim > 1:
        return str(values.shape)
    return f"[{', '.join(f'{value:.6g}' for value in (values + 0.0).tolist())}]"


def _columns(state: ClosedState) -> dict[str, Any]:
    """What may differ from row to row of a batch, each with a leading N."""
    one = state.u.ndim == 1
    count = 1 if one else len(state.u)
    names = _COLUMNS if state.dds is None else (*_COLUMNS, "dds")
    found = {name: np.asarray(getattr(state, name))[None if one else slice(None)] for name in names}
    found["iterations"] = np.broadcast_to(state.iterations, count)
    found["signs"] = np.broadcast_to(state.signs, (count, state.signs.shape[-1]))
    return found


def closure_statuses(codes: Codes) -> NDArray[np.int64]:
    """The `ClosureStatus` of each status code, as an integer array of the same shape.

    A state that lies on no smooth way, or has no finite result, counts as singular.
    """
    outcome = kinds(codes)
    return np.where(outcome > OutcomeKind.SINGULAR, ClosureStatus.SINGULAR, outcome)


def settle(state: ClosedState, values: Mapping[str, Array], codes: NDArray[np.int64]) -> None:
    """What was computed for a state: NaN in rows that did not close, InputError where one that did has no number."""
    if not codes.any():
        return
    lost = np.flatnonzero((codes != 0) & (np.asarray(state.status) == 0))
    if len(lost):
        row = "" if codes.ndim == 0 else f" of row {lost[0]}"
        raise InputError(f"the result{row} is not finite: the input is too large to compute with")
    for value in values.values():
        value[codes != 0] = np.nan
