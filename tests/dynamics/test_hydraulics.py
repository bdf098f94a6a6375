"""Hydraulic cylinders: pressures, flows, strokes, and drives that sit elsewhere than the active
coordinates.
"""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from hybrid_dynamics_core import (
    HydraulicCylinder,
    InputError,
    Robot,
    SingularityError,
    chamber_flows,
    chamber_pressures,
    cylinder_force,
    force_range,
)
from tests.mechanisms import changed, mechanism

BOOM = HydraulicCylinder(
    "q12", bore=0.08, rod=0.05, stroke=(-0.05, 0.6), return_pressure=3e5, supply_pressure=2.5e7
)
STICK = HydraulicCylinder("q22", bore=0.06, rod=0.04, stroke=(-0.05, 0.25), sign=-1.0, count=2)
U = [0.3, 0.15, 0.175, 0.4]


@pytest.fixture(scope="module")
def oiled(forging: Robot) -> Robot:
    return changed(forging, actuators=MappingProxyType({"q12": BOOM, "q22": STICK}))


def test_numbers_by_hand() -> None:
    """A bore of 80 mm: 50.27 cm^2; at 100 bar against 3 bar on 30.63 cm^2: 49346 N."""
    assert BOOM.cap_area == pytest.approx(50.2655e-4, rel=1e-5)
    assert BOOM.rod_area == pytest.approx(30.6305e-4, rel=1e-5)
    assert cylinder_force(BOOM, 1e7, 3e5) == pytest.approx(49346.3, rel=1e-5)
    cap, rod = chamber_flows(BOOM, 0.1)
    assert (cap * 6e4, rod * 6e4) == pytest.approx((30.159, -18.378), rel=1e-4)  # litres a minute


@given(st.floats(-2e5, 2e5), st.sampled_from([BOOM, STICK]))
def test_pressures_give_the_force_back(force: float, cylinder: HydraulicCylinder) -> None:
    cap, rod = chamber_pressures(cylinder, force)
    assert float(cylinder_force(cylinder, cap, rod)) == pytest.approx(force, rel=1e-12, abs=1e-8)
    assert min(cap, rod) == cylinder.return_pressure  # one chamber rests
    assert max(cap, rod) >= cylinder.return_pressure


@pytest.mark.parametrize("cylinder", [BOOM, replace(STICK, supply_pressure=2e7)])
def test_force_range_is_where_the_supply_ends(cylinder: HydraulicCylinder) -> None:
    for force in force_range(cylinder):
        assert max(chamber_pressures(cylinder, force)) == pytest.approx(cylinder.supply_pressure)
    low, high = force_range(cylinder)
    assert low < 0.0 < high


def test_oil_brings_in_the_power_of_the_joint(oiled: Robot) -> None:
    state = oiled.close(U, [0.1, 0.05, -0.04, 0.2])
    tau = oiled.inverse_dynamics(state, [0.2, 0.1, 0.1, 0.3])
    cylinders = oiled.hydraulics(state, tau)
    for k, name in ((1, "q12"), (2, "q22")):
        c = cylinders[name]
        assert float(c.force) == pytest.approx(tau[k])
        assert c.cap_pressure * c.cap_flow + c.rod_pressure * c.rod_flow == pytest.approx(
            tau[k] * state.du[k]
        )
        assert c.power == pytest.approx(tau[k] * state.du[k])
    assert cylinders["q12"].demand == pytest.approx(0.05 * BOOM.cap_area)
    assert cylinders["q22"].demand == pytest.approx(
        0.04 * STICK.cap_area
    )  # it extends as the coordinate shrinks
    assert (cylinders["q12"].to_lower, cylinders["q12"].to_upper) == pytest.approx((0.2, 0.45))
    assert not cylinders["q12"].overloaded


def test_overload_is_reported(oiled: Robot) -> None:
    state = oiled.close(U)
    low, high = force_range(BOOM)
    for force, told in ((high + 1.0, True), (high - 1.0, False), (low - 1.0, True)):
        assert bool(oiled.hydraulics(state, [0.0, force, 0.0, 0.0])["q12"].overloaded) is told


def test_batch(oiled: Robot) -> None:
    state = oiled.close([U, U], [[0, 0.1, 0, 0], [0, -0.1, 0, 0]])
    cylinders = oiled.hydraulics(state, [[0, 1e3, 0, 0], [0, -1e3, 0, 0]])
    assert cylinders["q12"].cap_pressure.shape == (2,)
    single = oiled.hydraulics(oiled.close(U, [0, -0.1, 0, 0]), [0, -1e3, 0, 0])["q12"]
    assert cylinders["q12"].rod_flow[1] == pytest.approx(float(single.rod_flow))


def test_cylinder_on_a_passive_joint_drives_the_crank(forging: Robot) -> None:
    """The forging robot told by its arm angles.

    The cylinders are passive there, and are still what pushes.
    """
    arm = changed(
        forging,
        active=("q1", "q2", "q3", "q4"),
        actuators=MappingProxyType({"q12": BOOM, "q22": STICK}),
        closures=tuple(
            replace(c, assembly=c.assembly if c.assembly == "parallelogram" else None)
            for c in forging.description.closures
        ),
    )
    assert arm.drives == ("q1", "q4", "q12", "q22")
    here = forging.close(U, [0.1, 0.05, -0.04, 0.2])
    ddu = np.array([0.2, 0.1, 0.1, 0.3])
    names = [here.s[forging.coordinates.index(n)] for n in arm.active]
    rates = [here.ds[forging.coordinates.index(n)] for n in arm.active]
    pushes = forging.accelerations(here, ddu)[[forging.coordinates.index(n) for n in arm.active]]
    there = arm.close(names, rates)
    tau = arm.inverse_dynamics(there, pushes)
    forces = arm.drive_forces(there, tau)
    expected = dict(zip(forging.active, forging.inverse_dynamics(here, ddu), strict=True))
    for name, force in forces.items():
        assert float(force) == pytest.approx(expected[name], rel=1e-9)
    assert arm.generalised_forces(there, forces) == pytest.approx(tau, rel=1e-9)
    assert arm.forward_dynamics(there, arm.generalised_forces(there, forces)) == pytest.approx(
        pushes, rel=1e-8
    )
    assert float(arm.hydraulics(there, tau)["q12"].force) == pytest.approx(
        expected["q12"], rel=1e-9
    )


def test_wrong_forces_are_refused(oiled: Robot) -> None:
    state = oiled.close(U)
    with pytest.raises(InputError, match="no joint 'q99'"):
        oiled.generalised_forces(state, {"q99": 1.0})
    with pytest.raises(InputError, match="'q12' has shape"):
        oiled.generalised_forces(state, {"q12": [1.0, 2.0]})


def test_drive_at_its_dead_centre_is_refused_with_evidence() -> None:
    """A cylinder that pushes a crank by its rod: with both in line no force turns it."""
    robot = mechanism("slider_crank")
    robot = changed(
        robot, actuators=MappingProxyType({"s": HydraulicCylinder("s", bore=0.05, rod=0.03)})
    )
    assert robot.drives == ("t", "s")
    k = robot.coordinates.index("s")
    dead = brentq(lambda a: robot.close([0.0, a]).R[k, 1], -1.0, 1.0, xtol=1e-15)
    assert robot.close([0.0, dead]).singularity > 0.5  # the loop itself closes well
    for u in ([0.0, dead], [[0.0, 0.6], [0.0, dead]]):
        state = robot.close(u)
        with pytest.raises(
            SingularityError, match=r"moving a \(\+1\) moves none of them"
        ) as caught:
            robot.drive_forces(state, np.ones_like(state.u))
        assert caught.value.index == (None if state.u.ndim == 1 else 1)
        assert caught.value.distance < 1e-9
    assert np.isfinite(
        robot.drive_forces(robot.close([[0.0, 0.6], [0.0, 0.6]]), np.ones((2, 2)))["s"]
    ).all()
