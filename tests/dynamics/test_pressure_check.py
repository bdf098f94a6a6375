"""Measured pressures are held against those of supply and relief valve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hybrid_dynamics_core import HydraulicCylinder
from hybrid_dynamics_core.dynamics.pressure_check import (
    excess,
    fits_exchanged,
    pressure_problem,
)

CYLINDER = HydraulicCylinder("lift", bore=0.1, rod=0.05, supply_pressure=250e5)
RELIEVED = replace(CYLINDER, relief_pressure=200e5)


def test_the_lower_one_of_supply_and_relief_valve_counts():
    assert pressure_problem(CYLINDER, 0.0, 370e5) == ""
    assert "its supply has" in pressure_problem(CYLINDER, 0.0, 380e5)
    assert pressure_problem(RELIEVED, 0.0, 290e5) == ""
    assert "its relief valve has" in pressure_problem(RELIEVED, 0.0, 310e5)


def test_margins_are_those_to_the_lower_one():
    assert excess(CYLINDER, 300e5) == (
        "lift: a measured pressure of 300 bar, 50 bar beyond its supply of 250 bar"
    )
    assert excess(RELIEVED, 240e5) == (
        "lift: a measured pressure of 240 bar, 40 bar beyond its relief valve of 200 bar"
    )
    assert excess(replace(CYLINDER, supply_pressure=np.inf), 9e7) == ""


@pytest.mark.parametrize(("peaks", "told"), [(0, False), (10, False), (11, True), (100, True)])
def test_a_tenth_of_the_samples_may_be_peaks(peaks, told):
    pressures = np.full(100, 249e5)
    pressures[:peaks] = 300e5
    assert bool(excess(CYLINDER, pressures)) == told


def test_exchanged_chambers_leave_a_quarter_of_the_squares_at_most():
    assert fits_exchanged(4.1, 1.0)
    assert not fits_exchanged(3.9, 1.0)
    assert not fits_exchanged(0.0, 0.0)
