"""Derivatives of a traced graph, operation by operation."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core.algebra.numerics import invert, newton
from hybrid_dynamics_core.algebra.scalar import absolute, atan2, cos, sin, sqrt
from hybrid_dynamics_core.kernels.differentiate import evaluate, jacobian, substitute
from hybrid_dynamics_core.kernels.graph import Graph

POINT = [0.7, -1.3, 2.1]
FUNCTIONS = {
    "sum": (lambda v: 2.0 * v[0] - v[1] + 3.0 - v[2], [2, -1, -1]),
    "product": (lambda v: v[0] * v[1] * v[2], [-1.3 * 2.1, 0.7 * 2.1, 0.7 * -1.3]),
    "quotient": (lambda v: (v[0] + v[1]) / v[2], [1 / 2.1, 1 / 2.1, 0.6 / 2.1**2]),
    "constant over": (lambda v: 5.0 / v[0], [-5 / 0.49, 0, 0]),
    "sine": (lambda v: sin(v[0] * v[1]), [-1.3 * np.cos(-0.91), 0.7 * np.cos(-0.91), 0]),
    "cosine": (lambda v: cos(v[2]), [0, 0, -np.sin(2.1)]),
    "root": (lambda v: sqrt(v[2] * v[2]), [0, 0, 1]),
    "absolute": (lambda v: absolute(v[1]) + absolute(v[0]), [1, -1, 0]),
    "angle": (lambda v: atan2(v[1], v[0]), [1.3 / (0.49 + 1.69), 0.7 / (0.49 + 1.69), 0]),
    "angle of a constant": (lambda v: atan2(2.0, v[2]), [0, 0, -2 / (4 + 2.1**2)]),
    "negative": (lambda v: -(v[0] - v[1]) * -v[2], [2.1, -2.1, 2.0]),
}


def values(graph: Graph, outputs: list, inputs: list, point: list[float] = POINT) -> np.ndarray:
    return np.array(
        evaluate(graph, outputs, {x.index: v for x, v in zip(inputs, point, strict=True)})
    )


@pytest.mark.parametrize("name", FUNCTIONS)
def test_operations(name: str) -> None:
    function, expected = FUNCTIONS[name]
    graph = Graph()
    inputs = [graph.input(0, k) for k in range(3)]
    (row,) = jacobian([function(inputs)], inputs)
    assert values(graph, row, inputs) == pytest.approx(np.array(expected), rel=1e-14, abs=1e-15)


def test_what_does_not_change_has_no_nodes() -> None:
    graph = Graph()
    x, y = graph.input(0, 0), graph.input(0, 1)
    ((by_x, by_y),) = jacobian([x * 3.0], [x, y])
    assert (by_x, by_y) == (3.0, 0.0)


def test_inverse() -> None:
    graph = Graph()
    entries = [graph.input(0, k) for k in range(16)]
    matrix = np.random.default_rng(0).normal(size=(4, 4)) + 3.0 * np.eye(4)
    rows = jacobian(invert(entries, 4), entries)
    found = values(
        graph, [e for row in rows for e in row], entries, matrix.ravel().tolist()
    ).reshape(16, 16)
    inverse = np.linalg.inv(matrix)
    expected = -np.einsum("ik,lj->ijkl", inverse, inverse).reshape(16, 16)
    assert found == pytest.approx(expected, rel=1e-12)


def test_iteration_is_differentiated_as_the_equations_it_solves() -> None:
    """x^2 = p, x y = q: x = sqrt(p), y = q / sqrt(p).

    Through a function of the parameters and the solution.
    """

    def body(x: list, p: list) -> list:
        return [x[0] * x[0] - p[0], x[0] * x[1] - p[1], 2.0 * x[0], 0.0, x[1], x[0]]

    graph = Graph()
    a, b = graph.input(0, 0), graph.input(0, 1)
    x, y, converged = newton(body, [1.0, 1.0], [a * a + b, sin(b)])
    outputs = [x, y, converged, x * y]
    rows = jacobian(outputs, [a, b])
    found = values(graph, [e for row in rows for e in row], [a, b], [1.5, 0.4]).reshape(4, 2)
    p = 1.5**2 + 0.4
    root, dp = np.sqrt(p), np.array([3.0, 1.0])
    assert found[0] == pytest.approx(dp / (2 * root), rel=1e-12)
    assert found[1] == pytest.approx(
        [0, np.cos(0.4) / root] - np.sin(0.4) * dp / (2 * p * root), rel=1e-12
    )
    assert found[2] == pytest.approx([0, 0])
    assert found[3] == pytest.approx([0, np.cos(0.4)], abs=1e-14)


def test_substitution_keeps_what_does_not_depend() -> None:
    graph = Graph()
    x, y = graph.input(0, 0), graph.input(0, 1)
    fixed = sin(y)
    nodes = len(graph.nodes)
    first, second = substitute([x * fixed, fixed], {x: cos(y)})
    assert second.index == fixed.index
    assert values(graph, [first], [y], [0.3]) == pytest.approx([np.sin(0.3) * np.cos(0.3)])
    assert len(graph.nodes) == nodes + 3  # the product there was, the cosine, the new product
