"""C functions that generated code calls: they equal `algebra.numerics` on floats."""

from __future__ import annotations

from ...algebra.numerics import LARGEST_STEP, MAX_ITERATIONS, SMALL_STEP, TINY

ELIMINATE = """\
/* Gauss and Jordan with pivoting on the rows [A | B] (n, width): B becomes A^-1 B. Returns det A.
   The values of a singular matrix are not finite. */
static double eliminate(double *a, int n, int width)
{
    double determinant = 1.0;
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
        determinant *= (other == line) ? pivot : -pivot;
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
    return determinant;
}
"""

INVERT = """\
/* The inverse of a (n, n) row by row, then the determinant; NaN and 0 of a singular matrix. */
static void invert(int n, const double *a, double *work, double *out)
{
    for (int r = 0; r < n; ++r) {
        for (int c = 0; c < n; ++c) {
            work[2 * n * r + c] = a[n * r + c];
            work[2 * n * r + n + c] = (r == c) ? 1.0 : 0.0;
        }
    }
    const double determinant = eliminate(work, n, 2 * n);
    const int regular = determinant < 0.0 || determinant > 0.0;
    for (int r = 0; r < n; ++r) {
        for (int c = 0; c < n; ++c) {
            out[n * r + c] = regular ? work[2 * n * r + n + c] : (double)NAN;
        }
    }
    out[n * n] = regular ? determinant : 0.0;
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


NEWTON = newton_text(SMALL_STEP)
