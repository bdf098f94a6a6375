"""The momentum of closed mechanisms is the sum over their links, the centre of mass moves by it."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, Payload, load
from tests.sampling import SHIPPED_SAMPLE, swept

ROBOTS = ("ankle", "delta", "excavator", "five_bar", "forging_chu2020", "gough")
STEP = 1e-6  # [s] of central differences: errors of 1e-12 by truncation, 1e-9 by rounding


@pytest.mark.parametrize("name", swept(ROBOTS, SHIPPED_SAMPLE))
def test_momentum_and_centre_of_mass_are_those_of_the_links(name: str) -> None:
    robot = load(name)
    rng = np.random.default_rng(4)
    state = robot.close(robot.reference, 0.1 * rng.normal(size=len(robot.active)))
    centroidal = robot.centroidal(state)
    assert centroidal.momentum_matrix @ state.du == pytest.approx(centroidal.momentum, abs=1e-9)
    total = np.zeros(6)
    moment = np.zeros(3)
    mass = 0.0
    for link_name, link in robot.description.links.items():
        if link_name == robot.base_frame or link.mass == 0.0:
            continue
        pose = robot.forward_kinematics(state, link_name)
        velocity = robot.jacobian(state, link_name) @ state.du
        arm = pose.rotation @ link.com
        linear = link.mass * (velocity[:3] + np.cross(velocity[3:], arm))
        inertia = pose.rotation @ link.inertia @ pose.rotation.T
        place = pose.position + arm - centroidal.com
        total += np.r_[linear, np.cross(place, linear) + inertia @ velocity[3:]]
        moment += link.mass * (pose.position + arm)
        mass += link.mass
    assert centroidal.mass == pytest.approx(mass)
    assert centroidal.com == pytest.approx(moment / mass)
    assert centroidal.momentum == pytest.approx(total, abs=1e-9 * mass)
    ahead, behind = (
        robot.centroidal(robot.close(state.u + sign * STEP * state.du, near=state)).com
        for sign in (1.0, -1.0)
    )
    moved = (ahead - behind) / (2.0 * STEP)
    assert centroidal.com_velocity == pytest.approx(moved, abs=1e-8)


def test_a_payload_counts() -> None:
    robot = load("excavator")
    state = robot.close(robot.reference)
    loads = robot.loads.with_payload(Payload(500.0))
    without, with_payload = robot.centroidal(state), robot.centroidal(state, loads)
    assert with_payload.mass - without.mass == pytest.approx(500.0)
    tip = robot.forward_kinematics(state).position
    together = (without.mass * without.com + 500.0 * tip) / with_payload.mass
    assert with_payload.com == pytest.approx(together)


def test_without_a_mass_there_is_no_centre_of_mass() -> None:
    robot = load("staicu2015")
    state = robot.close(robot.reference)
    with pytest.raises(InputError, match="no moving link has a mass"):
        robot.centroidal(state)
    with_payload = robot.centroidal(state, robot.loads.with_payload(Payload(2.0)))
    assert with_payload.mass == pytest.approx(2.0)
    tip = robot.forward_kinematics(state).position
    assert with_payload.com == pytest.approx(tip)
