"""Deflections that textbooks give in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, load, shipped_robots
from hybrid_dynamics_core.stiffness import Elasticity
from tests.sampling import swept
from tests.stiffness.machines import CANTILEVER, CRANE, machine

E, G, A, IY, IZ, J, LENGTH = 210e9, 81e9, 0.01, 2e-5, 1e-5, 3e-5, 4.0
EXACT = 1e-12  # a handful of products and one Cholesky factor of two by two


@pytest.mark.parametrize("shear", [math.inf, 0.004])
def test_a_cantilever_bends_as_timoshenko_says(shear):
    area = "" if shear == math.inf else f"Ay: {shear}, Az: {shear}"
    robot = machine(CANTILEVER, shear=area)
    compliance = robot.stiffness(robot.close([0.0])).compliance
    shift = LENGTH / (G * shear)
    assert compliance[0, 0] == pytest.approx(LENGTH / (E * A), rel=EXACT)
    assert compliance[1, 1] == pytest.approx(LENGTH**3 / (3 * E * IZ) + shift, rel=EXACT)
    assert compliance[2, 2] == pytest.approx(LENGTH**3 / (3 * E * IY) + shift, rel=EXACT)
    assert compliance[3, 3] == pytest.approx(LENGTH / (G * J), rel=EXACT)
    assert compliance[1, 5] == pytest.approx(LENGTH**2 / (2 * E * IZ), rel=EXACT)
    assert compliance[2, 4] == pytest.approx(-(LENGTH**2) / (2 * E * IY), rel=EXACT)
    assert compliance[5, 5] == pytest.approx(LENGTH / (E * IZ), rel=EXACT)


def test_a_weight_within_the_span_bends_what_is_before_it():
    robot = machine(CANTILEVER, shear="Ay: .inf")
    stiffness = robot.stiffness(robot.close([0.0]))
    loads = robot.loads.with_gravity([0.0, 0.0, -9.81])
    arm = 2.0
    # a force at a: w(L) = F a^2 (3 L - a) / (6 E I), turn F a^2 / (2 E I)
    force = 200 * 9.81
    drop = force * arm**2 * (3 * LENGTH - arm) / (6 * E * IY)
    moved = stiffness.deflection(loads).displacement
    assert moved[2] == pytest.approx(-drop, rel=EXACT)
    assert moved[4] == pytest.approx(force * arm**2 / (2 * E * IY), rel=EXACT)


def test_the_mass_on_a_cantilever_swings_as_on_a_spring():
    robot = machine(CANTILEVER, shear="Ay: .inf")
    modes = robot.stiffness(robot.close([0.0])).modes()
    # a point mass at half the span: 3 E I / a^3 across, E A / a along
    springs = [3 * E * IZ / 8.0, 3 * E * IY / 8.0, E * A / 2.0]
    expected = np.sqrt(np.array(springs) / 200) / (2 * np.pi)
    np.testing.assert_allclose(modes.frequencies, expected, rtol=EXACT)


def test_a_crane_stands_on_its_oil():
    robot = machine(CRANE)
    state = robot.close([2.5])
    cap, rod = math.pi / 4 * 0.1**2, math.pi / 4 * (0.1**2 - 0.06**2)
    oil = 1.2e9 * (cap**2 / (cap * 1.1 + 1e-3) + rod**2 / (rod * 0.9 + 2e-3))
    # the 3-4-5 triangle: the cylinder passes the foot at 2 * 1.5 / 2.5 m
    lever = 1.2
    force = 10e3
    drop = force * 5.0**2 / (oil * lever**2)
    deflection = robot.stiffness(state).under([0.0, 0.0, -force])
    assert deflection.displacement[2] == pytest.approx(-drop, rel=1e-9)  # the loop closes to 1e-12
    assert deflection.energy == pytest.approx(0.5 * force * drop, rel=1e-9)
    assert dict(deflection.energy_by_element) == {"drives.cylinder": deflection.energy}


@pytest.mark.parametrize("name", swept(shipped_robots(), ["delta", "excavator", "staicu2015"]))
def test_elastic_drives_alone_give_the_compliance_of_jacobians(name):
    """C = J (D^T K D)^-1 J^T, with the Jacobians of the closed loops."""
    robot = load(name)
    rng = np.random.default_rng(5)
    drives = dict(
        zip(robot.all_drives, 10 ** rng.uniform(5, 7, len(robot.all_drives)), strict=True)
    )
    state = robot.close(robot.reference)
    stiffness = robot.stiffness(state, Elasticity(drives))
    rates = robot.drive_rates(state)
    inner = np.linalg.inv(rates.T @ np.diag(list(drives.values())) @ rates)
    jacobian = robot.jacobian(state)
    expected = jacobian @ inner @ jacobian.T
    error = np.abs(stiffness.compliance - expected).max() / np.abs(expected).max()
    assert error < 1e-10  # one inverse each, of condition 1e3 at most


@pytest.mark.parametrize("name", swept(shipped_robots(), ["delta", "excavator", "staicu2015"]))
def test_elastic_drives_alone_swing_as_the_minimal_form_says(name):
    robot = load(name)
    drives = dict.fromkeys(robot.all_drives, 1e6)
    state = robot.close(robot.reference)
    stiffness = robot.stiffness(state, Elasticity(drives))
    if not any(link.mass for link in robot.description.links.values()):
        with pytest.raises(InputError, match="nothing that moves has a mass"):
            stiffness.modes()
        return
    modes = stiffness.modes()
    rates = robot.drive_rates(state)
    loads = robot.loads.with_effects(armature=np.zeros(len(robot.coordinates)))
    mass, _, _ = robot.minimal_form(state, loads)
    squares = np.linalg.eigvals(np.linalg.solve(mass, rates.T @ (1e6 * rates)))
    expected = np.sort(np.sqrt(squares.real)) / (2 * np.pi)
    np.testing.assert_allclose(modes.frequencies, expected, rtol=1e-6)  # masses of condition 1e6
