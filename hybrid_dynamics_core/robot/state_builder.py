"""Building of closed states from results of the closure kernel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np

from ..closed_state.assembly_modes import branch_names
from ..closed_state.closure_solver import RunClose, Values
from ..closed_state.diagnosis import raise_for_status
from ..closed_state.passages.path import ThroughPath
from ..closed_state.state import ClosedState, ClosureStatus, closure_statuses
from ..ground.arrays import Array, frozen
from ..kernels.run import Codes
from ..kernels.status import GOOD, any_failed
from .model import RobotModel


class StateBuilder:
    """Builder of the closed states of one robot."""

    def __init__(self, model: RobotModel) -> None:
        self._model = model
        self._n = len(model.active)
        self._iterated = [block.name for block in model.plan.blocks if block.iterates]
        self._branches: dict[bytes, Mapping[str, str]] = {}
        self._passive_angles: dict[str, tuple[int, float]] = {}
        for k in range(len(model.active), len(model.coordinates)):
            if model.tree.is_revolute(k):
                name = model.coordinates[k]
                self._passive_angles[name] = (k, float(model.reference_s[k]))
        self._constants = {
            "loops": model.loops,
            "dds": None,
            "passive_angles": self._passive_angles,
        }

    def build(
        self,
        u: Array,
        du: Array,
        signs: Array,
        values: Values,
        codes: Codes,
        check: bool = True,
    ) -> ClosedState:
        """Build a state from results of the closure kernel.

        Args:
            u: active coordinates (n,) or (N, n) [rad, m].
            du: active rates of the same shape [rad/s, m/s].
            signs: branch signs (blocks,), or (N, blocks).
            values: results of the kernel by name; their arrays become part of the state.
            codes: status codes () or (N,).
            check: whether a state that does not close is an error. If False, its row is NaN.

        Raises:
            ClosureError: a loop cannot close.
            SingularityError: a loop is singular, or the motion leaves its assembly mode.
            InputError: the result is not finite.
        """
        status: ClosureStatus | np.ndarray
        iterations: int | np.ndarray
        residual: float | Array
        if u.ndim == 1 and codes == GOOD:
            return self.build_one(signs, values)
        self._mark_failures(u, signs, values, codes, check)
        status = closure_statuses(codes)
        iterations = np.nan_to_num(values["iterations"][..., 0]).astype(int)
        # the maximum over the first axis is faster, since rows are short
        columns = np.abs(values["residuals"].T, order="C")
        residual = columns.max(axis=0, initial=0.0)
        if u.ndim == 1:
            status = ClosureStatus(int(status))
            iterations = int(iterations)
            residual = float(residual)
        fields: dict[str, Any] = {
            "u": frozen(u),
            "du": frozen(du),
            "s": values["s"],
            "ds": values["ds"],
            "R": values["R"],
            "bias": values["bias"],
            "residual": residual,
            "branch": self.branch_of(signs),
            "signs": signs,
            "distances": self.loop_distances(values["distances"]),
            "status": status,
            "iterations": iterations,
            **self._constants,
        }
        return ClosedState.of_fields(fields)

    def build_one(self, signs: Array, values: Values) -> ClosedState:
        """Build one closed state.

        Args:
            signs: branch signs (blocks,).
            values: results of the kernel by name; their arrays become part of the state.
        """
        s, ds = values["s"], values["ds"]
        for array in (s, ds, values["R"], values["bias"]):
            array.flags.writeable = False
        n = self._n
        fields: dict[str, Any] = {
            "u": s[:n],
            "du": ds[:n],
            "s": s,
            "ds": ds,
            "R": values["R"],
            "bias": values["bias"],
            "signs": signs,
            "status": ClosureStatus.OK,
            "iterations": int(values["iterations"][0]),
            **self._constants,
        }
        return ClosedState.of_fields(fields, _Evidence(self, signs, values))

    def build_through(self, u: Array, du: Array, path: ThroughPath, run: RunClose) -> ClosedState:
        """Build the states of a motion through singular places.

        Rows at such a place have the status `SINGULAR`. Their R and rates are those on the branch
        at a change point, and NaN at a toggle. Their bias is NaN.

        Args:
            u: active coordinates (N, n) [rad, m].
            du: active rates (N, n) [rad/s, m/s].
            path: the motion.
            run: the closure kernel.

        Raises:
            ClosureError: a row cannot be reached.
            SingularityError: a row cannot be reached without a jump.
        """
        signs = path.signs
        if (signs == signs[0]).all():
            signs = signs[0]
        values, codes = run(u, du, signs, path.s)
        codes = codes.copy()
        codes[path.reached :] = path.code
        for row, velocity_map in path.at_places.items():
            codes[row] = GOOD
            values["s"][row] = path.s[row]
            values["R"][row] = velocity_map
            values["ds"][row] = velocity_map @ du[row]
            values["bias"][row] = np.nan
            values["residuals"][row] = 0.0  # as exactly as the place was located
            values["distances"][row] = 0.0
            values["iterations"][row] = 0.0
        state = self.build(u, du, signs, values, codes)
        status = np.zeros(len(u), dtype=np.int64)
        status[list(path.at_places)] = ClosureStatus.SINGULAR
        return replace(state, status=status, passages=path.passages)

    def on_modes_of(self, near: ClosedState, state: ClosedState) -> ClosedState:
        """A state with the mode names of the state `near` that it was followed from.

        This concerns loops without a closed form.
        """
        branch = dict(state.branch)
        for name in self._iterated:
            if name in near.branch:
                branch[name] = near.branch[name]
        if branch == state.branch:
            return state
        return replace(state, branch=MappingProxyType(branch))

    def _mark_failures(
        self,
        u: Array,
        signs: Array,
        values: Values,
        codes: Codes,
        check: bool,
    ) -> None:
        """Raise if a row does not close; without `check` set it to NaN."""
        if not any_failed(codes):
            return
        if check:
            model = self._model.program_model
            raise_for_status(model, u, signs, codes, values["distances"])
        for value in values.values():
            value[codes != GOOD] = np.nan

    def loop_distances(self, distances: Array) -> Array:
        """Distance of each loop to a singularity, from those of the blocks; read-only."""
        nearest = self._model.loop_distances(distances)
        nearest.flags.writeable = False
        return nearest

    def branch_of(self, signs: Array) -> Mapping[str, str]:
        """Names of the modes of the last row; cached, since motions stay on their modes."""
        if signs.ndim == 2:
            signs = signs[-1]
        key = signs.tobytes()
        branch = self._branches.get(key)
        if branch is None:
            branch = branch_names(self._model.plan, self._modes_of(signs))
            self._branches[key] = branch
        return branch

    def _modes_of(self, signs: Array) -> list[str]:
        """The mode of each block."""
        modes = []
        of_blocks, _ = self._model.plan.split(signs.tolist())
        for block, sign in zip(self._model.plan.blocks, of_blocks, strict=True):
            mode = 0 if sign > 0 else 1
            modes.append(block.modes[mode])
        return modes


class _Evidence:
    """Fields of one closed state that few callers read."""

    __slots__ = ("_builder", "_signs", "_values")
    names: ClassVar[frozenset[str]] = frozenset({"residual", "branch", "distances"})

    def __init__(self, builder: StateBuilder, signs: Array, values: Values) -> None:
        self._builder = builder
        self._signs = signs
        self._values = values

    def compute(self, name: str) -> Any:
        if name == "branch":
            return self._builder.branch_of(self._signs)
        if name == "distances":
            return self._builder.loop_distances(self._values["distances"])
        sizes = map(abs, self._values["residuals"].tolist())
        return max(sizes, default=0.0)
