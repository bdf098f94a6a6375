"""The filter's steps as machine code: the formulas of `formula`, written as instructions.

exp and expm1 are those of the C library, which Python calls too: every bit is that of
`PolynomialFilter.step`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Final

import numpy as np

from hybrid_dynamics_core.kernels import extension, llvm, native
from hybrid_dynamics_core.kernels.ir.entry import DECLARATIONS, Entry
from hybrid_dynamics_core.kernels.ir.text import Function
from hybrid_dynamics_core.kernels.run import default_backend

from . import doubles, formula
from .doubles import Double
from .filter import FilterState, FloatArray, PolynomialFilter

_MOMENTS: Final = 5

# Of float64 arrays in C order: intervals (N,) [s], samples (N, n), rate (1,) [1/s], moments (5,)
# and derivatives (D + 1, n) before the first row and, filled in, after the last taken; fitted (N, D
# + 1, n), filled as far as that. Gives how many rows were taken, fewer than N where the moments no
# longer allow the degree; `kernels.status.NOT_TAKEN` where the arrays are others.
Advance = Callable[[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray], int]


def advance_of(degree: int) -> Advance | None:
    """The function for a filter of degree 1 or 2; None where nothing is compiled."""
    return _compiled(degree) if default_backend() == native.NAME else None


@cache
def _compiled(degree: int) -> Advance:
    return extension.function(llvm.Loaded(llvm.compile_text(_text(degree), native.LEVEL)))


@dataclass(frozen=True)
class CompiledFilter(PolynomialFilter):
    """The filter with steps of machine code where it has its full degree; to the same bits."""

    def __post_init__(self) -> None:
        super().__post_init__()
        _ = self._compiled  # now, not while the first sample waits

    @cached_property
    def _compiled(self) -> Advance | None:
        return advance_of(self.degree)

    @cached_property
    def _rates(self) -> FloatArray:
        return np.array([self.rate])

    def _advance(self, state: FilterState, stamp_ns: int, sample: FloatArray) -> FilterState:
        advance = self._compiled
        if advance is None or state.degree != self.degree:
            return super()._advance(state, stamp_ns, sample)
        interval = np.array([(stamp_ns - state.stamp_ns) * 1e-9])
        samples = np.array([sample])
        moments, derivatives = np.array(state.moments), state.derivatives.copy()
        fitted = np.empty((1, *derivatives.shape))
        if advance(interval, samples, self._rates, moments, derivatives, fitted) != 1:
            return super()._advance(state, stamp_ns, sample)
        return FilterState(
            stamp_ns,
            state.start_ns,
            self.degree,
            tuple(moments.tolist()),
            samples[0],
            derivatives,
        )


def _text(degree: int) -> str:
    """A module with the function `call`: an `Advance`."""
    entry = Entry("call", 6, extension.header())
    f = entry.f
    rows, joints = entry.lengths(1, 2)
    shapes: list[list[int | str]] = [
        [rows],
        [rows, joints],
        [1],
        [_MOMENTS],
        [degree + 1, joints],
        [rows, degree + 1, joints],
    ]
    intervals, samples, rate, moments, state, fitted = (
        entry.array(k, shape, writable=k > 2) for k, shape in enumerate(shapes)
    )
    places = f"ptr {intervals}, ptr {samples}, ptr {moments}, ptr {state}, ptr {fitted}"
    done = f.let(f"call i64 @advance(i64 {rows}, i64 {joints}, double {f.load(rate)}, {places})")
    parts = (DECLARATIONS, doubles.DECLARATIONS, _advance_text(degree), entry.finish(done))
    return "".join(parts)


def _advance_text(degree: int) -> str:
    """Row after row: moments and gains, then the polynomial of each joint."""
    heads = "double %rate, ptr %intervals, ptr %samples, ptr %moments, ptr %state, ptr %fitted"
    f = Function(f"define internal i64 @advance(i64 %rows, i64 %joints, {heads})")
    going, done = f.slot("i1"), f.slot("i64")
    f.store("true", going, kind="i1", align=1)
    f.store(0, done, kind="i64")
    with f.loop(0, "%rows", while_=going) as row:
        dt, rate = Double(f, f.load("%intervals", row)), Double(f, "%rate")
        before = [Double(f, f.load("%moments", k)) for k in range(_MOMENTS)]
        step = rate * dt
        decay, weight = formula.weights(step)
        moments = formula.aged(before, step, decay, weight)
        determinant, least, cofactors = formula.fit(moments, degree)
        is_allowed = determinant.exceeds(least)
        f.store(is_allowed, going, kind="i1", align=1)
        with f.when(is_allowed):
            for k, moment in enumerate(moments):
                f.store(moment.name, "%moments", k)
            gains = formula.gains(cofactors, weight / determinant, rate)
            _joints(f, row, dt, gains)
            f.store(f.let(f"add i64 {row}, 1"), done, kind="i64")
    f.do(f"ret i64 {f.load(done, kind='i64')}")
    return f.text()


def _joints(f: Function, row: str, dt: Double, gains: tuple[Double, ...]) -> None:
    """One sample of every joint: the polynomial in %state, and in the row of %fitted."""
    samples = f.at("%samples", f.let(f"mul i64 {row}, %joints"))
    width = f.let(f"mul i64 %joints, {len(gains)}")
    fitted = f.at("%fitted", f.let(f"mul i64 {row}, {width}"))
    with f.loop(0, "%joints") as joint:
        places = [joint]
        for _ in gains[1:]:
            places.append(f.let(f"add i64 {places[-1]}, %joints"))
        derivatives = [Double(f, f.load("%state", place)) for place in places]
        sample = Double(f, f.load(samples, joint))
        corrected = formula.corrected(derivatives, dt, gains, sample)
        for place, value in zip(places, corrected, strict=True):
            f.store(value.name, "%state", place)
            f.store(value.name, fitted, place)
