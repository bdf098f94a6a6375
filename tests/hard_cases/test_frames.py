"""Machines whose frames stand where numbers vanish: at one place, or very far away."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.closure.constraints.spatial import extent_of
from tests.cli.calling import call
from tests.hard_cases.linkages import robot
from tests.sampling import examples

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


@examples(200)
@given(st.integers(0, 9999), st.booleans())
def test_the_size_of_a_loop_is_the_largest_distance_of_its_axes(seed: int, turns: bool) -> None:
    """By least squares along both lines; parallel ones too, wherever along them origins stand."""
    rng = np.random.default_rng(seed)
    axes = rng.normal(size=(3, 3))
    if turns:
        axes[:] = axes[0]
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    origins, end = rng.normal(size=(3, 3)), rng.normal(size=3)
    joints = [
        SimpleNamespace(origin=origin, axis=axis, body=SimpleNamespace(is_revolute=True))
        for origin, axis in zip(origins, axes, strict=True)
    ]
    lines = [*zip(origins, axes, strict=True), (end, np.zeros(3))]
    expected = 0.0
    for (one, along), (other, across) in combinations(lines, 2):
        directions = np.column_stack([along, -across])
        ways = np.linalg.pinv(directions, rcond=1e-9) @ (other - one)
        expected = max(expected, float(np.linalg.norm(other - one - directions @ ways)))
    assert extent_of([SimpleNamespace(end=end, joints=joints)]) == pytest.approx(expected)


@pytest.mark.parametrize("place", [(0.0, 0.0), (1.0, 1.0), (-3e3, 2e4)])
def test_the_place_of_the_base_is_a_choice_of_words(place: tuple[float, float]) -> None:
    machine = legs(*place)
    state = machine.close(machine.reference)
    # rows of J_z by hand: along each leg, over the square of one length, that of the base
    along = np.array([0.3, 0.3, 0.8]) - np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    distance = 3.0 / (np.linalg.norm(along) * np.linalg.norm(np.linalg.inv(along)))
    assert state.singularity == pytest.approx(distance, abs=1e-9)  # rounding at 2e4 m
    assert len(machine.assembly_modes(machine.reference)) == 2


# a point on two slides, and a rod that turns about the origin and slides to the point
ROD = """\
format: 1
name: rod
links: {{base: {{}}, sx: {{}}, p: {{mass: 1}}, turned: {{}}, rod: {{mass: 1}}}}
joints:
  x: {{type: prismatic, parent: base, child: sx, axis: x{limits}}}
  y: {{type: prismatic, parent: sx, child: p, axis: y}}
  q: {{type: revolute, parent: base, child: turned, axis: z}}
  d: {{type: prismatic, parent: turned, child: rod, axis: x}}
closures:
  pin: {{kind: planar, assembly: extended, between: {{rod: [0, {offset}, 0], p: [0, 0, 0]}}}}
active: [x, y]
end_effector: {{link: p}}
reference: {{x: {x}, y: {y}}}
"""


def rod(x: float, y: float, *, offset: float = 0.0, limits: str = "") -> Robot:
    """The rod with its reference; the point is beside the rod by an offset [m]."""
    return robot(ROD.format(x=x, y=y, offset=offset, limits=limits))


def distance_of_rod(length: float, over: float) -> float:
    """By hand, of q and d with the length of the loop: the columns stand at right angles."""
    ratio = length / over
    return 2.0 * ratio / (1.0 + ratio**2)


@pytest.mark.parametrize("reference", [(0.3, 0.4), (1.2, -0.5)])
def test_an_offset_across_a_slide_is_a_length(reference: tuple[float, float]) -> None:
    """A rod that does not pass through its pivot: only its slide's place is free."""
    machine = rod(*reference, offset=0.2)
    state = machine.close([0.6, 0.8])
    # the point is 1 m from the pivot; along the rod that is the root of 1 - 0.2^2
    along = np.sqrt(1.0 - 0.2**2)
    rows = np.array([[-0.2, 1.0], [along, 0.0]]) / 0.2
    rows[:, 1] *= 0.2
    distance = 2.0 * abs(np.linalg.det(rows)) / np.sum(rows**2)
    assert state.singularity == pytest.approx(distance, abs=1e-12)
    assert not machine.measured_at_reference


@pytest.mark.parametrize("reference", [(0.3, 0.4), (1.2, -0.5)])
def test_without_lengths_a_stroke_is_one(reference: tuple[float, float]) -> None:
    machine = rod(*reference, limits=", limits: [-1, 2]")
    state = machine.close([0.6, 0.8])
    assert state.singularity == pytest.approx(distance_of_rod(1.0, 3.0), abs=1e-12)
    assert not machine.measured_at_reference


def test_without_any_length_the_reference_is_one_and_check_says_so(tmp_path: Path) -> None:
    machine = rod(0.3, 0.4)
    state = machine.close([0.6, 0.8])
    assert state.singularity == pytest.approx(distance_of_rod(1.0, 0.5), abs=1e-12)
    assert machine.measured_at_reference
    file = tmp_path / "rod.yaml"
    file.write_text(ROD.format(x=0.3, y=0.4, offset=0.0, limits=""), encoding="utf-8")
    assert "no link of its loops has a length" in call("check", str(file)).stdout
    file.write_text(ROD.format(x=0.3, y=0.4, offset=0.2, limits=""), encoding="utf-8")
    assert "has a length" not in call("check", str(file)).stdout


# two levers, a slide on each, and a cut between the two slides, which are one cross in truth
CROSS = """\
format: 1
name: cross
links: {base: {}, A: {}, B: {}, D: {mass: 1}, E: {}}
joints:
  a: {type: revolute, parent: base, child: A, axis: z}
  s: {type: prismatic, parent: A, child: D, axis: x, origin: {xyz: [OFFSET_A, 0, 0]}}
  b: {type: revolute, parent: base, child: B, origin: {xyz: [0.3, 0.1, 0]}, axis: z}
  t: {type: prismatic, parent: B, child: E, axis: [0.6, 0.8, 0], origin: {xyz: [OFFSET_B, 0, 0]}}
closures:
  cross: {kind: frame, between: {D: {xyz: [X_D, Y, 0]}, E: {xyz: [X_E, Y, 0]}}}
active: [a]
end_effector: {link: D}
reference: {a: 0.2}
"""


def cross(offset_a: float, offset_b: float, x: float, y: float) -> Robot:
    """The cross with the zeros of its slides, and with its cut, elsewhere."""
    values = {"OFFSET_A": offset_a, "OFFSET_B": offset_b, "X_D": x - offset_a, "X_E": x - offset_b}
    text = CROSS.replace("Y,", f"{y},")
    for name, value in values.items():
        text = text.replace(name, f"{value}")
    return robot(text)


@pytest.mark.parametrize(
    "place", [(3.0, 0.0, 0.0, 0.0), (0.0, -5.0, 1.0, 2.0), (9.0, 9.0, 50.0, -70.0)]
)
def test_a_cut_between_two_slides_may_stand_anywhere(place: tuple[float, ...]) -> None:
    """By hand too: the lever b turns as a does."""
    machine = cross(*place)
    first, other = cross(0.0, 0.0, 0.0, 0.0).close([0.5], [1.0]), machine.close([0.5], [1.0])
    assert other.singularity == pytest.approx(first.singularity, rel=1e-9)
    assert other.s[machine.coordinates.index("b")] == pytest.approx(0.5, abs=1e-9)
    np.testing.assert_allclose(other.s, first.s, atol=1e-9)
    np.testing.assert_allclose(other.R, first.R, atol=1e-9)
