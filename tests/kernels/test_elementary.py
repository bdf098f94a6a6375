"""Operations one by one, on one state and on many: sine, roots, angles, inverses, Newton."""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import numpy as np
import pytest

from hybrid_dynamics_core.algebra.numerics import invert, newton
from hybrid_dynamics_core.algebra.scalar import absolute, atan2, cos, sin, sqrt
from hybrid_dynamics_core.kernels.run import Kernel
from hybrid_dynamics_core.kernels.trace import Results
from tests.kernels.programs_of import BACKENDS
from tests.sampling import swept

ULP = 2.3e-16


def run_both(kernel: Kernel, *arguments: np.ndarray) -> dict[str, np.ndarray]:
    """Results for rows; each row alone gives the same."""
    many, codes = kernel(*arguments)
    for k in range(len(arguments[0])):
        one, code = kernel(*(a[k] for a in arguments))
        assert code == codes[k]
        for name, value in one.items():
            if kernel.backend == "native":
                assert np.array_equal(value, many[name][k], equal_nan=True)
            else:
                assert np.allclose(value, many[name][k], rtol=4 * ULP, atol=4 * ULP, equal_nan=True)
    return many


@pytest.mark.parametrize("backend", BACKENDS)
def test_sine_and_cosine_to_the_last_digits(backend: str) -> None:
    rng = np.random.default_rng(0)
    near = (
        np.arange(-40, 41)[:, None] * (math.pi / 4) + np.array([-1e-9, -1e-17, 0.0, 1e-12, 1e-5])
    ).ravel()
    far = [
        *(s * 10.0 ** rng.uniform(-300, 9, 300) for s in (-1, 1)),
        rng.uniform(-1e5, 1e5, 800),
        [1e5, 99999.9, 1e22],
    ]
    x = np.concatenate([near, rng.uniform(-4, 4, 800), *far])
    kernel = Kernel(lambda a: Results({"s": sin(a[0]), "c": cos(a[0])}, []), [1], backend)
    found = run_both(kernel, x[:, None])
    for name, exact in (("s", np.sin(x)), ("c", np.cos(x))):
        error = np.abs(found[name] - exact)
        assert (error <= 1.01 * ULP * np.maximum(np.abs(exact), 1e-300)).all(), x[
            np.argmax(error / np.abs(exact))
        ]


@pytest.mark.parametrize("backend", BACKENDS)
def test_what_is_not_finite_has_a_status(backend: str) -> None:
    kernel = Kernel(
        lambda a: Results({"s": sin(a[0]), "r": 1.0 / a[1], "q": sqrt(a[2])}, []), [3], backend
    )
    good = [0.5, 2.0, 4.0]
    rows = np.array(
        [good, [np.nan, 2, 4], [np.inf, 2, 4], [0.5, 0, 4], [0.5, 2, -4], [0.5, 2, np.inf], good]
    )
    found = run_both(kernel, rows)
    _, codes = kernel(rows)
    assert codes.tolist() == [0, -2, -2, -2, -2, -2, 0]
    assert found["r"][0] == 0.5
    assert found["q"][6] == 2.0


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("count", [1, 7, 8, 19])
def test_only_the_row_that_is_not_finite_has_a_status(backend: str, count: int) -> None:
    """In full vectors of rows and in the last one; a shared input belongs to all rows."""
    kernel = Kernel(lambda a, b: Results({"y": a[0] * b[1]}, []), [2, 3], backend)
    rows, shared = np.ones((count, 2)), np.array([1.0, 2.0, 3.0])
    _, codes = kernel(rows, shared)
    assert not codes.any()
    for row in {0, count // 2, count - 1}:
        for component in range(2):
            wrong = rows.copy()
            wrong[row, component] = np.inf
            found, codes = kernel(wrong, shared)
            assert np.flatnonzero(codes).tolist() == [row]
            assert (np.delete(found["y"], row) == 2.0).all()
    shared[2] = np.nan
    _, codes = kernel(rows, shared)
    assert (codes == -2).all()


@pytest.mark.parametrize("backend", BACKENDS)
def test_the_other_functions(backend: str) -> None:
    def run(a: Any) -> Results:
        x, y = a
        parts = [
            atan2(x, y),
            atan2(x, 2.0),
            atan2(-3.0, y),
            absolute(x),
            x / y,
            2.0 / y,
            -x - y,
            x - (-y),
        ]
        return Results({"v": parts, "same": [x, 0.0, -1.5, x]}, [])

    rng = np.random.default_rng(2)
    rows = rng.uniform(-2, 2, (50, 2))
    found = run_both(Kernel(run, [2], backend), rows)
    x, y = rows.T
    exact = [
        np.arctan2(x, y),
        np.arctan2(x, 2.0),
        np.arctan2(-3.0, y),
        np.abs(x),
        x / y,
        2.0 / y,
        -x - y,
        x + y,
    ]
    assert found["v"] == pytest.approx(np.stack(exact, axis=1), rel=4 * ULP)
    assert np.array_equal(found["same"], np.stack([x, 0 * x, 0 * x - 1.5, x], axis=1))


@pytest.mark.parametrize("backend", BACKENDS)
def test_the_angle_of_any_vector(backend: str) -> None:
    """Vectors of all sizes, along the axes and diagonals, zero, the smallest and the largest."""
    kernel = Kernel(lambda a: Results({"angle": [atan2(a[0], a[1])]}, []), [2], backend)
    rng = np.random.default_rng(4)
    sizes = 10.0 ** rng.integers(-300, 300, (200, 2))
    axes = np.array(list(product([0.0, -0.0, 1.0, -1.0], repeat=2)))
    ends = np.array([[1.2e308, -1.7e308], [-1.7e308, 1.2e308], [5e-324, 5e-324], [5e-324, -1.0]])
    turned = rng.normal(size=(500, 2))
    rows = np.concatenate([turned, sizes * rng.normal(size=(200, 2)), axes, ends])
    found = run_both(kernel, rows)["angle"][:, 0]
    exact = np.arctan2(rows[:, 0], rows[:, 1])
    assert found == pytest.approx(exact, rel=2 * ULP, abs=1e-323)
    assert np.array_equal(np.signbit(found), np.signbit(exact))


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("size", swept([4, 5, 7, 9], [4, 7]))
def test_inverse_needs_pivots(backend: str, size: int) -> None:
    kernel = Kernel(
        lambda a: Results({"inverse": invert(list(a), size)}, []), [size * size], backend
    )
    rng = np.random.default_rng(size)
    matrices = rng.uniform(-1, 1, (20, size, size))
    matrices[0] = np.eye(size)[::-1]  # nothing on the diagonal
    matrices[1, 0, 0] = 0.0
    matrices[2] *= 1e-8
    found = run_both(kernel, matrices.reshape(20, -1))["inverse"]
    for matrix, entries in zip(matrices, found, strict=True):
        inverse, condition = np.linalg.inv(matrix), np.linalg.cond(matrix)
        assert (
            np.abs(entries.reshape(size, size) - inverse).max()
            < 20 * ULP * condition * np.abs(inverse).max()
        )


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_singular_matrix_has_no_inverse(backend: str) -> None:
    kernel = Kernel(lambda a: Results({"inverse": invert(list(a), 4)}, []), [16], backend)
    singular = np.array([[1.0, 2, 0, 0], [2, 4, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]).ravel()
    for matrix in (singular, np.zeros(16)):
        found, status = kernel(matrix)
        assert np.isnan(found["inverse"]).all()
        assert status == -2


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("scale", [1e-90, 1e90])
def test_determinants_may_be_beyond_floats(backend: str, scale: float) -> None:
    kernel = Kernel(lambda a: Results({"inverse": invert(list(a), 9)}, []), [81], backend)
    rng = np.random.default_rng(0)
    matrices = rng.uniform(-1.0, 1.0, (3, 9, 9))
    found = run_both(kernel, scale * matrices.reshape(3, -1))["inverse"]
    inverse = np.linalg.inv(matrices)
    assert found.reshape(3, 9, 9) * scale == pytest.approx(inverse, rel=1e-10)


def circle_and_line(x: Any, p: Any) -> list[Any]:
    """x0^2 + x1^2 = p0, x0 = p1 x1; residuals, then the Jacobian."""
    return [
        x[0] * x[0] + x[1] * x[1] - p[0],
        x[0] - p[1] * x[1],
        2.0 * x[0],
        2.0 * x[1],
        1.0,
        -p[1],
    ]


@pytest.mark.parametrize("backend", BACKENDS)
def test_newton_converges_or_says_that_it_did_not(backend: str) -> None:
    kernel = Kernel(
        lambda g, p: Results({"x": newton(circle_and_line, list(g), list(p))}, []), [2, 2], backend
    )
    guess = np.array([[1.0, 1.0], [3.0, 0.5], [1.0, 1.0], [0.0, 0.0], [1e3, 1e3]])
    known = np.array([[2.0, 0.5], [1.0, 2.0], [-1.0, 0.5], [1.0, 0.5], [1.0, 1.0]])
    for k, (x, p) in enumerate(zip(guess, known, strict=True)):
        found, _ = kernel(x, p)
        *solution, count = found["x"]
        many, _ = kernel(guess, known)
        assert np.array_equal(np.sign(many["x"][:, -1]), [1, 1, -1, -1, -1])
        if k < 2:
            assert 1 < count < 20
            assert np.abs(circle_and_line(solution, p)[:2]).max() < 1e-15
            assert many["x"][k, :2] == pytest.approx(solution, rel=1e-15)
        else:  # no root; a singular start; too far for the steps that are allowed
            assert count < 0


def root_of_two(x: Any, _: Any) -> list[Any]:
    """x^2 - 2 and its derivative, without a parameter."""
    return [x[0] * x[0] - 2.0, 2.0 * x[0]]


@pytest.mark.parametrize("backend", BACKENDS)
def test_newton_needs_no_parameters(backend: str) -> None:
    kernel = Kernel(lambda g: Results({"x": newton(root_of_two, list(g), [])}, []), [1], backend)
    guesses = np.array([[1.0], [3.0], [-1.0]])
    results = run_both(kernel, guesses)
    assert results["x"][:, 0] == pytest.approx(np.sqrt(2.0) * np.array([1.0, 1.0, -1.0]))


@pytest.mark.parametrize("backend", BACKENDS)
def test_blocks_inside_what_newton_iterates(backend: str) -> None:
    """The body may itself invert a matrix: residuals A(x)^-1 b - c for a matrix of size 4."""

    def body(x: Any, p: Any) -> list[Any]:
        entries = [
            4.0 + x[0] if i == j else p[0] / (1.0 + i + j) for i in range(4) for j in range(4)
        ]
        inverse = invert(entries, 4)
        row = sum(inverse[k] * (k + 1.0) for k in range(4))
        squared = [sum(inverse[k] * inverse[4 * k + j] for k in range(4)) for j in range(4)]
        return [row - 0.1, -sum(squared[j] * (j + 1.0) for j in range(4))]

    kernel = Kernel(
        lambda g, p: Results({"x": newton(body, list(g), list(p))}, []), [1, 1], backend
    )
    found = run_both(kernel, np.array([[1.0], [0.5], [0.0]]), np.array([[0.5], [0.4], [0.3]]))
    for (x, count), p in zip(found["x"], (0.5, 0.4, 0.3), strict=True):
        assert count > 0
        assert abs(body([x], [p])[0]) < 1e-14
