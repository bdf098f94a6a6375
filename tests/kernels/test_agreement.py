"""Compiled, generated for floats, generated for NumPy, and the plain program: the same numbers."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from tests.kernels.programs_of import BACKENDS, PROGRAMS, inputs, kernel, plain, split, worst
from tests.robots import ROBOTS, random_states
from tests.sampling import SAMPLE, sweep_unless, swept

# rounding of order 1e-16 times the cancellation in sums of large terms, and 1 / distance to a
# singularity, squared
EXACT = 1e-12


def is_sample(name: str, which: str) -> bool:
    """Whether `make test` has a program: all of one robot, some of those of other closures."""
    return name == "forging_chu2020" or (name in SAMPLE and which in ("closed", "forward"))


@pytest.mark.parametrize(
    ("name", "which"),
    [
        pytest.param(name, which, marks=sweep_unless(is_sample(name, which)))
        for name, which in product(ROBOTS, PROGRAMS)
    ],
)
def test_every_form_gives_the_plain_numbers(name: str, which: str) -> None:
    states = random_states(name, count=5)
    every = [inputs(name, which, state, k) for k, state in enumerate(states)]
    layout = kernel(name, which, BACKENDS[0]).layout
    expected = [plain(name, which, arguments) for arguments in every]
    wanted = [split(values, layout) for values, _ in expected]
    assert [status for _, status in expected] == [0] * len(states)
    for backend in BACKENDS:
        made = kernel(name, which, backend)
        rows, codes = made(*(np.stack(column) for column in zip(*every, strict=True)))
        assert not codes.any()
        for k, (arguments, values) in enumerate(zip(every, wanted, strict=True)):
            found, status = made(*arguments)
            row = {key: part[k] for key, part in rows.items()}
            assert status == 0
            assert worst(found, values) < EXACT
            assert worst(row, values) < EXACT
            if backend == "native":  # alone or among others: the same bits
                assert all(np.array_equal(row[key], found[key]) for key in found)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("count", [1, 7, 8, 63, 64, 65, 200])
def test_a_row_does_not_depend_on_where_it_stands(backend: str, count: int) -> None:
    made = kernel("forging_chu2020", "inverse", backend)
    arguments = inputs("forging_chu2020", "inverse", random_states("forging_chu2020", 1)[0], 0)
    rng = np.random.default_rng(1)
    rows = [np.tile(a, (200, 1)) for a in arguments]
    for k in range(3):
        rows[k] += rng.uniform(-0.01, 0.01, rows[k].shape)
    whole, _ = made(*rows)
    part, codes = made(*(a[-count:] for a in rows))
    assert np.array_equal(part["tau"], whole["tau"][-count:])
    assert not codes.any()


@pytest.mark.parametrize("backend", BACKENDS)
def test_vectors_may_be_shared_by_all_states(backend: str) -> None:
    made = kernel("forging_chu2020", "inverse", backend)
    arguments = inputs("forging_chu2020", "inverse", random_states("forging_chu2020", 1)[0], 0)
    many = [np.tile(a, (70, 1)) for a in arguments]
    each, _ = made(*many)
    shared, _ = made(many[0], *arguments[1:])
    assert np.array_equal(each["tau"], shared["tau"])


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(("name", "width"), swept([("forging_chu2020", 1.5), ("gough", 0.3)]))
def test_states_without_an_answer_have_the_plain_status(
    name: str, width: float, backend: str
) -> None:
    state = random_states(name, 1)[0]
    arguments = inputs(name, "inverse", state, 0)
    spread = np.random.default_rng(3).uniform(-width, width, (60, len(state.u)))
    made = kernel(name, "inverse", backend)
    rows = [np.tile(a, (60, 1)) for a in arguments]
    rows[0] = rows[0] + spread
    _, codes = made(*rows)
    for k in range(60):
        single, code = made(*(a[k] for a in rows))
        assert code == codes[k]
        assert plain(name, "inverse", [a[k] for a in rows])[1] == code
        assert code != 0 or np.isfinite(single["tau"]).all()
    assert 0 < np.count_nonzero(codes) < 60
