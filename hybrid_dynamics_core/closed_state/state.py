"""`ClosedState`: its type proves that the loops are closed.

Everything after closure takes a ClosedState, never a raw vector.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import TYPE_CHECKING, Any, ClassVar, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..ground.arrays import Array, Picklable
from ..kernels.run import Codes
from ..programs import OutcomeKind, kinds
from .passages.record import Passage

_BELOW_ALL: Final = -1.0  # in place of NaN; distances of loops are in [0, 1]
# fields with a row for each state of a batch
_COLUMNS: Final = (
    "u",
    "du",
    "s",
    "ds",
    "R",
    "bias",
    "residual",
    "distances",
    "status",
)


class ClosureStatus(IntEnum):
    """Outcome of closing one state: closed, out of reach, or too near a singular place."""

    OK = 0
    UNREACHABLE = 1
    SINGULAR = 2


class Later(Protocol):
    """Fields of one state that are computed when they are first read.

    Attributes:
        names: their names.
    """

    names: ClassVar[frozenset[str]]

    def compute(self, name: str) -> Any:
        """The value of a field."""


@dataclass(frozen=True, eq=False)
class ClosedState(Picklable):
    """A state with its loops closed; for a batch every array has a leading N.

    Coordinates are s = [u; z] in the order of `robot.coordinates`, in [rad] or [m], rates per
    second.

    Attributes:
        u: active coordinates (n,).
        du: active rates (n,).
        s: all coordinates (n_s,).
        ds: rates of all coordinates (n_s,).
        R: (n_s, n) with s' = R u', Chu (2020), Eq. 25.
        bias: R' u' (n_s,), the accelerations with u'' = 0.
        residual: largest error of the loop equations, in lengths of the loop (dimensionless) or
            radians.
        branch: assembly mode of each loop by name.
        signs: branch sign of each block of the closure plan, +1 or -1; (blocks,) if they are the
            same for all rows, else (N, blocks).
        loops: names of the loops.
        distances: (loops,) distance of each loop to its nearest singularity, 0 singular, 1 best:
            2 abs(det J_z) / norm(J_z)^2 with J_z made dimensionless.
        status: a ClosureStatus, or an int array (N,) for a batch. Only `close(..., check=False)`,
            and motions through change points, return states that are not OK.
        iterations: iterations of the closure, () or (N,); 0 if all loops have closed forms.
        dds: accelerations of all coordinates (n_s,) after `close_given`, otherwise None.
        passive_angles: index in s and value at the reference [rad] of each passive revolute joint,
            by name. `turns` counts from that value.
        passages: change points and toggles on the way, of a motion through them.
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
    passive_angles: Mapping[str, tuple[int, float]] = field(default_factory=dict, repr=False)
    passages: tuple[Passage, ...] = ()

    @classmethod
    def of_fields(cls, fields: dict[str, Any], later: Later | None = None) -> ClosedState:
        """The state of all fields: what the constructor makes of them, in a third of its time.

        Args:
            fields: values by name; the dictionary is changed.
            later: computes fields that are missing, when they are first read. All arrays are
                then read-only already.
        """
        state = cls.__new__(cls)
        fields["_later"] = later
        state.__dict__.update(fields)
        if later is None:
            state.__post_init__()
        return state

    if not TYPE_CHECKING:  # the fields have types

        def __getattr__(self, name: str) -> Any:
            """A field that is missing: it is computed when it is first read."""
            later = self.__dict__.get("_later")
            if later is None or name not in later.names:
                raise AttributeError(f"a ClosedState has no attribute {name!r}")
            value = self.__dict__[name] = later.compute(name)
            return value

    def __getstate__(self) -> dict[str, Any]:
        """All fields, as `Picklable` has them."""
        for name in self.__dataclass_fields__:
            getattr(self, name)
        state = super().__getstate__()
        state.pop("_later", None)
        return state

    def __post_init__(self) -> None:
        for array in (self.s, self.ds, self.R, self.bias, self.distances):
            array.flags.writeable = False

    def __repr__(self) -> str:
        """Coordinates, rates and residual; of a batch their shapes, and the worst residual."""
        parts = [f"{name}={_text(getattr(self, name))}" for name in ("u", "du", "z", "dz")]
        residual = np.max(self.residual, initial=0.0)
        singularity = np.min(self.singularity, initial=1.0)
        statuses = [ClosureStatus(code).name for code in np.unique(self.status)]
        status = "+".join(statuses)
        turns = {name: count for name, count in self.turns.items() if np.any(count)}
        if turns and self.u.ndim == 1:
            parts.append(f"turns={turns}")
        parts += [
            f"residual={residual:.2g}",
            f"singularity={singularity:.3g}",
            f"branch={dict(self.branch)}",
            f"status={status}",
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
    def turns(self) -> Mapping[str, int | NDArray[np.int64]]:
        """Whole turns of each passive revolute joint by name, away from the robot's reference.

        Without `near`, `close` takes the angles nearest to the reference's: all turns are 0.
        Springs, limits and joints that follow count the angle with its turns.

        For a batch each count is an array (N,), with 0 in rows that did not close.
        """
        counts: dict[str, int | NDArray[np.int64]] = {}
        for name, (k, start) in self.passive_angles.items():
            angle = np.nan_to_num(self.s[..., k], nan=start)
            turns = np.rint((angle - start) / math.tau).astype(np.int64)
            counts[name] = int(turns) if self.u.ndim == 1 else turns
        return counts

    @property
    def singularity(self) -> float | Array:
        """Distance of the nearest loop to its singularity, in [0, 1]; 1 without loops."""
        if self.loops:
            nearest: Array = self.distances.min(axis=-1)
        else:
            nearest = np.ones(self.u.shape[:-1])
        if self.u.ndim == 1:
            return float(nearest)
        return nearest

    @property
    def singular_loop(self) -> str | list[str]:
        """Name of the loop nearest to its singularity, '' without loops."""
        if self.u.ndim == 1:
            return self._nearest_loop()
        if not self.loops:
            return [""] * len(self.u)
        # the distance of a loop that does not close is NaN: that loop comes first
        distances = np.nan_to_num(self.distances, nan=_BELOW_ALL)
        nearest = np.argmin(distances, axis=-1)
        return [self.loops[int(k)] for k in nearest]

    def _nearest_loop(self) -> str:
        """The `singular_loop` of one state."""
        nearest, least = "", math.inf
        # plain floats: quicker than NumPy for so small an array
        for loop, distance in zip(self.loops, self.distances.tolist(), strict=True):
            # the distance of a loop that does not close is NaN
            if math.isnan(distance):
                return loop
            if distance < least:
                nearest, least = loop, distance
        return nearest

    def rows(self, which: Any) -> ClosedState:
        """Some states of a batch.

        Args:
            which: index into an axis (N,): an integer, a slice, indices or a mask.

        Returns:
            A batch in the order of `which`; one state for an integer.

        Raises:
            InputError: this is one state, not a batch.
        """
        if self.u.ndim == 1:
            raise InputError("this is one closed state, not a batch: it has no rows to choose from")
        columns = _columns(self)
        parts: dict[str, Any] = {name: values[which] for name, values in columns.items()}
        parts["passages"] = ()  # of the whole motion
        if self.signs.ndim == 1:  # the same for all
            parts["signs"] = self.signs
        if parts["u"].ndim == 1:
            parts["residual"] = parts["residual"].item()
            parts["iterations"] = parts["iterations"].item()
            parts["status"] = ClosureStatus(parts["status"].item())
        return replace(self, **parts)

    @staticmethod
    def joined(states: Sequence[ClosedState]) -> ClosedState:
        """One batch of states and batches of one robot, in their order.

        Its `branch` is that of the last state. It has `dds` if all states have.
        """
        columns = [_columns(state) for state in states]
        parts: dict[str, Any] = {"dds": None, "passages": ()}
        for name in columns[0]:
            if all(name in entry for entry in columns):
                parts[name] = np.concatenate([entry[name] for entry in columns])
        signs = states[0].signs
        if signs.ndim == 1 and all(state.signs is signs for state in states):
            parts["signs"] = signs
        return replace(states[-1], **parts)


def _text(values: Array) -> str:
    """The values of one state as text, or the shape of a batch."""
    if values.ndim > 1:
        return str(values.shape)
    # without negative zeros
    numbers = ", ".join(f"{value:.6g}" for value in (values + 0.0).tolist())
    return f"[{numbers}]"


def _columns(state: ClosedState) -> dict[str, Any]:
    """The fields of a batch that differ from row to row, each with a leading N."""
    rows = np.atleast_2d(state.u).shape[0]
    columns: dict[str, Any] = {}
    for name in _COLUMNS:
        values = np.asarray(getattr(state, name))
        if state.u.ndim == 1:
            values = values[None]
        columns[name] = values
    if state.dds is not None:
        columns["dds"] = np.atleast_2d(state.dds)
    columns["iterations"] = np.broadcast_to(state.iterations, rows)
    blocks = state.signs.shape[-1]
    columns["signs"] = np.broadcast_to(state.signs, (rows, blocks))
    return columns


def closure_statuses(codes: Codes) -> NDArray[np.int64]:
    """The `ClosureStatus` of each status code, as an integer array of the same shape.

    A state behind a jump, or without a finite result, counts as singular.
    """
    outcome = kinds(codes)
    # up to SINGULAR both enumerations have the same numbers
    return np.where(outcome > OutcomeKind.SINGULAR, ClosureStatus.SINGULAR, outcome)


def mark_open_rows(
    state: ClosedState,
    values: Mapping[str, Array],
    codes: Codes,
) -> None:
    """Set results to NaN in the rows of a state that did not close.

    Args:
        state: closed state or batch.
        values: results by name; changed in place.
        codes: status codes of the computation, () or (N,).

    Raises:
        InputError: a row that did close has no finite result.
    """
    if not codes.any():
        return
    closed = np.asarray(state.status) == ClosureStatus.OK
    overflowed = np.flatnonzero(closed & (codes != 0))
    if len(overflowed):
        row = ""
        if codes.ndim == 1:
            row = f" of row {overflowed[0]}"
        raise InputError(f"the result{row} is not finite: the input is too large to compute with")
    for value in values.values():
        value[codes != 0] = np.nan
