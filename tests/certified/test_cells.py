"""Cells of active coordinates: what is proved of them holds for every input in them."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import InputError
from hybrid_dynamics_core.certified.boxes.cells import CellKind
from tests.robots import robot
from tests.sampling import swept

CASES = [
    ("five_bar", {"q_L": (0.2, 3.0), "q_R": (0.0, 2.8)}),
    ("delta", {"theta_A": (-1.2, 1.8), "theta_B": (-1.2, 1.8)}),
    ("forging_chu2020", {"q12": (-0.3, 0.9), "q22": (-0.3, 0.5)}),
    ("gough", {}),
]


@pytest.mark.parametrize(("name", "ranges"), swept(CASES, ["five_bar", "forging_chu2020"]))
def test_samples_of_cells_are_what_was_proved(name: str, ranges: dict) -> None:
    machine = robot(name)
    if name == "gough":
        ranges = {machine.active[0]: machine.reference[0] + np.array([-0.01, 0.01])}
    cells = machine.certify_cells(ranges, depth=8)
    assert sum(cells.share(kind) for kind in CellKind) == pytest.approx(1.0)
    rng = np.random.default_rng(0)
    u = cells.lower + rng.uniform(0.0, 1.0, cells.lower.shape) * (cells.upper - cells.lower)
    states = machine.close(u, check=False)
    closed, is_open = cells.kind == CellKind.CLOSED, cells.kind == CellKind.OPEN
    assert closed.any()
    assert (states.status[closed] == 0).all()
    assert (states.status[is_open] != 0).all()
    places = machine.forward_kinematics(states).position
    assert (cells.position_lower - 1e-9 <= places)[closed].all()
    assert (places <= cells.position_upper + 1e-9)[closed].all()
    assert np.isnan(cells.position_lower[~closed]).all()


def test_more_halvings_decide_more_and_keep_what_was_decided() -> None:
    machine = robot("forging_chu2020")
    ranges = {"q12": (-0.3, 0.9), "q22": (-0.3, 0.5)}
    shares = []
    for depth in (2, 5, 8):
        cells = machine.certify_cells(ranges, depth)
        shares.append([cells.share(kind) for kind in CellKind])
    assert (np.diff(shares, axis=0)[:, :2] >= -1e-12).all()
    assert shares[-1][CellKind.OPEN] > 0.0
    assert shares[-1][CellKind.UNDECIDED] < shares[0][CellKind.UNDECIDED]


def test_what_is_no_box_of_active_coordinates_is_refused() -> None:
    machine = robot("five_bar")
    with pytest.raises(InputError, match="q_X"):
        machine.certify_cells({"q_X": (0.0, 1.0)})
    with pytest.raises(InputError, match="finite bounds"):
        machine.certify_cells({"q_L": (1.0, 0.0)})
    with pytest.raises(InputError, match="depth"):
        machine.certify_cells({"q_L": (0.0, 1.0)}, depth=31)
