"""Links whose weight is not felt: weights add up, energy fits, files keep it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import mujoco
import numpy as np
import pytest

from hybrid_dynamics_core import InputError, Robot, load
from hybrid_dynamics_core.description.model import Link, RobotDescription
from hybrid_dynamics_core.dynamics.parameters import described_parameters
from hybrid_dynamics_core.export import to_mjcf, to_sdf, to_urdf_plus, to_yaml
from tests.mechanisms import changed
from tests.robots import ROBOTS, random_states, random_vector, robot, scaled
from tests.sampling import swept

SAMPLE = ("forging_chu2020",)
FORMS = {to_yaml: "yaml", to_mjcf: "xml", to_sdf: "sdf", to_urdf_plus: "urdf"}


def shares_of(description: RobotDescription, seed: int) -> dict[str, float]:
    """A share for each link; some none, some all."""
    rng = np.random.default_rng(seed)
    shares = rng.choice([0.0, 1.0, 0.3, 1.7, -0.4], len(description.links))
    return dict(zip(description.links, shares.tolist(), strict=True))


def compensated(machine: Robot, shares: dict[str, float]) -> Robot:
    links: dict[str, Link] = {}
    for name, link in machine.description.links.items():
        mass = shares[name] * link.mass
        links[name] = replace(link, compensated_mass=mass, compensated_com=link.com)
    return changed(machine, links=MappingProxyType(links))


@pytest.mark.parametrize("name", swept(ROBOTS, SAMPLE))
class TestCompensation:
    def test_weights_add_up(self, name: str) -> None:
        """tau is that without gravity, and of each share what half as much gravity changes."""
        machine = robot(name)
        shares = shares_of(machine.description, 3)
        ddu = random_vector(machine, 1)
        less = compensated(machine, shares)
        alone = {}
        for link in shares:
            if machine.description.links[link].mass and link != machine.description.base:
                alone[link] = compensated(machine, dict.fromkeys(shares, 1.0) | {link: 0.0})
        for state in random_states(name, 2):
            total = machine.inverse_dynamics(state, ddu, machine.loads.with_gravity(np.zeros(3)))
            for link, felt in alone.items():
                weight = felt.inverse_dynamics(felt.close(state.u), np.zeros(len(ddu)))
                total = total + (1.0 - shares[link]) * weight
            tau = less.inverse_dynamics(less.close(state.u, state.du, near=state), ddu)
            full = machine.inverse_dynamics(state, ddu)
            assert scaled(tau - total, full, total) < 1e-10

    def test_one_share_is_less_gravity(self, name: str) -> None:
        machine = robot(name)
        ddu = random_vector(machine, 2)
        less = compensated(machine, dict.fromkeys(machine.description.links, 0.3))
        loads = machine.loads.with_gravity(0.7 * machine.description.gravity)
        for state in random_states(name, 2):
            expected = machine.inverse_dynamics(state, ddu, loads)
            other = less.close(state.u, state.du, near=state)
            tau = less.inverse_dynamics(other, ddu)
            assert scaled(tau - expected, machine.inverse_dynamics(state, ddu)) < 1e-11
            potentials = [
                less.energy(other).potential,
                machine.energy(state, loads=loads).potential,
            ]
            assert potentials[0] == pytest.approx(potentials[1], rel=1e-10, abs=1e-10)

    def test_the_regressor_feels_it(self, name: str) -> None:
        machine = robot(name)
        less = compensated(machine, shares_of(machine.description, 5))
        values = described_parameters(less.description).values(less.description)
        for state in random_states(name, 2):
            other = less.close(state.u, state.du, near=state)
            ddu = random_vector(machine, 3)
            terms = less.regressor(other, ddu) * values
            tau = less.inverse_dynamics(other, ddu)
            assert scaled(terms.sum(axis=1) - tau, np.abs(terms).sum(axis=1)) < 1e-11

    def test_gravity_does_the_work_that_the_potential_loses(self, name: str) -> None:
        machine = compensated(robot(name), shares_of(robot(name).description, 7))
        step = 1e-5
        for state in random_states(name, 2):
            middle = machine.close(state.u, state.du, near=state)
            g = machine.minimal_form(middle)[2]
            ends = [machine.close(state.u + h * state.du, near=middle) for h in (-step, step)]
            before, after = (machine.energy(end).potential for end in ends)
            terms = np.abs(g * state.du).sum()
            assert abs((after - before) / (2 * step) - g @ state.du) < 1e-6 * max(1.0, terms)


TWO_LINKS = """
format: 1
name: two
base: world
links:
  a: {mass: 2, com: [0.1, 0.2, 0], inertia: {xx: 0.1, yy: 0.1, zz: 0.1}, gravity_compensation: 0.4}
  b: {mass: 1, com: [0.3, 0, 0.1], inertia: {xx: 0.1, yy: 0.1, zz: 0.1}, gravity_compensation: 1}
  c: {mass: 0.5, com: [0, 0.1, 0], inertia: {xx: 0.1, yy: 0.1, zz: 0.1}}
joints:
  p: {type: revolute, parent: world, child: a, axis: y}
  q: {type: revolute, parent: a, child: b, axis: x,
      origin: {xyz: [0.2, 0, 0], rpy: [0.1, 0.2, 0.3]}}
  r: {type: fixed, parent: b, child: c, origin: {xyz: [0, 0.3, 0.1], rpy: [0.5, 0, 0]}}
active: [p, q]
end_effector: {link: c}
"""


def two_links(folder: Path) -> Robot:
    file = folder / "two.yaml"
    file.write_text(TWO_LINKS, encoding="utf-8")
    return load(file)


@pytest.mark.parametrize("export", FORMS)
def test_files_keep_it(export, tmp_path: Path) -> None:
    machine = two_links(tmp_path)
    file = tmp_path / f"back.{FORMS[export]}"
    file.write_text(export(machine), encoding="utf-8")
    back = load(file)
    for u in ([0.3, -0.7], [1.0, 0.2]):
        one, other = machine.close(u, [1.0, 2.0]), back.close(u, [1.0, 2.0])
        expected = machine.inverse_dynamics(one, [0.5, -1.0])
        assert back.inverse_dynamics(other, [0.5, -1.0]) == pytest.approx(expected, rel=1e-9)


def test_mujoco_lifts_the_same(tmp_path: Path) -> None:
    """The fixed link has weight, the one that it is fixed to has none."""
    machine = two_links(tmp_path)
    text = """<mujoco><compiler angle="radian" eulerseq="XYZ"/><worldbody>
      <body gravcomp=".4"><joint name="p" axis="0 1 0"/>
      <inertial pos=".1 .2 0" mass="2" diaginertia=".1 .1 .1"/>
      <body gravcomp="1" pos=".2 0 0" euler=".1 .2 .3"><joint name="q" axis="1 0 0"/>
      <inertial pos=".3 0 .1" mass="1" diaginertia=".1 .1 .1"/>
      <body pos="0 .3 .1" euler=".5 0 0"><inertial pos="0 .1 0" mass=".5" diaginertia=".1 .1 .1"/>
      </body></body></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = [0.3, -0.7], [1.0, 2.0]
    mujoco.mj_forward(model, data)
    mass = np.zeros((2, 2))
    mujoco.mj_fullM(model, data, mass)
    expected = mass @ [0.5, -1.0] + data.qfrc_bias - data.qfrc_passive
    state = machine.close(data.qpos, data.qvel)
    assert machine.inverse_dynamics(state, [0.5, -1.0]) == pytest.approx(expected, rel=1e-9)


def test_parts_of_different_shares_have_no_regressor(tmp_path: Path) -> None:
    machine = two_links(tmp_path)
    assert machine.description.links["b"].gravity_compensation is None
    with pytest.raises(InputError, match="acts on some of the parts of 'b' alone"):
        machine.regressor(machine.close([0.1, 0.2], [0, 0]), [0, 0])
