"""Traces rewritten with fewer operations: equal results but for rounding."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.chain import chain
from hybrid_dynamics_core.algebra.scalar import Scalar, Scalars, cos, sqrt
from hybrid_dynamics_core.kernels.graph import Operand, Symbol
from hybrid_dynamics_core.kernels.rewrite import rewritten, scheduled
from hybrid_dynamics_core.kernels.trace import Check, Results, Trace, trace
from hybrid_dynamics_core.programs import (
    forward_dynamics,
    inverse_dynamics,
    inverse_dynamics_derivatives,
)
from hybrid_dynamics_core.programs.model import Inputs, Model, Program
from tests.robots import ROBOTS, robot
from tests.sampling import swept

SIZE = 5
ARITHMETIC = ("add", "sub", "mul", "neg", "div")
OPERATIONS: dict[str, Callable[[float, float], float]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "neg": lambda a, _: -a,
    "sin": lambda a, _: math.sin(a),
    "cos": lambda a, _: math.cos(a),
    "sqrt": lambda a, _: math.sqrt(a) if a >= 0.0 else math.nan,
    "abs": lambda a, _: abs(a),
    "rint": lambda a, _: float(np.rint(a)),
    "atan2": math.atan2,
}


def values_of(traced: Trace, *vectors: Sequence[float]) -> list[float]:
    """Outputs and checks of a trace without blocks."""
    values: dict[int, float] = {}

    def value(x: Operand | int) -> float:
        if isinstance(x, Symbol):
            return values[x.index]
        return values[x] if isinstance(x, int) else x

    for index in traced.live:
        op, a, b = traced.graph.nodes[index]
        if op == "input":
            values[index] = vectors[int(a)][int(b)]
        else:
            values[index] = OPERATIONS[op](value(a), value(b))
    return [value(x) for x in [*traced.outputs, *(check.value for check in traced.checks)]]


def count(traced: Trace, *kinds: str) -> int:
    return sum(kinds.count(traced.graph.nodes[index][0]) for index in traced.live)


def random_program(seed: int) -> Callable[[Scalars], Results]:
    """Sums of products of a few inputs and constants, used again in other ones."""

    def run(x: Scalars) -> Results:
        chance = random.Random(seed)  # noqa: S311  reproducible
        values: list[Scalar] = [*x, 0.5 + cos(x[0]), sqrt(1.0 + x[1] * x[1])]
        for _ in range(chance.randrange(5, 60)):
            a, b = chance.choice(values), chance.choice(values)
            k = chance.choice((2.0, -1.0, 0.3, 1.0))
            values.append(
                chance.choice((a + b, a - b, a * b, a * k, k - a, -a, 1.0 / (3.0 + b * b)))
            )
        outputs = {"y": values[-8:], "kept": values[-4:]}
        return Results(outputs, [Check(values[-1] - values[0], 0.1, 3)], ("y",))

    return run


@given(st.integers(0, 10**6))
def test_random_programs(seed: int) -> None:
    traced = trace(random_program(seed), [SIZE])
    shorter = rewritten(traced)
    point = np.random.default_rng(seed).uniform(-0.2, 0.2, SIZE).tolist()
    expected = values_of(traced, point)
    size = max(1.0, *map(abs, expected))
    np.testing.assert_allclose(values_of(shorter, point), expected, rtol=0.0, atol=1e-11 * size)
    assert [(c.threshold, c.code) for c in shorter.checks] == [(0.1, 3)]
    assert values_of(shorter, point)[8:12] == expected[8:12], "the other outputs stay as they are"


@given(st.integers(0, 10**6))
def test_another_order_changes_nothing(seed: int) -> None:
    traced = trace(random_program(seed), [SIZE])
    ordered = scheduled(traced)
    point = np.random.default_rng(seed).uniform(-0.2, 0.2, SIZE).tolist()
    assert values_of(ordered, point) == values_of(traced, point)
    assert len(ordered.live) == len(traced.live)


def test_fewer_values_wait_in_another_order() -> None:
    """Each root is used late as it is written; one can be used as soon as it is there."""

    def run(x: Scalars) -> Results:
        roots = [sqrt(x[0] + float(k)) for k in range(50)]
        total: Scalar = 0.0
        for root in roots:
            total = total + root
        return Results({"y": total}, [])

    written = trace(run, [1])
    assert most_waiting(written) == 50
    assert most_waiting(scheduled(written)) <= 3


def most_waiting(traced: Trace) -> int:
    """The largest number of results that wait for a use."""
    graph = traced.graph
    last: dict[int, int] = {}
    for index in traced.live:
        for operand in graph.operands(index):
            last[operand] = index
    waiting, most = 0, 0
    for index in traced.live:
        used = {x for x in graph.operands(index) if graph.nodes[x][0] != "input"}
        waiting -= sum(last[operand] == index for operand in used)
        waiting += index in last and graph.nodes[index][0] != "input"
        most = max(most, waiting)
    return most


def test_what_terms_have_in_common_is_computed_once() -> None:
    """c y + s z in three sums, with other factors."""

    def run(x: Scalars) -> Results:
        c, s, y, z, w = x
        products = [k * c * y * w + k * s * z * w for k in (2.0, 3.0)]
        return Results({"y": [*products, 7.0 * c * y + 7.0 * s * z - w]}, [], ("y",))

    written = trace(run, [SIZE])
    shorter = rewritten(written)
    assert (count(written, "mul"), count(written, "add", "sub")) == (16, 4)
    assert count(shorter, "mul") <= 7
    assert count(shorter, "add", "sub") == 2


def test_terms_that_cancel_leave_nothing() -> None:
    def run(x: Scalars) -> Results:
        return Results({"y": [((x[0] + 0.7) + x[1]) - 0.7 - x[1]]}, [], ("y",))

    assert count(rewritten(trace(run, [SIZE])), *ARITHMETIC) == 0


def program_trace(program: Program, model: Model) -> Trace:
    """The trace of a program as it is written."""

    def run(*vectors: Scalars) -> Results:
        return program.run(model, Inputs(**dict(zip(program.inputs, vectors, strict=True))))

    return trace(run, [program.size(model, name) for name in program.inputs])


@pytest.mark.parametrize("name", swept(ROBOTS))
def test_no_program_of_a_robot_has_more_operations(name: str) -> None:
    model = robot(name)._model.program_model
    for program in (inverse_dynamics(), forward_dynamics()):
        traced = program_trace(program, model)
        shorter = rewritten(traced)
        assert count(shorter, *ARITHMETIC) <= count(traced, *ARITHMETIC)
        assert count(shorter, "div") <= count(traced, "div")


def test_operations_of_long_chains() -> None:
    """M-bar and derivatives of chains cost little more for one link more.

    With M-bar column by column and tangents of every node, they would be 6700 and 12 times tau.
    """
    eight, twelve = (chain(stages)._model.program_model for stages in (8, 12))
    forward = program_trace(forward_dynamics(), eight)
    assert count(forward, *ARITHMETIC) < 6200
    inverse, derivatives = (
        count(program_trace(program, twelve), *ARITHMETIC)
        for program in (inverse_dynamics(), inverse_dynamics_derivatives())
    )
    assert derivatives < 8 * inverse
