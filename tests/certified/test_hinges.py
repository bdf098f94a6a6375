"""Platforms on three legs with hinges at the base: all poses, against a search."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core.closed_state import mode_search
from tests.hard_cases.linkages import robot

THREE_LEGS = """
format: 1
name: three_legs
links:
  base: {}
  sx: {}
  sy: {}
  sz: {}
  g1: {}
  g2: {}
  plat: {mass: 10, inertia: {sphere: {radius: 0.3}}}
joints:
  x: {type: prismatic, parent: base, child: sx, axis: x}
  y: {type: prismatic, parent: sx, child: sy, axis: y}
  z: {type: prismatic, parent: sy, child: sz, axis: z}
  a1: {type: revolute, parent: sz, child: g1, axis: x}
  a2: {type: revolute, parent: g1, child: g2, axis: y}
  a3: {type: revolute, parent: g2, child: plat, axis: z}
legs:
  leg0:
    joints:
      - {name: f0, type: revolute, axis: [0,1,0], origin: {xyz: [1.0, 0.0, 0.0]}}
      - {name: l0, type: prismatic, axis: z, link: rod0, body: {mass: 1, com: [0,0,-0.2]}}
    to: {plat: [0.6, 0.0, 0.0]}
  leg1:
    joints:
      - {name: f1, type: revolute, axis: [-0.866,-0.5,0.1], origin: {xyz: [-0.5, 0.866, 0.0]}}
      - {name: l1, type: prismatic, axis: z, link: rod1, body: {mass: 1, com: [0,0,-0.2]}}
    to: {plat: [-0.3, 0.5, 0.0]}
  leg2:
    joints:
      - {name: f2, type: revolute, axis: [0.866,-0.5,0], origin: {xyz: [-0.5, -0.866, 0.0]}}
      - {name: l2, type: prismatic, axis: z, link: rod2, body: {mass: 1, com: [0,0,-0.2]}}
    to: {plat: [-0.28, -0.53, 0.0]}
active: [l0, l1, l2]
end_effector: {link: plat}
reference: {z: 1.0, l0: 1.05, l1: 1.0, l2: 1.1}
"""


def test_all_modes_are_listed_and_closed() -> None:
    machine = robot(THREE_LEGS)
    modes = machine.assembly_modes(machine.reference)
    assert modes.complete
    assert "all 16 complex solutions are certified" in modes.reason
    assert len(modes) % 2 == 0
    assert all(mode.state.residual < 1e-12 for mode in modes)


@pytest.mark.sweep(sample="test_all_modes_are_listed_and_closed")
def test_modes_are_those_of_a_search(monkeypatch: pytest.MonkeyPatch) -> None:
    machine = robot(THREE_LEGS)
    modes = machine.assembly_modes(machine.reference)
    monkeypatch.setattr(mode_search, "certified_modes", lambda *_: None)
    searched = machine.assembly_modes(machine.reference)
    assert not searched.complete
    listed = np.array([machine.forward_kinematics(mode.state).rotation for mode in modes])
    for mode in searched:
        rotation = machine.forward_kinematics(mode.state).rotation
        apart = np.abs(listed - rotation).max(axis=(1, 2))
        assert np.count_nonzero(apart < 1e-6) == 1
    assert len(searched) == len(modes)
