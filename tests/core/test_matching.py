"""Equations are matched to unknowns as a library of graphs does it, without its time to start."""

from __future__ import annotations

import subprocess
import sys
from typing import NamedTuple

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching

from hybrid_dynamics_core.closure.matching import match
from tests.sampling import examples


class Involved(NamedTuple):
    """An equation: its number, and the coordinates in it."""

    index: int
    involved: frozenset[int]


@st.composite
def systems(draw: st.DrawFn) -> list[frozenset[int]]:
    """Unknowns in each equation, mostly with a full match."""
    size = draw(st.integers(1, 8))
    sets = st.frozensets(st.integers(0, size - 1), max_size=3)
    rows = draw(st.lists(sets, min_size=size, max_size=size))
    order = draw(st.permutations(range(size)))
    if draw(st.integers(0, 3)):
        rows = [row | {column} for row, column in zip(rows, order, strict=True)]
    return rows


@examples(800)
@given(systems())
def test_blocks_are_those_of_a_library_of_graphs(rows: list[frozenset[int]]) -> None:
    equations = [Involved(index, row) for index, row in enumerate(rows)]
    result = match(equations, range(len(rows)))  # type: ignore[arg-type]
    dense = np.array([[column in row for column in range(len(rows))] for row in rows], dtype=float)
    matched = maximum_bipartite_matching(csr_array(dense), perm_type="column")
    missing = int((matched < 0).sum())
    assert len(result.surplus) == missing
    assert bool(result.undetermined) == bool(missing)
    if missing:
        return
    graph = csr_array(dense[:, matched])
    _, label = connected_components(graph, directed=True, connection="strong")
    blocks = [tuple(e.index for e in block.equations) for block in result.blocks]
    expected = {tuple(np.flatnonzero(label == one).tolist()) for one in set(label.tolist())}
    assert set(blocks) == expected
    assert len(blocks) == len(expected)
    solved: set[int] = set()
    for block in result.blocks:
        solved.update(block.unknowns)
        for equation in block.equations:
            assert equation.involved <= solved


def test_of_equations_too_many_the_last_are_surplus() -> None:
    sets = ({0}, {0, 1}, {1}, {0})
    equations = [Involved(index, frozenset(row)) for index, row in enumerate(sets)]
    result = match(equations, [0, 1])  # type: ignore[arg-type]
    assert [equation.index for equation in result.surplus] == [2, 3]


def test_a_robot_is_loaded_without_libraries_that_are_slow_to_start() -> None:
    code = (
        "import sys, jsonschema; before = set(sys.modules);"  # older ones bring urllib.request
        "import hybrid_dynamics_core as hd, hybrid_dynamics_core.filtering;"
        "import hybrid_dynamics_core.calibration;"
        "hd.load('excavator'); new = set(sys.modules) - before;"
        "print([name for name in new if name.startswith(('scipy.', 'urllib.request'))])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
