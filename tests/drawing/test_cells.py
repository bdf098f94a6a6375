"""Pictures of certified cells."""

from __future__ import annotations

from pathlib import Path

import pytest
from matplotlib.collections import PolyCollection

from hybrid_dynamics_core import InputError
from hybrid_dynamics_core.drawing import draw_cells
from tests.robots import robot

RANGES = {"q12": (-0.3, 0.9), "q22": (-0.3, 0.5)}


def test_each_cell_is_a_rectangle_of_its_kind(tmp_path: Path) -> None:
    machine = robot("forging_chu2020")
    cells = machine.certify_cells(RANGES, depth=6)
    path = tmp_path / "cells.svg"
    figure = draw_cells(machine, cells, path)
    (axes,) = figure.axes
    painted = [c for c in axes.collections if isinstance(c, PolyCollection)]
    assert [len(c.get_paths()) for c in painted] == [sum(cells.kind == k) for k in range(3)]
    assert axes.get_xlabel() == "q12 [m]"
    assert axes.get_ylabel() == "q22 [m]"
    texts = [text.get_text() for text in figure.texts]
    assert "Certified cells: forging_chu2020" in texts
    assert path.stat().st_size > 1000


def test_cells_of_one_coordinate_are_refused() -> None:
    machine = robot("forging_chu2020")
    cells = machine.certify_cells({"q12": (0.0, 0.1)}, depth=1)
    with pytest.raises(InputError, match="expected two"):
        draw_cells(machine, cells)
