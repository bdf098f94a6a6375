"""All rotations that meet three distances, by elimination.

The modes of a spherical platform counted otherwise.
"""

from __future__ import annotations

import numpy as np


def rotations_at_distances(
    feet: np.ndarray, tips: np.ndarray, lengths: np.ndarray
) -> list[np.ndarray]:
    """Every R with |R tips[i] - feet[i]| = lengths[i] for three pairs of points (about the centre
    of rotation).

    feet . R tips = c is a quadric in the quaternion (1, x, y, z), with z hidden in the
    coefficients. Three conics in (x, y, 1) and the three derivatives of their Jacobian determinant
    are six combinations of the six monomials of degree two; their determinant, of degree eight in
    z, vanishes where the conics meet (Salmon, Higher Algebra).
    """
    squares = (feet**2).sum(axis=1) + (tips**2).sum(axis=1) - lengths**2
    quadrics = [_quadric(a, b, 0.5 * c) for a, b, c in zip(feet, tips, squares, strict=True)]
    circle = np.exp(2j * np.pi * np.arange(16) / 16.0)
    values = np.array([np.linalg.det(_six(quadrics, z)) for z in circle])
    coefficients = np.fft.fft(values)[:9] / 16.0
    found = []
    for z in np.roots(coefficients.real[::-1]):
        if abs(z.imag) > 1e-6 * max(1.0, abs(z)):
            continue
        null = np.linalg.svd(_six(quadrics, float(z.real)))[2][-1]
        square, cross_x, cross_y = null[2], null[4], null[5]  # of w w, x w, y w
        quaternion = _polished(
            quadrics, np.array([1.0, cross_x / square, cross_y / square, z.real]).real
        )
        if quaternion is not None:
            found.append(rotation(quaternion))
    return found


def rotation(q: np.ndarray) -> np.ndarray:
    """The rotation of a quaternion (w, x, y, z) of any length."""
    w, x, y, z = q
    r = np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )
    return r / (q @ q)


def _quadric(a: np.ndarray, b: np.ndarray, c: float) -> np.ndarray:
    """Symmetric (4, 4) A with q^T A q = |q|^2 (a . R b - c)."""
    basis = np.eye(4)

    def form(q: np.ndarray) -> float:
        return float((q @ q) * (a @ rotation(q) @ b - c))

    matrix = np.diag([form(e) for e in basis])
    for i in range(4):
        for j in range(i):
            matrix[i, j] = matrix[j, i] = 0.5 * (
                form(basis[i] + basis[j]) - matrix[i, i] - matrix[j, j]
            )
    return matrix


def _six(quadrics: list[np.ndarray], z: complex) -> np.ndarray:
    """Rows: coefficients of x x, y y, w w, x y, x w, y w in the three conics and the derivatives of
    their Jacobian.
    """
    conics = []
    for m in quadrics:  # order of the quaternion: 1 (w), x, y, z
        ww = m[0, 0] + 2 * m[0, 3] * z + m[3, 3] * z * z
        xw, yw = m[0, 1] + m[1, 3] * z, m[0, 2] + m[2, 3] * z
        conics.append(np.array([[m[1, 1], m[1, 2], xw], [m[1, 2], m[2, 2], yw], [xw, yw, ww]]))
    rows = [_monomials(c) for c in conics]
    cubic = np.zeros(
        (3, 3, 3), dtype=complex
    )  # J(v) = det of the gradients 2 C_k v, trilinear in v
    for i, j, k in np.ndindex(3, 3, 3):
        cubic[i, j, k] = 8.0 * np.linalg.det(
            np.array([conics[0][:, i], conics[1][:, j], conics[2][:, k]])
        )
    symmetric = sum(
        np.transpose(cubic, p)
        for p in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0))
    )
    rows += [
        _monomials(0.5 * symmetric[k]) for k in range(3)
    ]  # dJ/dv_k = 3 sym_k(v, v), sym = symmetric / 6
    return np.array(rows)


def _monomials(c: np.ndarray) -> np.ndarray:
    return np.array([c[0, 0], c[1, 1], c[2, 2], 2 * c[0, 1], 2 * c[0, 2], 2 * c[1, 2]])


def _polished(quadrics: list[np.ndarray], q: np.ndarray) -> np.ndarray | None:
    """Newton on (x, y, z), to rounding; None where the root was none."""
    for _ in range(10):
        value = np.array([q @ m @ q for m in quadrics])
        slope = np.array([2.0 * (m @ q)[1:] for m in quadrics])
        q[1:] -= np.linalg.lstsq(slope, value, rcond=None)[0]
    size = max(1.0, float(q @ q))
    return q if max(abs(q @ m @ q) for m in quadrics) < 1e-10 * size else None
