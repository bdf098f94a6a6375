"""LLVM IR of the angle of a vector, on lanes.

The smaller of |x| and |y| over the larger is the tangent t of an angle in [0, pi/4]. Where t is
above tan(pi/8), (t - 1) / (t + 1) is the tangent of that angle minus pi/4. The polynomial of what
remains is that of FDLIBM (Sun Microsystems, 1993: s_atan.c, for |t| < 7/16).
"""

from __future__ import annotations

from .sincos import horner
from .text import Function, Lanes

# of z and of z^2: atan t = t - t (z P(z^2) + z^2 Q(z^2)), z = t^2
_FIRST = (
    3.33333333333329318027e-01,
    1.42857142725034663711e-01,
    9.09088713343650656196e-02,
    6.66107313738753120669e-02,
    4.97687799461593236017e-02,
    1.62858201153657823623e-02,
)
_SECOND = (
    -1.99999999998764832476e-01,
    -1.11111104054623557880e-01,
    -7.69187620504482999495e-02,
    -5.83357013379057348645e-02,
    -3.65315727442169155270e-02,
)
_EIGHTH = 0.41421356237309503  # tan(pi/8)
# pi/4, pi/2 and pi, each with the rest that its double lacks
_EIGHTH_TURN = (7.85398163397448278999e-01, 3.06161699786838301793e-17)
_RIGHT = (1.57079632679489655800e00, 6.12323399573676603587e-17)
_STRAIGHT = (3.14159265358979311600e00, 1.22464679914735317720e-16)
_HUGE = 1e300  # a sum with such a number may overflow


def atan2_name(width: int) -> str:
    """Name of the function."""
    return f"@atan2.{width}"


def atan2_function(width: int) -> str:
    """`@atan2.W(y, x)`: the angle of the vector (x, y) in each lane [rad], within two roundings."""
    kind = Lanes(Function(""), width).kind
    head = f"define internal {kind} {atan2_name(width)}({kind} %y, {kind} %x) alwaysinline"
    lanes = Lanes(Function(head), width)
    f, n = lanes.function, lanes.constant
    do = lanes.arithmetic
    across, along = lanes.intrinsic("fabs", "%y"), lanes.intrinsic("fabs", "%x")
    is_steep = lanes.compare("ogt", across, along)
    low = lanes.choose(is_steep, kind, along, across)
    high = lanes.choose(is_steep, kind, across, along)
    is_huge = lanes.compare("ogt", high, n(_HUGE))
    scale = lanes.choose(is_huge, kind, n(0.5), n(1.0))
    low, high = do("fmul", low, scale), do("fmul", high, scale)
    f.products.clear()  # the scaled numbers are exact: nothing to fuse
    is_beyond = lanes.compare("ogt", low, do("fmul", high, n(_EIGHTH)))
    dividend = lanes.choose(is_beyond, kind, do("fsub", low, high), low)
    divisor = lanes.choose(is_beyond, kind, do("fadd", low, high), high)
    is_zero = lanes.compare("oeq", divisor, n(0.0))
    tangent = lanes.choose(is_zero, kind, n(0.0), do("fdiv", dividend, divisor))
    square = do("fmul", tangent, tangent)
    fourth = do("fmul", square, square)
    series = do("fmul", square, horner(lanes, _FIRST, fourth))
    series = do("fadd", do("fmul", fourth, horner(lanes, _SECOND, fourth)), series)
    base, rest = (lanes.choose(is_beyond, kind, n(part), n(0.0)) for part in _EIGHTH_TURN)
    small = do("fsub", do("fmul", tangent, series), rest)
    angle = do("fsub", base, do("fsub", small, tangent))
    angle = lanes.choose(is_steep, kind, _from(lanes, _RIGHT, angle), angle)
    is_behind = f.let(f"icmp slt {lanes.integer} {_bits(lanes, '%x')}, {lanes.splat('i64', 0)}")
    angle = lanes.choose(is_behind, kind, _from(lanes, _STRAIGHT, angle), angle)
    result = lanes.intrinsic("copysign", angle, "%y")
    f.do(f"ret {kind} {result}")
    return f.text()


def _from(lanes: Lanes, part_of_turn: tuple[float, float], angle: str) -> str:
    """An angle taken from pi or a part of it."""
    leading, rest = map(lanes.constant, part_of_turn)
    return lanes.arithmetic("fsub", leading, lanes.arithmetic("fsub", angle, rest))


def _bits(lanes: Lanes, value: str) -> str:
    return lanes.function.let(f"bitcast {lanes.kind} {value} to {lanes.integer}")
