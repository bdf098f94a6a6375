"""The filter's steps as machine code: what `filters` does in Python, operation by operation, so to the same bits.

Nothing is fused and nothing reordered; exp and expm1 are those of the C library, which Python calls
too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from hybrid_dynamics_core.kernels import extension, llvm, native
from hybrid_dynamics_core.kernels.ir.entry import DECLARATIONS, Entry
from hybrid_dynamics_core.kernels.ir.text import Function, constant
from hybrid_dynamics_core.kernels.run import default_backend

from .filter import (
    LEAST_CONDITION,
    LEAST_DECAY,
    MOST_WEIGHT,
    FilterState,
    FloatArray,
    PolynomialFilter,
)

MOMENTS = 5
_DECLARED = """declare double @exp(double)
declare double @expm1(double)
declare double @llvm.maxnum.f64(double, double)
declare double @llvm.minnum.f64(double, double)
"""
_BINOMIAL = ((), (1.0,), (1.0, 2.0), (1.0, 3.0, 3.0), (1.0, 4.0, 6.0, 4.0))

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

    def _advance(self, state: FilterState, stamp_ns: int, sample: FloatArray) -> FilterState:
        advance = self._compiled
        if advance is None or state.degree != self.degree:
            return super()._advance(state, stamp_ns, sample)
        interval, own = np.array([(stamp_ns - state.stamp_ns) * 1e-9]), np.array([sample])
        moments, derivatives = np.array(state.moments), state.derivatives.copy()
        if (
            advance(
                interval, own, self._rates, moments, derivatives, np.empty((1, *derivatives.shape))
            )
            != 1
        ):
            return super()._advance(state, stamp_ns, sample)
        return FilterState(
            stamp_ns, state.start_ns, self.degree, tuple(moments.tolist()), own[0], derivatives
        )

    @cached_property
    def _rates(self) -> FloatArray:
        return np.array([self.rate])


class _Formula:
    """Double arithmetic written as LLVM IR, rounded after every operation as Python's is."""

    def __init__(self, f: Function) -> None:
        self._f = f

    def add(self, a: str, b: str) -> str:
        return self._f.let(f"fadd double {a}, {b}")

    def sub(self, a: str, b: str) -> str:
        return self._f.let(f"fsub double {a}, {b}")

    def mul(self, *factors: str) -> str:
        product = factors[0]
        for factor in factors[1:]:
            product = self._f.let(f"fmul double {product}, {factor}")
        return product

    def div(self, a: str, b: str) -> str:
        return self._f.let(f"fdiv double {a}, {b}")

    def greater(self, a: str, b: str) -> str:
        return self._f.let(f"fcmp ogt double {a}, {b}")


def _text(degree: int) -> str:
    entry = Entry("call", 6, extension.header())
    f = entry.f
    rows, joints = entry.lengths(1, 2)
    shapes: list[list[int | str]] = [
        [rows], [rows, joints], [1], [MOMENTS], [degree + 1, joints], [rows, degree + 1, joints]
    ]  # fmt: skip
    intervals, samples, rate, moments, state, fitted = (
        entry.array(k, shape, writable=k > 2) for k, shape in enumerate(shapes)
    )
    places = f"ptr {intervals}, ptr {samples}, ptr {moments}, ptr {state}, ptr {fitted}"
    done = f.let(f"call i64 @advance(i64 {rows}, i64 {joints}, double {f.load(rate)}, {places})")
    return DECLARATIONS + _DECLARED + _advance_text(degree) + entry.finish(done)


def _advance_text(degree: int) -> str:
    heads = "double %rate, ptr %intervals, ptr %samples, ptr %moments, ptr %state, ptr %fitted"
    f = Function(f"define internal i64 @advance(i64 %rows, i64 %joints, {heads})")
    going, done = f.slot("i1"), f.slot("i64")
    f.store("true", going, kind="i1", align=1)
    f.store(0, done, kind="i64")
    with f.loop(0, "%rows", while_=going) as row:
        dt = f.load("%intervals", row)
        moments, good, gains = _gains(f, dt, degree)
        f.store(good, going, kind="i1", align=1)
        with f.when(good):
            for k, value in enumerate(moments):
                f.store(value, "%moments", k)
            _step(f, row, dt, gains, degree)
            f.store(f.let(f"add i64 {row}, 1"), done, kind="i64")
    f.do(f"ret i64 {f.load(done, kind='i64')}")
    return f.text()


def _gains(f: Function, dt: str, degree: int) -> tuple[list[str], str, list[str]]:
    """Moments after an interval, whether they allow the degree, and the gains: `filters._aged` and `_gains`."""
    d = _Formula(f)
    step = d.mul("%rate", dt)
    decay, weight = _shares(f, step)
    old = [f.load("%moments", k) for k in range(MOMENTS)]
    moments = [d.add(d.mul(decay, old[0]), weight)]
    for k in range(1, MOMENTS):
        inner = old[0]  # Horner in the step: the binomial shift of ages
        for j in range(1, k):
            inner = d.add(d.mul(constant(_BINOMIAL[k][j]), old[j]), d.mul(step, inner))
        moments.append(d.mul(decay, d.add(old[k], d.mul(step, inner))))
    m0, m1, m2, m3, m4 = moments
    if degree == 1:
        det = d.sub(d.mul(m0, m2), d.mul(m1, m1))
        good = d.greater(det, d.mul(constant(LEAST_CONDITION), m0, m2))
        scale = d.div(weight, det)
        return moments, good, [d.mul(scale, m2), d.mul("%rate", scale, m1)]
    c0 = d.sub(d.mul(m2, m4), d.mul(m3, m3))
    c1 = d.sub(d.mul(m2, m3), d.mul(m1, m4))
    c2 = d.sub(d.mul(m1, m3), d.mul(m2, m2))
    det = d.add(d.add(d.mul(m0, c0), d.mul(m1, c1)), d.mul(m2, c2))
    good = d.greater(det, d.mul(constant(LEAST_CONDITION), m0, m2, m4))
    scale = d.div(weight, det)
    back = f.let("fneg double %rate")
    return moments, good, [
        d.mul(scale, c0),
        d.mul(back, scale, c1),
        d.mul(constant(2.0), "%rate", "%rate", scale, c2),
    ]  # fmt: skip


def _shares(f: Function, step: str) -> tuple[str, str]:
    """What older samples keep, and the weight of the new one: `filters._shares`."""
    back = f.let(f"fneg double {step}")
    kept = f.let(f"call double @exp(double {back})")
    lost = f.let(f"fneg double {f.let(f'call double @expm1(double {back})')}")
    decay = f.let(f"call double @llvm.maxnum.f64(double {kept}, double {constant(LEAST_DECAY)})")
    return decay, f.let(
        f"call double @llvm.minnum.f64(double {lost}, double {constant(MOST_WEIGHT)})"
    )


def _step(f: Function, row: str, dt: str, gains: list[str], degree: int) -> None:
    """One sample of every joint: the polynomial moved to the new stamp, and corrected by the gains."""
    d = _Formula(f)
    half = d.mul(constant(0.5), dt, dt)
    samples = f.at("%samples", f.let(f"mul i64 {row}, %joints"))
    width = f.let(f"mul i64 %joints, {degree + 1}")
    fitted = f.at("%fitted", f.let(f"mul i64 {row}, {width}"))
    with f.loop(0, "%joints") as joint:
        places = [joint]
        for _ in range(degree):
            places.append(f.let(f"add i64 {places[-1]}, %joints"))
        values = [f.load("%state", place) for place in places]
        moved = list(values)
        moved[0] = d.add(values[0], d.mul(dt, values[1]))
        if degree == 2:
            moved[0] = d.add(moved[0], d.mul(half, values[2]))
            moved[1] = d.add(values[1], d.mul(dt, values[2]))
        error = d.sub(f.load(samples, joint), moved[0])
        for place, value, gain in zip(places, moved, gains, strict=True):
            new = d.add(value, d.mul(gain, error))
            f.store(new, "%state", place)
            f.store(new, fitted, place)
