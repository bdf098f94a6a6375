"""LLVM IR of functions for sine and cosine together, on lanes.

The nearest multiple of pi/2 is subtracted from an angle. To keep all digits, pi/2 is split into
three parts. Polynomials give sine and cosine of the remainder, which is in [-pi/4, pi/4]. Parts and
coefficients are those of FDLIBM (Sun Microsystems, 1993: e_rem_pio2.c, k_sin.c, k_cos.c), whose
error is below one unit in the last place. For angles from `LARGE` on, three parts are too few, and
the C library is called.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

from .text import Function, Lanes

# [rad] below this, multiples of pi/2 have at most 16 bits, so products with a part are exact
LARGE = 1e5
# a sum with this number is rounded to an integer, which is in its lowest bits
_ROUND = 1.5 * 2.0**52
# parts of pi/2: 33 bits, 33 bits, the remainder
_PARTS = (
    0x3FF921FB54400000,
    0x3DD0B4611A600000,
    0x3BA3198A2E037073,
)
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
    """The functions for a number of lanes.

    The last one, `@sincos.W`, gives sine and cosine of an angle [rad] in each lane. For large
    angles it calls `@sincos.large.W`.

    Args:
        width: W, the number of lanes.
    """
    lanes = Lanes(Function(""), width)
    pair = f"{{ {lanes.kind}, {lanes.kind} }}"
    large = Function(f"define internal {pair} @sincos.large.{width}({lanes.kind} %x) noinline")
    lanes = Lanes(large, width)
    sine, cosine = lanes.intrinsic("sin", "%x"), lanes.intrinsic("cos", "%x")
    _return(lanes, pair, sine, cosine)

    f = Function(f"define internal {pair} @sincos.{width}({lanes.kind} %x) alwaysinline")
    lanes = Lanes(f, width)
    sine, cosine = _reduced(lanes, "%x")
    is_near = lanes.compare("olt", lanes.intrinsic("fabs", "%x"), lanes.constant(LARGE))
    all_near = is_near
    if width > 1:
        all_near = f.let(f"call i1 @llvm.vector.reduce.and.v{width}i1({lanes.mask} {is_near})")
    usual, far = f.label(), f.label()
    f.branch(all_near, usual, far)
    f.begin(far)
    both = f.let(f"call {pair} @sincos.large.{width}({lanes.kind} %x)")
    far_sine = f.let(f"extractvalue {pair} {both}, 0")
    far_cosine = f.let(f"extractvalue {pair} {both}, 1")
    # Lane by lane, so that a large angle does not change the other states.
    far_sine = lanes.choose(is_near, lanes.kind, sine, far_sine)
    far_cosine = lanes.choose(is_near, lanes.kind, cosine, far_cosine)
    _return(lanes, pair, far_sine, far_cosine)
    f.begin(usual)
    _return(lanes, pair, sine, cosine)
    return [large.text(), f.text()]


def _return(lanes: Lanes, pair: str, sine: str, cosine: str) -> None:
    """Return a pair of values; `pair` is their type."""
    f, kind = lanes.function, lanes.kind
    half = f.let(f"insertvalue {pair} poison, {kind} {sine}, 0")
    both = f.let(f"insertvalue {pair} {half}, {kind} {cosine}, 1")
    f.do(f"ret {pair} {both}")


def _reduced(lanes: Lanes, x: str) -> tuple[str, str]:
    """Sine and cosine of an angle below LARGE."""
    f, n = lanes.function, lanes.constant
    turns = lanes.arithmetic("fmul", x, n(0.63661977236758134308))  # [quarter turns]
    shifted = lanes.arithmetic("fadd", turns, n(_ROUND))
    turns = lanes.arithmetic("fsub", shifted, n(_ROUND))
    remainder = x
    for part in _PARTS:
        value = struct.unpack("<d", struct.pack("<Q", part))[0]
        product = lanes.arithmetic("fmul", turns, n(value))
        remainder = lanes.arithmetic("fsub", remainder, product)
    sine, cosine = _polynomials(lanes, remainder)
    quarter = f.let(f"bitcast {lanes.kind} {shifted} to {lanes.integer}")
    # for an odd number of quarter turns, the sine is +-cosine of the remainder
    is_swapped = f.let(f"trunc {lanes.integer} {quarter} to {lanes.mask}")
    next_quarter = f.let(f"add {lanes.integer} {quarter}, {lanes.splat('i64', 1)}")
    first = lanes.choose(is_swapped, lanes.kind, cosine, sine)
    second = lanes.choose(is_swapped, lanes.kind, sine, cosine)
    return _signed(lanes, first, quarter), _signed(lanes, second, next_quarter)


def _signed(lanes: Lanes, value: str, quarters: str) -> str:
    """The value, negated for two or three quarter turns, that is if their second bit is set."""
    f, kind = lanes.function, lanes.integer
    second = f.let(f"and {kind} {quarters}, {lanes.splat('i64', 2)}")
    sign = f.let(f"shl {kind} {second}, {lanes.splat('i64', 62)}")
    bits = f.let(f"bitcast {lanes.kind} {value} to {kind}")
    bits = f.let(f"xor {kind} {bits}, {sign}")
    return f.let(f"bitcast {kind} {bits} to {lanes.kind}")


def _polynomials(lanes: Lanes, x: str) -> tuple[str, str]:
    """Sine and cosine of x in [-pi/4, pi/4], as in FDLIBM.

    sin x = x + x^3 P(x^2) and cos x = 1 - x^2/2 + x^4 Q(x^2). The rounding error of 1 - x^2/2 is
    added to the last term.
    """

    def do(operation: str, a: str, b: str) -> str:
        return lanes.arithmetic(operation, a, b)

    square = do("fmul", x, x)
    tail = horner(lanes, _SIN, square)
    sine = do("fadd", x, do("fmul", do("fmul", square, x), tail))
    half = do("fmul", square, lanes.constant(0.5))
    leading = do("fsub", lanes.constant(1.0), half)
    rounding = do("fsub", do("fsub", lanes.constant(1.0), leading), half)
    tail = do("fmul", square, do("fmul", square, horner(lanes, _COS, square)))
    return sine, do("fadd", leading, do("fadd", rounding, tail))


def horner(lanes: Lanes, coefficients: Sequence[float], x: str) -> str:
    """A polynomial of x by Horner's rule; the constant coefficient comes first."""
    value = lanes.constant(coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        product = lanes.arithmetic("fmul", value, x)
        value = lanes.arithmetic("fadd", product, lanes.constant(coefficient))
    return value
