"""Sine and cosine together, on lanes: reduction by pi/2 in three parts, then polynomials on [-pi/4, pi/4].

Parts and coefficients are those of FDLIBM (Sun Microsystems, 1993: e_rem_pio2.c, k_sin.c, k_cos.c),
whose error is below one unit in the last place. Angles from `LARGE` on, where the parts are too
short, go to the C library.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

from .text import Function, Lanes

# [rad] multiples of pi/2 up to here have at most 16 bits, so their products with a part are exact
LARGE = 1e5
_ROUND = (
    1.5 * 2.0**52
)  # added and taken away again, it rounds to an integer and leaves it in the lowest bits
_PARTS = (
    0x3FF921FB54400000,
    0x3DD0B4611A600000,
    0x3BA3198A2E037073,
)  # of pi/2: 33 bits, 33 bits, the rest
_SIN = (
    -1.66666666666666324348e-01,
    8.33333333332248946124e-03,
    -1.98412698298579493134e-04,
    2.75573137070700676789e-06,
    -2.50507602534068634195e-08,
    1.58969099521155010221e-10,
)
_COS = (
    4.16666666666666019037e-02,
    -1.38888888888741095749e-03,
    2.48015872894767294178e-05,
    -2.75573143513906633035e-07,
    2.08757232129817482790e-09,
    -1.13596475577881948265e-11,
)


def sincos_functions(width: int) -> list[str]:
    """`@sincos.W`: sine and cosine of an angle [rad] a lane; with the function that it leaves large angles to."""
    lanes = Lanes(Function(""), width)
    pair = f"{{ {lanes.kind}, {lanes.kind} }}"
    large = Function(f"define internal {pair} @sincos.large.{width}({lanes.kind} %x) noinline")
    _return(
        large, pair, [Lanes(large, width).intrinsic(name, "%x") for name in ("sin", "cos")], width
    )

    f = Function(f"define internal {pair} @sincos.{width}({lanes.kind} %x) alwaysinline")
    lanes = Lanes(f, width)
    small = _reduced(lanes, "%x")
    near = lanes.compare("olt", lanes.intrinsic("fabs", "%x"), lanes.constant(LARGE))
    all_near = (
        near
        if width == 1
        else f.let(f"call i1 @llvm.vector.reduce.and.v{width}i1({lanes.mask} {near})")
    )
    usual, far = f.label(), f.label()
    f.branch(all_near, usual, far)
    f.begin(far)
    both = f.let(f"call {pair} @sincos.large.{width}({lanes.kind} %x)")
    parts = [f.let(f"extractvalue {pair} {both}, {k}") for k in (0, 1)]
    # Lane by lane: a large angle changes nothing of the states beside it.
    _return(
        f,
        pair,
        [lanes.choose(near, lanes.kind, *two) for two in zip(small, parts, strict=True)],
        width,
    )
    f.begin(usual)
    _return(f, pair, small, width)
    return [large.text(), f.text()]


def _return(f: Function, pair: str, values: Sequence[str], width: int) -> None:
    kind = Lanes(f, width).kind
    half = f.let(f"insertvalue {pair} poison, {kind} {values[0]}, 0")
    f.do(f"ret {pair} {f.let(f'insertvalue {pair} {half}, {kind} {values[1]}, 1')}")


def _reduced(lanes: Lanes, x: str) -> list[str]:
    f, n = lanes.function, lanes.constant
    shifted = lanes.arithmetic(
        "fadd", lanes.arithmetic("fmul", x, n(0.63661977236758134308)), n(_ROUND)
    )
    turns = lanes.arithmetic("fsub", shifted, n(_ROUND))
    rest = x
    for part in _PARTS:
        value = struct.unpack("<d", struct.pack("<Q", part))[0]
        rest = lanes.arithmetic("fsub", rest, lanes.arithmetic("fmul", turns, n(value)))
    sine, cosine = _polynomials(lanes, rest)
    quarter = f.let(f"bitcast {lanes.kind} {shifted} to {lanes.integer}")
    odd = f.let(f"trunc {lanes.integer} {quarter} to {lanes.mask}")
    after = f.let(f"add {lanes.integer} {quarter}, {lanes.spread('i64', 1)}")
    swapped = [lanes.choose(odd, lanes.kind, *pair) for pair in ((cosine, sine), (sine, cosine))]
    return [
        _signed(lanes, value, turn) for value, turn in zip(swapped, (quarter, after), strict=True)
    ]


def _signed(lanes: Lanes, value: str, quarters: str) -> str:
    """The value, negated where the second bit of the quarter turns is set."""
    f, kind = lanes.function, lanes.integer
    second = f.let(f"and {kind} {quarters}, {lanes.spread('i64', 2)}")
    sign = f.let(f"shl {kind} {second}, {lanes.spread('i64', 62)}")
    bits = f.let(f"xor {kind} {f.let(f'bitcast {lanes.kind} {value} to {kind}')}, {sign}")
    return f.let(f"bitcast {kind} {bits} to {lanes.kind}")


def _polynomials(lanes: Lanes, x: str) -> tuple[str, str]:
    def do(operation: str, a: str, b: str) -> str:
        return lanes.arithmetic(operation, a, b)

    square = do("fmul", x, x)
    tail = _horner(lanes, _SIN, square)
    sine = do("fadd", x, do("fmul", do("fmul", square, x), tail))
    half = do("fmul", square, lanes.constant(0.5))
    near = do("fsub", lanes.constant(1.0), half)
    lost = do("fsub", do("fsub", lanes.constant(1.0), near), half)
    tail = do("fmul", square, do("fmul", square, _horner(lanes, _COS, square)))
    return sine, do("fadd", near, do("fadd", lost, tail))


def _horner(lanes: Lanes, coefficients: Sequence[float], x: str) -> str:
    value = lanes.constant(coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        value = lanes.arithmetic(
            "fadd", lanes.arithmetic("fmul", value, x), lanes.constant(coefficient)
        )
    return value
