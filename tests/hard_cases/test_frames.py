"""Machines whose frames stand where numbers vanish: at one place, or very far away."""

from __future__ import annotations

import numpy as np
import pytest

from hybrid_dynamics_core import Robot
from tests.hard_cases.linkages import robot

LEGS = """\
format: 1
name: legs
links: {{base: {{}}, sx: {{}}, sy: {{}}, p: {{mass: 1}}}}
joints:
  x: {{type: prismatic, parent: base, child: sx, axis: x, origin: {{xyz: [{x}, {y}, 0]}}}}
  y: {{type: prismatic, parent: sx, child: sy, axis: y}}
  z: {{type: prismatic, parent: sy, child: p, axis: z}}
legs:
{legs}
active: [l0, l1, l2]
end_effector: {{link: p}}
reference: {{l0: 0.9055385138137417, l1: 1.104536101718726, l2: 1.104536101718726,
  x: 0.3, y: 0.3, z: 0.8}}
"""
LEG = """\
  g{k}:
    joints:
      - {{name: f{k}, type: revolute, axis: x, origin: {{xyz: [{x}, {y}, 0]}}}}
      - {{name: t{k}, type: revolute, axis: y, link: b{k}, body: {{mass: 1}}}}
      - {{name: l{k}, type: prismatic, axis: z, offset: 0.0, link: r{k}, body: {{mass: 1}}}}
    to: {{p: [0, 0, 0]}}
"""


def legs(x: float, y: float) -> Robot:
    """A point on three legs, which are straight strokes from a corner; the base's origin moved."""
    feet = [(x, y), (1.0 + x, y), (x, 1.0 + y)]
    texts = [LEG.format(k=k, x=foot[0], y=foot[1]) for k, foot in enumerate(feet)]
    return robot(LEGS.format(x=x, y=y, legs="".join(texts)))


@pytest.mark.parametrize("place", [(0.0, 0.0), (1.0, 1.0), (-3e3, 2e4)])
def test_the_place_of_the_base_is_a_choice_of_words(place: tuple[float, float]) -> None:
    machine = legs(*place)
    state = machine.close(machine.reference)
    # rows of J_z by hand: along each leg, over its length squared
    along = np.array([0.3, 0.3, 0.8]) - np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    rows = along / np.sum(along**2, axis=1, keepdims=True)
    distance = 3.0 / (np.linalg.norm(rows) * np.linalg.norm(np.linalg.inv(rows)))
    assert state.singularity == pytest.approx(distance, abs=1e-9)  # rounding at 2e4 m
    assert len(machine.assembly_modes(machine.reference)) == 2
