"""Planar loops of files with few digits: taken as planar, with a note of what was moved."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import DescriptionError, Robot, load
from hybrid_dynamics_core.description.model import RobotDescription
from hybrid_dynamics_core.ground.arrays import frozen
from tests.generated.assembly import turn
from tests.generated.reframed import random_rotation, reframed
from tests.hard_cases.linkages import robot
from tests.sampling import examples, swept

PLANAR = ("excavator", "forging_chu2020", "five_bar", "type_c", "type_d")


def tilted(description: RobotDescription, size: float, seed: int) -> RobotDescription:
    """The robot with each joint frame turned by a random angle up to a size [rad]."""
    rng = np.random.default_rng(seed)
    joints = {}
    for name, joint in description.joints.items():
        axis = random_rotation(rng)[0]
        turned = turn(axis, float(rng.uniform(0.5, 1.0)) * size)
        joints[name] = replace(joint, rotation=frozen(joint.rotation @ turned))
    return replace(description, joints=joints)


@pytest.mark.parametrize("size", [1e-9, 1e-7, 2e-5])
@pytest.mark.parametrize("name", swept(PLANAR, ("excavator", "type_c")))
def test_axes_off_by_rounding_are_turned_into_the_plane(name: str, size: float) -> None:
    exact = load(name)
    rounded = Robot(tilted(exact.description, size, 3))
    state, other = exact.close(exact.reference), rounded.close(rounded.reference)
    efforts = exact.inverse_dynamics(state, np.zeros(exact.close(exact.reference).n))
    scale = max(np.abs(efforts).max(), 1.0)
    off = rounded.inverse_dynamics(other, np.zeros(other.n)) - efforts
    # a chain of ten joints, each off by the size and with levers of some metres
    assert np.abs(off).max() < 200.0 * size * scale
    noted = [note for note in rounded.description.notes if "turned by" in note]
    assert bool(noted) == (size > 1e-8)


@pytest.mark.parametrize("name", swept(PLANAR, ("type_c",)))
def test_axes_that_are_off_by_more_are_refused_with_the_angle(name: str) -> None:
    with pytest.raises(DescriptionError, match=r"off by 0\.\d+ rad, where 0\.0001 rad") as caught:
        Robot(tilted(load(name).description, 0.02, 3))
    assert "joints turn about different axes" not in str(caught.value)


FOUR_BAR = """\
format: 1
name: printed
links:
  base: {{}}
  crank: {{mass: 1, com: [0.1, 0, 0], inertia: {{xx: 0.0001, yy: 0.0033, zz: 0.0033}}}}
  coup: {{mass: 2, com: [0.25, 0, 0], inertia: {{xx: 0.0001, yy: 0.04, zz: 0.04}}}}
  rock: {{mass: 1.5, com: [0.2, 0, 0], inertia: {{xx: 0.0001, yy: 0.02, zz: 0.02}}}}
joints:
  a: {{type: revolute, parent: base, child: crank, origin: {{rpy: [pi/2, 0, 0]}}, axis: z}}
  b: {{type: revolute, parent: crank, child: coup, origin: {{xyz: [0.2, 0, 0]}}, axis: z}}
  c: {{type: revolute, parent: base, child: rock,
      origin: {{xyz: [0.45, 0, 0], rpy: [{roll}, 0, 0]}}, axis: z}}
closures: {{c0: {{kind: {kind}, between: {{coup: [0.5, 0, 0], rock: [0.4, 0, {apart}]}}}}}}
active: [a]
end_effector: {{link: rock}}
reference: {{a: 1.0, b: -0.6, c: 1.4}}
"""


@pytest.mark.parametrize("kind", ["planar", "axis"])
@pytest.mark.parametrize("roll", ["1.5708", "1.57079633", "1.5707963277948966"])
def test_a_four_bar_holds_what_the_exact_one_holds(roll: str, kind: str) -> None:
    """By hand: 1.643609 N m at a = 1.2."""
    machine = robot(FOUR_BAR.format(roll=roll, kind=kind, apart=0))
    torque = machine.inverse_dynamics(machine.close([1.2]), [0.0])
    assert torque[0] == pytest.approx(1.643609, abs=1e-6)


def test_the_note_says_where_and_by_how_much() -> None:
    (note,) = robot(FOUR_BAR.format(roll="1.5708", kind="planar", apart=0)).description.notes
    assert note == (
        "linkage.yaml:12: joints.c.origin: turned by 3.7e-06 rad, into the plane of loop 'c0'"
    )


def test_ends_a_little_apart_along_the_axis_are_put_together() -> None:
    machine = robot(FOUR_BAR.format(roll="pi/2", kind="planar", apart="2e-5"))
    (note,) = machine.description.notes
    assert note == "linkage.yaml:13: closures.c0: moved by 2e-05 m along its axis"
    with pytest.raises(DescriptionError, match=r"ends are 0\.001 m apart along the loop's axis"):
        robot(FOUR_BAR.format(roll="pi/2", kind="planar", apart="0.001"))


PARALLELOGRAM = """\
format: 1
name: rounded
gravity: [0, -9.81, 0]
links: {{base: {{}}, p: {{mass: 1, com: [0.2, 0, 0]}}, q: {{mass: 2, com: [0.5, 0, 0]}},
  r: {{mass: 1, com: [0.2, 0, 0]}}}}
joints:
  jp: {{type: revolute, parent: base, child: p, axis: z}}
  jq: {{type: revolute, parent: p, child: q, axis: z, origin: {{xyz: [{crank}, 0, 0]}}}}
  jr: {{type: revolute, parent: base, child: r, axis: z, origin: {{xyz: [{ground}, 0, 0]}}}}
closures:
  shut: {{kind: planar, between: {{q: [{coupler}, 0, 0], r: [{rocker}, 0, 0]}},
    assembly: parallelogram}}
active: [jp]
end_effector: {{link: q}}
reference: {{jp: 0.7}}
"""


@examples(30)
@given(
    off=st.tuples(*[st.floats(-4e-6, 4e-6)] * 4),
    frames=st.integers(0, 10**6),
)
def test_bars_that_differ_by_rounding_make_a_parallelogram(
    off: tuple[float, ...], frames: int
) -> None:
    names = ("crank", "ground", "coupler", "rocker")
    lengths = dict(zip(names, np.add((0.4, 1.0, 1.0, 0.4), off), strict=True))
    machine = robot(PARALLELOGRAM.format(**lengths))
    description, zeros = reframed(machine.description, frames)
    for one, shift in ((machine, 0.0), (Robot(description), zeros["jp"])):
        torque = one.inverse_dynamics(one.close([0.7 - shift]), [0.0])[0]
        # by hand, the bars off by rounding
        assert torque == pytest.approx(9.81 * np.cos(0.7) * (0.2 + 2 * 0.4 + 0.2), rel=1e-4)
    gap = max(abs(off[0] - off[3]), abs(off[1] - off[2]))
    noted = any("opposite bars differ by" in note for note in machine.description.notes)
    assert noted == (gap > 1e-8) or gap < 1.1e-8


def test_bars_that_differ_by_more_are_refused() -> None:
    text = PARALLELOGRAM.format(crank=0.4, ground=1.0, coupler=1.0, rocker=0.41)
    with pytest.raises(DescriptionError, match=r"opposite bars are 0\.4 m and 0\.41 m long"):
        robot(text)


DOUBLE = """\
format: 1
name: double
links:
  base: {{}}
  crank: {{mass: 1.0, com: [0.2, 0, 0], inertia: {{xx: 0.01, yy: 0.01, zz: 0.01}}}}
  plate: {{mass: 1.0, com: [0.1, 0, 0], inertia: {{xx: 0.01, yy: 0.01, zz: 0.01}}}}
  left: {{mass: 1.0, com: [0.2, 0, 0], inertia: {{xx: 0.01, yy: 0.01, zz: 0.01}}}}
  right: {{mass: 1.0, com: [0.2, 0, 0], inertia: {{xx: 0.01, yy: 0.01, zz: 0.01}}}}
gravity: [0, -9.81, 0]
joints:
  jc: {{type: revolute, parent: base, child: crank, axis: z}}
  jp: {{type: revolute, parent: crank, child: plate, axis: z, origin: {{xyz: [0.4, 0, 0]}}}}
  jl: {{type: revolute, parent: base, child: left, axis: z, origin: {{xyz: [0, 0.3, 0]}}}}
  jr: {{type: revolute, parent: base, child: right, axis: z, origin: {{xyz: [0, -0.3, 0]}}}}
closures:
  one: {{kind: point, between: {{plate: [0, 0.3, 0], left: [{left}, 0, 0]}}}}
  other: {{kind: point, between: {{plate: [0, -0.3, 0], right: [{right}, 0, 0]}}}}
active: [jc]
end_effector: {{link: plate}}
reference: {{jc: 0.5, jp: -0.5, jl: 0.5, jr: 0.5}}
"""


@examples(10)
@given(off=st.tuples(*[st.floats(-2e-4, 2e-4)] * 2))
def test_a_second_rod_beside_a_parallelogram_moves_when_it_is_drawn_a_little_off(
    off: tuple[float, float],
) -> None:
    left, right = 0.4 + np.array(off)
    machine = robot(DOUBLE.format(left=left, right=right))
    torque = machine.inverse_dynamics(machine.close([0.7]), [0.0])[0]
    # by hand: three bars, and the plate at the crank's end, whose angle stays
    by_hand = 9.81 * np.cos(0.7) * (3 * 0.2 + 0.4)
    assert torque == pytest.approx(by_hand, rel=1e-3)
    moved = [note for note in machine.description.notes if "opposite bars differ by" in note]
    assert len(moved) == sum(abs(one) > 1e-8 for one in off) or min(map(abs, off)) < 1.1e-8


@pytest.mark.parametrize("off", [2e-3, 2e-2])
def test_a_second_rod_that_is_longer_holds_the_parallelogram_fast(off: float) -> None:
    with pytest.raises(DescriptionError, match=r"does not close|over-determined"):
        robot(DOUBLE.format(left=0.4, right=0.4 + off))


def test_a_parallelogram_that_moves_as_it_is_drawn_keeps_its_bars() -> None:
    lines = DOUBLE.replace(", jr: 0.5", "").splitlines()
    alone = [line for line in lines if not line.startswith(("  right:", "  jr:", "  other:"))]
    machine = robot("\n".join(alone).format(left=0.4003))
    assert not any("opposite bars" in note for note in machine.description.notes)
    assert machine.close([0.7]).s[1] != pytest.approx(-0.7, abs=1e-6)
