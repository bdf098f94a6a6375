"""C functions that generated code calls: they equal `algebra.numerics` on floats."""

from __future__ import annotations

from ...algebra.numerics import LARGEST_STEP, MAX_ITERATIONS, SMALL_STEP, TINY

ANGLE = """\
/* atan2(y, x) to the last bits, by the rational function of Cephes: inlined, unlike that of the C
   library. */
static double angle(double y, double x)
{
    const double ax = fabs(x);
    const double ay = fabs(y);
    const double low = (ax < ay) ? ax : ay;
    const double high = (ax < ay) ? ay : ax;
    const int near_diagonal = low > 0.66 * high;
    const double divided = near_diagonal ? low - high : low;
    const double divisor = near_diagonal ? low + high : high;
    const double t = divided / ((high > 0.0) ? divisor : 1.0 + high);
    const double z = t * t;
    const double p = (((-0.8750608600031904 * z - 16.157537187333652) * z - 75.00855792314705) * z
        - 122.88666844901361) * z - 64.85021904942025;
    const double q = ((((z + 24.858464901423062) * z + 165.02700983169885) * z
        + 432.88106049129027) * z + 485.3903996359137) * z + 194.55065714826139;
    double a = t + t * (z * p / q);
    a = near_diagonal ? (a + 3.061616997868383e-17) + 0.7853981633974483 : a;
    a = (ax < ay) ? 1.5707963267948966 - (a - 6.123233995736766e-17) : a;
    a = (x < 0.0) ? 3.141592653589793 - (a - 1.2246467991473532e-16) : a;
    return copysign(a, y);
}
"""

NEAREST = """\
/* rint(x), for numbers of turns: inlined where sums have no further digits. */
static double nearest(double x)
{
#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD == 0
    const double large = 1.5 / DBL_EPSILON;
    return (x + large) - large;
#else
    return rint(x);
#endif
}
"""

ELIMINATE = """\
/* Gauss and Jordan with pivoting on the rows [A | B] (n, width): B becomes A^-1 B. Returns the
   size of the least pivot: 0 of a singular matrix, whose values are not finite. */
static double eliminate(double *a, int n, int width)
{
    double least = (double)INFINITY;
    for (int c = 0; c < n; ++c) {
        double *line = a + c * width;
        double *other = line;
        double largest = -1.0;
        for (int r = c; r < n; ++r) {
            const double size = fabs(a[r * width + c]);
            if (size > largest) {
                largest = size;
                other = a + r * width;
            }
        }
        const double pivot = other[c];
        const double inverse = 1.0 / pivot;
        least = (fabs(pivot) < least) ? fabs(pivot) : least;
        for (int k = 0; k < width; ++k) {
            const double x = line[k];
            const double y = other[k];
            other[k] = x;
            line[k] = y * inverse;
        }
        for (int r = 0; r < n; ++r) {
            double *target = a + r * width;
            if (r != c) {
                const double factor = target[c];
                for (int k = c; k < width; ++k) {
                    target[k] -= factor * line[k];
                }
            }
        }
    }
    return least;
}
"""

INVERT = """\
/* The inverse of a (n, n) row by row; NaN of a singular matrix. */
static void invert(int n, const double *a, double *work, double *out)
{
    for (int r = 0; r < n; ++r) {
        for (int c = 0; c < n; ++c) {
            work[2 * n * r + c] = a[n * r + c];
            work[2 * n * r + n + c] = (r == c) ? 1.0 : 0.0;
        }
    }
    const int regular = eliminate(work, n, 2 * n) > 0.0;
    for (int r = 0; r < n; ++r) {
        for (int c = 0; c < n; ++c) {
            out[n * r + c] = regular ? work[2 * n * r + n + c] : (double)NAN;
        }
    }
}
"""

_NEWTON = f"""\
typedef void equations(const double *x, const double *p, double *values);

/* Newton's iteration from the guess x (n,) to the solution in its place. x[n] becomes the number
   of iterations, at most {MAX_ITERATIONS}; negative where they fail. */
static void newton(
    equations *body, int n, const double *p, double *values, double *work, double *x)
{{
    for (int count = 1; count <= {MAX_ITERATIONS}; ++count) {{
        double longest = 0.0;
        x[n] = -(double)count;
        body(x, p, values);
        for (int r = 0; r < n; ++r) {{
            for (int c = 0; c < n; ++c) {{
                work[(n + 1) * r + c] = values[n + n * r + c];
            }}
            work[(n + 1) * r + n] = values[r];
        }}
        (void)eliminate(work, n, n + 1);
        for (int r = 0; r < n; ++r) {{
            const double size = fabs(work[(n + 1) * r + n]);
            if (!(size < (double)INFINITY)) {{
                return;
            }}
            if (size > longest) {{
                longest = size;
            }}
        }}
        const double share = {LARGEST_STEP!r} / (longest > {TINY!r} ? longest : {TINY!r});
        for (int r = 0; r < n; ++r) {{
            x[r] -= (share < 1.0 ? share : 1.0) * work[(n + 1) * r + n];
        }}
        if (longest < SMALL_STEP) {{
            x[n] = (double)count;
            return;
        }}
    }}
}}
"""


def newton_text(small_step: float) -> str:
    """Newton's iteration, which ends after a step below a length [rad or m]."""
    return _NEWTON.replace("SMALL_STEP", repr(small_step))


SMALL = {"angle(": ANGLE, "nearest(": NEAREST}  # by their calls
NEWTON = newton_text(SMALL_STEP)
