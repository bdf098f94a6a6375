"""Derivatives of a traced graph, operation by operation."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core.algebra.numerics import invert, newton
from hybrid_dynamics_core.algebra.scalar import absolute, atan2, cos, sin, sqrt
from hybrid_dynamics_core.kernels.differentiate import (
    evaluate,
    jacobian,
    short_jacobian,
    substitute,
    symmetric_matrix,
)
from hybrid_dynamics_core.kernels.graph import Graph
from hybrid_dynamics_core.kernels.jacobians.elimination import ORDERS, jacobian_by_elimination

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


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("name", FUNCTIONS)
def test_elimination(name: str, order: int) -> None:
    function, expected = FUNCTIONS[name]
    graph = Graph()
    inputs = [graph.input(0, k) for k in range(3)]
    outputs = [function(inputs), inputs[1], 3.0]
    rows = jacobian_by_elimination(graph, outputs, [*inputs, 1.0], order)
    assert values(graph, rows[0][:3], inputs) == pytest.approx(
        np.array(expected), rel=1e-14, abs=1e-15
    )
    assert rows[1] == [0.0, 1.0, 0.0, 0.0]
    assert rows[2] == [0.0] * 4
    assert rows[0][3] == 0.0


def test_elimination_takes_fewer_operations_where_few_values_join_two_parts() -> None:
    graph = Graph()
    inputs = [graph.input(0, k) for k in range(40)]
    joint = inputs[0]
    for x in inputs[1:]:
        joint = sin(joint * x)
    outputs = [cos(joint * (k + 2.0)) for k in range(40)]
    by_node, short = jacobian(outputs, inputs), short_jacobian(outputs, inputs)
    entries = [[e for row in rows for e in row] for rows in (by_node, short)]
    point = np.random.default_rng(3).uniform(0.5, 1.5, 40).tolist()
    expected, found = (values(graph, flat, inputs, point) for flat in entries)
    assert found == pytest.approx(expected, rel=1e-12, abs=1e-15)  # 40 products in another order
    assert len(graph.live(entries[1])) < len(graph.live(entries[0]))


def test_blocks_between_are_refused_by_elimination_and_differentiated_node_by_node() -> None:
    graph = Graph()
    entries = [graph.input(0, k) for k in range(16)]
    outputs = invert(entries, 4)
    with pytest.raises(ValueError, match="a block"):
        jacobian_by_elimination(graph, outputs, entries, 1)
    assert short_jacobian(outputs, entries)[0][0].index == jacobian(outputs, entries)[0][0].index


def test_symmetric_matrix_on_symbols_is_that_on_floats() -> None:
    size = 12
    weights = np.random.default_rng(5).uniform(0.5, 2.0, size).tolist()

    def function(x: list, at: list) -> list:
        """J^T W J x, with J of a chain: each of its rows is the one before and a term more."""
        total, forces = 0.0, []
        for weight, factor, value in zip(weights, at, x, strict=True):
            total = total + factor * value
            forces.append(weight * total)
        result, carried = [], 0.0
        for factor, force in zip(reversed(at), reversed(forces), strict=True):
            carried = carried + force
            result.append(factor * carried)
        return result[::-1]

    graph = Graph()
    u = [graph.input(0, k) for k in range(size)]
    point = np.random.default_rng(6).uniform(0.5, 2.0, size).tolist()
    rows = symmetric_matrix(lambda x: function(x, u), u)
    found = values(graph, [e for row in rows for e in row], u, point)
    expected = symmetric_matrix(lambda x: function(x, point), point)
    assert found == pytest.approx(np.ravel(expected), rel=1e-14)
    assert all(rows[i][j].index == rows[j][i].index for i in range(size) for j in range(i))


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
