"""The regressor: Y pi is the inverse dynamics, for the robot's own parameters and for others."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
import pytest

from hybrid_dynamics_core import InputError, Parameters
from hybrid_dynamics_core.dynamics.parameters import described_parameters, link_of
from tests.mechanisms import changed, random_link
from tests.robots import ROBOTS, random_states, random_vector, robot, scaled
from tests.sampling import swept


@pytest.mark.parametrize("name", swept(ROBOTS))
class TestRegressor:
    def test_times_the_parameters_is_tau(self, name: str) -> None:
        machine = robot(name)
        values = described_parameters(machine.description).values(machine.description)
        for k, state in enumerate(random_states(name)):
            ddu = random_vector(machine, k)
            terms = machine.regressor(state, ddu) * values
            tau = machine.inverse_dynamics(state, ddu)
            assert scaled(terms.sum(axis=1) - tau, np.abs(terms).sum(axis=1)) < 1e-12

    def test_of_other_parameters_is_tau_of_another_robot(self, name: str) -> None:
        """Links, friction and rotors changed at once."""
        machine = robot(name)
        rng = np.random.default_rng(1)
        links = described_parameters(machine.description).links
        joints = machine.coordinates
        parameters = Parameters(links, joints, joints[:2], joints[1:])
        others = {link: random_link(link, rng, 0.2) for link in links}
        other = changed(machine, links=MappingProxyType({**machine.description.links, **others}))
        size = len(joints)
        friction, coulomb, rotors = (
            rng.uniform(0, 3, size),
            rng.uniform(0, 3, size),
            rng.uniform(0, 2, size),
        )
        coulomb[2:], rotors[:1] = 0.0, 0.0
        loads = other.loads.with_effects(viscous=friction, coulomb=coulomb, armature=rotors)
        values = parameters.values(other.description, loads.effects)
        for k, state in enumerate(random_states(name)):
            ddu = random_vector(machine, k)
            terms = machine.regressor(state, ddu, parameters) * values
            tau = other.inverse_dynamics(other.close(state.u, state.du, near=state), ddu, loads)
            assert scaled(terms.sum(axis=1) - tau, np.abs(terms).sum(axis=1)) < 1e-11

    def test_a_batch_is_its_states(self, name: str) -> None:
        machine, states = robot(name), random_states(name)
        batch = machine.close(np.array([s.u for s in states]), np.array([s.du for s in states]))
        ddu = np.ones_like(batch.u)
        many = machine.regressor(batch, ddu)
        for k, state in enumerate(states):
            single = machine.regressor(state, ddu[k])
            assert scaled(many[k] - single, single) < 1e-10


def test_what_is_too_large_to_compute_with_is_refused_and_what_does_not_close_is_nan() -> None:
    machine = robot("forging_chu2020")
    u = machine.reference
    fast = machine.close(u, np.full(4, 1e150))
    open_too = machine.close(np.stack([u, np.add(u, [0.0, 0.9, 0.0, 0.0])]), check=False)
    assert np.asarray(open_too.status).tolist() == [0, 1]
    for dynamics in (machine.regressor, machine.inverse_dynamics):
        with pytest.raises(InputError, match="the result is not finite"):
            dynamics(fast, np.full(4, 1e308))
        values = dynamics(open_too, np.zeros((2, 4)))
        assert np.isfinite(values[0]).all()
        assert np.isnan(values[1]).all()


@pytest.mark.parametrize("name", swept(ROBOTS))
def test_links_come_back_from_their_parameters(name: str) -> None:
    description = robot(name).description
    parameters = described_parameters(description)
    values = parameters.values(description)
    assert len(parameters.names) == len(values)
    for k, link in enumerate(parameters.links):
        again, own = link_of(link, values[10 * k : 10 * k + 10]), description.links[link]
        assert again.mass == own.mass
        assert again.com == pytest.approx(own.com, abs=1e-12)
        assert again.inertia == pytest.approx(
            own.inertia, rel=1e-9, abs=1e-9 * max(own.inertia.max(), 1.0)
        )
