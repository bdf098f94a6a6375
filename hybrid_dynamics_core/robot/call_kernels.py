"""The kernels of one compiled call: from a guess, from a start, and along a motion.

Along a motion each row starts from the one before. To compute rows side by side nevertheless, a
part of the motion is closed from its start at first, each row in one move. The moves from row to
row are then checked as if each row had started from the one before. Where one is not smooth, rows
are closed one after the other.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from .. import programs
from ..ground.arrays import Array
from ..ground.lazy import lazy
from ..kernels.caller import Loaders
from ..kernels.run import Kernel
from ..kernels.status import any_failed
from ..programs import Program
from .closure_runs import Place, QuickClosure
from .kernel_store import KernelStore

PATH_ROWS: Final = 512  # rows of a motion at a time


class CallKernels:
    """Kernels of a program, each loaded when it is first used.

    Args:
        kernels: store of the kernels.
        key: key of the program.
        program: a program with the input `guess`.
    """

    def __init__(self, kernels: KernelStore, key: str, program: Program) -> None:
        self.program = program
        self._kernels = kernels
        self._key = key

    @lazy
    def at_guess(self) -> Kernel:
        """The kernel whose iterations start from a guess."""
        return self._kernels.kernel(self._key, self.program)

    @lazy
    def from_start(self) -> Kernel:
        """The kernel for one move from a nearby closed configuration."""
        return self._kernels.kernel(f"{self._key} from start", self.program.from_start())

    @lazy
    def names_from_start(self) -> tuple[str, ...]:
        """Inputs of `from_start`, in order."""
        return self.program.from_start().inputs

    @lazy
    def along_motion(self) -> Kernel:
        """The kernel of `from_start`, with the next start as a further output."""
        program = programs.warm_started(self.program)
        return self._kernels.kernel(f"{self._key} along motion", program)

    @lazy
    def _from_prediction(self) -> Kernel:
        """The kernel at a guess, checked against a prediction from the state before."""
        program = self.program.from_prediction()
        return self._kernels.kernel(f"{self._key} from prediction", program)

    @lazy
    def _predicted_inputs(self) -> tuple[str, ...]:
        return self.program.from_prediction().inputs

    def run_motion(
        self,
        quick: QuickClosure,
        inputs: Mapping[str, Array],
        outs: Sequence[Array],
        start: Place,
    ) -> Place | None:
        """Compute rows that each start from the one before.

        Args:
            quick: closure of the robot in compiled code.
            inputs: vectors by name, (size,) or (N, size); `branch` is that of the motion.
            outs: (N, *shape) each, filled.
            start: closed configuration before the first row.

        Returns:
            The configuration of the last row, and R there; None if a row needs other code.
        """
        for first in range(0, len(inputs["u"]), PATH_ROWS):
            rows = slice(first, first + PATH_ROWS)
            part = {name: a[rows] if a.ndim > 1 else a for name, a in inputs.items()}
            outs_of_part = [out[rows] for out in outs]
            end = self._side_by_side(quick, part, outs_of_part, start)
            if end is None:
                end = self._one_by_one(quick, part, outs_of_part, start)
            if end is None:
                return None
            start = end
        return start

    def _side_by_side(
        self, quick: QuickClosure, inputs: dict[str, Array], outs: Sequence[Array], start: Place
    ) -> Place | None:
        u, signs = inputs["u"], inputs["branch"]
        closed = quick.from_one_start(u, signs, start)
        if closed is None:
            return None
        s, forecasts = closed
        values = {**inputs, "guess": s[1:], "start": s[:-1], "predicted": forecasts[:-1]}
        arguments = [values[name] for name in self._predicted_inputs]
        codes = np.empty(len(u), dtype=np.int64)
        self._from_prediction.fill_rows(arguments, outs, codes)
        if any_failed(codes):
            return None
        last = quick.path(u[-1:], signs, start)
        if last is None:
            return None
        (place,), last_map = last
        return place.copy(), last_map

    def _one_by_one(
        self, quick: QuickClosure, inputs: dict[str, Array], outs: Sequence[Array], start: Place
    ) -> Place | None:
        places = quick.path(inputs["u"], inputs["branch"], start)
        if places is None:
            return None
        s, last_map = places
        codes = np.empty(len(s), dtype=np.int64)
        values = {**inputs, "guess": s}
        arguments = [values[name] for name in self.program.inputs]
        self.at_guess.fill_rows(arguments, outs, codes)
        if any_failed(codes):
            return None
        return s[-1].copy(), last_map

    def loaders(self) -> Loaders:
        """Functions that load the code of each kernel for one state."""
        return Loaders(
            at_guess=lambda: self.at_guess.one,
            from_start=lambda: self.from_start.one,
            along_motion=lambda: self.along_motion.one,
        )
