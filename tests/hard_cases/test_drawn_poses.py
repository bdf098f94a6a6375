"""Files that draw a mechanism where it is singular, or where no loop closes near by."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hybrid_dynamics_core import Robot, SingularityError, load
from hybrid_dynamics_core.closure.constraints.from_description import loop_equations
from hybrid_dynamics_core.closure.numeric_closure import gaps_and_jacobian
from hybrid_dynamics_core.closure.reference_search import _singular_values, closed_near
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.mechanism.tree import build_tree
from tests.generated.reframed import reframed
from tests.hard_cases.linkages import four_bar, robot
from tests.sampling import examples

GRAVITY = 9.81

FLAT = """\
format: 1
name: flat
gravity: [0, -9.81, 0]
links:
  base: {{}}
  p: {{mass: {mp}, com: [{cp}, 0, 0]}}
  q: {{mass: {mq}, com: [{cq}, 0, 0]}}
  r: {{mass: {mr}, com: [{cr}, 0, 0]}}
joints:
  jp: {{type: revolute, parent: base, child: p, axis: z}}
  jq: {{type: revolute, parent: p, child: q, axis: z, origin: {{xyz: [{crank}, 0, 0]}}}}
  jr: {{type: revolute, parent: base, child: r, axis: z, origin: {{xyz: [{ground}, 0, 0]}}}}
closures: {{shut: {{kind: {kind}, between: {{q: [{ground}, 0, 0], r: [{crank}, 0, 0]}}}}}}
active: [jp]
{how}
end_effector: {{link: q}}
"""
SIZE = st.floats(0.1, 2.0)

STRETCHED = """\
format: 1
name: stretched
links: {base: {}, sledge: {}, table: {}, plate: {mass: 1},
  u0: {}, l0: {}, u1: {}, l1: {}, u2: {}, l2: {}}
joints:
  x: {type: prismatic, parent: base, child: sledge, axis: x}
  y: {type: prismatic, parent: sledge, child: table, axis: y}
  turn: {type: revolute, parent: table, child: plate, axis: z}
  a0: {type: revolute, parent: base, child: u0, axis: z,
    origin: {xyz: [cos(0*2*pi/3), sin(0*2*pi/3), 0], rpy: [0, 0, 0*2*pi/3 + pi]}}
  b0: {type: revolute, parent: u0, child: l0, axis: z, origin: {xyz: [0.45, 0, 0]}}
  a1: {type: revolute, parent: base, child: u1, axis: z,
    origin: {xyz: [cos(1*2*pi/3), sin(1*2*pi/3), 0], rpy: [0, 0, 1*2*pi/3 + pi]}}
  b1: {type: revolute, parent: u1, child: l1, axis: z, origin: {xyz: [0.45, 0, 0]}}
  a2: {type: revolute, parent: base, child: u2, axis: z,
    origin: {xyz: [cos(2*2*pi/3), sin(2*2*pi/3), 0], rpy: [0, 0, 2*2*pi/3 + pi]}}
  b2: {type: revolute, parent: u2, child: l2, axis: z, origin: {xyz: [0.45, 0, 0]}}
closures:
  k0: {kind: planar, between: {l0: [0.45, 0, 0],
    plate: [0.1*cos(0*2*pi/3), 0.1*sin(0*2*pi/3), 0]}}
  k1: {kind: planar, between: {l1: [0.45, 0, 0],
    plate: [0.1*cos(1*2*pi/3), 0.1*sin(1*2*pi/3), 0]}}
  k2: {kind: planar, between: {l2: [0.45, 0, 0],
    plate: [0.1*cos(2*2*pi/3), 0.1*sin(2*2*pi/3), 0]}}
active: [a0, a1, a2]
end_effector: {link: plate}
"""


@examples(60)
@given(
    crank=SIZE,
    ground=SIZE,
    masses=st.tuples(SIZE, SIZE, SIZE),
    coms=st.tuples(SIZE, SIZE, SIZE),
    u=st.floats(-3.0, 3.0),
    kind=st.sampled_from(["planar", "axis", "point"]),
    how=st.sampled_from(["active_set: motors", "active_set: exact"]),
    frames=st.integers(0, 10**6),
)
def test_a_parallelogram_drawn_flat_is_one(
    crank: float,
    ground: float,
    masses: tuple[float, float, float],
    coms: tuple[float, float, float],
    u: float,
    kind: str,
    how: str,
    frames: int,
) -> None:
    """By hand: p and r turn with jp, q is carried along."""
    (mp, mq, mr), (cp, cq, cr) = masses, coms
    names = ("mp", "mq", "mr", "cp", "cq", "cr", "crank", "ground", "kind", "how")
    values = (mp, mq, mr, cp, cq, cr, crank, ground, kind, how)
    text = FLAT.format(**dict(zip(names, values, strict=True)))
    machine = Robot(parse_description(text, file="flat.yaml"))
    shift = 0.0
    if frames % 2:  # the same in other words
        description, zeros = reframed(machine.description, frames)
        machine, shift = Robot(description), zeros["jp"]
    state = machine.close([u - shift], near=machine.close(machine.reference))
    expected = GRAVITY * np.cos(u) * (mp * cp + mq * crank + mr * cr)
    torque = machine.inverse_dynamics(state, [0.0])[0]
    assert torque == pytest.approx(expected, abs=1e-9 * (1.0 + abs(expected)))
    assert any("taken as a parallelogram" in note for note in machine.description.notes)


SLIDER = """\
format: 1
name: dead_centre
links: {{base: {{}}, crank: {{mass: 1}}, rod: {{mass: 1}}, ram: {{mass: 1}}}}
joints:
  a: {{type: revolute, parent: base, child: crank, axis: z}}
  b: {{type: revolute, parent: crank, child: rod, axis: z, origin: {{xyz: [{crank}, 0, 0]}}}}
  x: {{type: prismatic, parent: base, child: ram, axis: x, origin: {{xyz: [{sum}, 0, 0]}}}}
closures: {{cl: {{kind: planar, between: {{rod: [{rod}, 0, 0], ram: [0, 0, 0]}}}}}}
active: [x]
active_set: motors
end_effector: {{link: ram}}
"""


@examples(20)
@given(crank=st.floats(0.05, 1.0), more=st.floats(0.05, 1.0))
def test_a_slider_crank_drawn_at_its_dead_centre_moves(crank: float, more: float) -> None:
    rod = crank + more
    text = SLIDER.format(crank=crank, rod=rod, sum=crank + rod)
    machine = Robot(parse_description(text, file="dead.yaml"))
    assert machine.active == ("x",)
    assert any("at a change point" in note for note in machine.description.notes)
    a, x = (machine.coordinates.index(name) for name in "ax")
    for share in (0.05, 0.3, 0.7):
        state = machine.close([-2.0 * crank * share])
        pin = crank * np.array([np.cos(state.s[a]), np.sin(state.s[a])])
        tip = np.array([crank + rod + state.s[x], 0.0])
        assert np.linalg.norm(tip - pin) == pytest.approx(rod, abs=1e-12)


PINNED = """\
format: 1
name: pinned
base: world
links: {{world: {{}}, a: {{}}, b: {{}}, c: {{}}, d: {{}}, e: {{}}, ball: {{mass: 1}}}}
joints:
  x: {{type: prismatic, parent: world, child: a, axis: x}}
  y: {{type: prismatic, parent: a, child: b, axis: y}}
  z: {{type: prismatic, parent: b, child: c, axis: z}}
  rx: {{type: revolute, parent: c, child: d, axis: x}}
  ry: {{type: revolute, parent: d, child: e, axis: y}}
  rz: {{type: revolute, parent: e, child: ball, axis: z}}
closures:
  pin: {{kind: point, between: {{world: [0, 0, {at}], ball: [0, 0, {at}]}}}}
active: [x, y, z, rx, ry, rz]
active_set: motors
end_effector: {{link: ball}}
"""


@pytest.mark.parametrize("at", [0.0, 0.4])
def test_a_body_pinned_at_its_own_origin_has_three_freedoms(at: float) -> None:
    machine = Robot(parse_description(PINNED.format(at=at), file="pinned.yaml"))
    assert len(machine.active) == 3
    assert len(machine.dependent_motors) == 3
    state = machine.close([0.1, 0.2, -0.1])
    assert state.residual < 1e-12


@examples(20)
@given(
    off=st.floats(-2e-5, 2e-5),
    how=st.sampled_from(["active_set: motors", "active_set: exact"]),
    u=st.floats(-2.0, 2.0),
)
def test_a_flat_parallelogram_with_rounded_bars_is_one(off: float, how: str, u: float) -> None:
    names = ("mp", "mq", "mr", "cp", "cq", "cr", "crank", "ground", "kind", "how")
    values = (1, 2, 1, 0.2, 0.5, 0.2, 0.4, 1.0, "planar", how)
    text = FLAT.format(**dict(zip(names, values, strict=True)))
    text = text.replace(
        "child: r, axis: z, origin: {xyz: [1.0,", f"child: r, axis: z, origin: {{xyz: [{1.0 + off},"
    )
    machine = Robot(parse_description(text, file="flat.yaml"))
    torque = machine.inverse_dynamics(machine.close([u]), [0.0])[0]
    expected = GRAVITY * np.cos(u) * (0.2 + 2 * 0.4 + 0.2)
    assert torque == pytest.approx(expected, abs=1e-3)  # bars are off by some 1e-5 m


OPEN = """\
format: 1
name: open
links: {base: {}, a: {mass: 1}, b: {mass: 1}, c: {mass: 1}}
joints:
  qa: {type: revolute, parent: base, child: a, axis: y}
  qb: {type: revolute, parent: a, child: b, axis: y, origin: {xyz: [0.2, 0, 0]}}
  qc: {type: revolute, parent: base, child: c, axis: y, origin: {xyz: [0.45, 0, 0]}}
closures: {l: {kind: planar, between: {b: [0.5, 0, 0], c: [0.4, 0, 0]}}}
active: [qa, qb, qc]
active_set: motors
end_effector: {link: b}
"""


@pytest.mark.parametrize("size", ["", "e-6", "e+6"])
def test_what_is_drawn_open_closes_with_the_first_joint_where_it_is(size: str) -> None:
    """A triangle of 0.25, 0.5 and 0.4 m beside the crank, and a note of it; in micrometres too."""
    text = re.sub(r"(0\.\d+)", rf"\g<1>{size}", OPEN)
    machine = Robot(parse_description(text, file="open.yaml"))
    assert machine.active == ("qa",)
    assert machine.reference[0] == pytest.approx(0.0, abs=1e-12)
    assert any("open as the file draws them" in note for note in machine.description.notes)
    qb = machine.close([0.0]).z[0]
    assert np.cos(qb) == pytest.approx((0.25**2 + 0.5**2 - 0.4**2) / (2 * 0.25 * 0.5), abs=1e-9)


@pytest.mark.parametrize(
    ("lower", "upper"), [(-0.05, 2.0), (-2.0, 0.05), (-0.05, 0.7), (-0.7, 0.05)]
)
@pytest.mark.parametrize("start", [(0.0, 0.1, 0.1), (0.0, -0.1, -0.1)])
def test_of_two_ways_to_close_the_one_that_limits_allow_best_is_taken(
    lower: float, upper: float, start: tuple[float, float, float]
) -> None:
    """It closes at qb = 0.915 and -0.915, both beyond the narrower limits."""
    limited = OPEN.replace("child: b, axis: y,", f"child: b, axis: y, limits: [{lower}, {upper}],")
    description = parse_description(limited, file="limited.yaml")
    tree = build_tree(description)
    loops = loop_equations(tree, description, frozenset(range(3)))
    closed = closed_near(tree, loops, start, [1, 2], driven_may_move=False)
    assert closed.is_closed
    qb = 0.91473574 if upper > -lower else -0.91473574
    assert closed.s[1] == pytest.approx(qb, abs=1e-6)


UPRIGHT = """\
format: 1
name: upright
links: {base: {}, a: {mass: 1}, b: {mass: 1}, c: {mass: 1}}
joints:
  qa: {type: revolute, parent: base, child: a, axis: y, origin: {rpy: [0, -pi/2, 0]}}
  qb: {type: revolute, parent: a, child: b, axis: y, origin: {xyz: [0.2, 0, 0], rpy: [0, pi/2, 0]}}
  qc: {type: revolute, parent: base, child: c, axis: y,
    origin: {xyz: [0.3, 0, 0], rpy: [0, -pi/2, 0]}}
closures: {c1: {kind: planar, between: {b: [0.3, 0, 0], c: [0.2, 0, 0]}}}
active: [qa]
end_effector: {link: b}
reference: {qa: 0, qb: 0, qc: 0}
"""


def test_a_change_point_ends_no_range() -> None:
    """The loop closes on both sides of it."""
    machine = Robot(parse_description(UPRIGHT, file="upright.yaml"))
    assert not np.isfinite(machine.closing_range).any()


@pytest.mark.parametrize("name", ["five_bar", "ankle"])
def test_a_move_off_a_singular_place_is_as_large_as_it_says(name: str) -> None:
    robot = load(name)
    tree = build_tree(robot.description)
    loops = loop_equations(tree, robot.description, frozenset(range(len(robot.coordinates))))
    s = robot.close(robot.reference).s
    sizes, motion = _singular_values(tree, loops, s)
    _, jacobian = gaps_and_jacobian(tree, loops, s, range(len(s)))
    assert sizes[0] == pytest.approx(1.0, rel=1e-12)
    assert np.abs(motion).max() == pytest.approx(1.0, rel=1e-12)
    assert jacobian @ motion == pytest.approx(0.0, abs=1e-9)


@examples(40)
@given(
    lengths=st.tuples(SIZE, SIZE, st.floats(0.1, 0.9)),
    mode=st.sampled_from(["counterclockwise", "clockwise"]),
    frames=st.integers(0, 10**6),
)
def test_a_named_mode_drawn_at_its_change_point_begins_beside_it(
    lengths: tuple[float, float, float], mode: str, frames: int
) -> None:
    """Crank and coupler are as long as ground and rocker, all drawn in a line."""
    crank, coupler, share = lengths
    rocker = share * (crank + coupler)
    ground = crank + coupler - rocker
    assume(min(abs(crank - ground), abs(crank - rocker)) > 0.05)
    drawn = parse_description(four_bar(ground, crank, coupler, rocker, mode))
    machine = Robot(replace(drawn, reference={}))
    assert any("at a change point" in note for note in machine.description.notes)
    state = machine.close(machine.reference)
    assert state.singularity > 1e-4  # some 0.01 rad beside it
    assert state.branch["bar"] == mode
    q1, _, q3 = (state.s[machine.coordinates.index(name)] for name in ("q1", "q2", "q3"))
    elbow = crank * np.exp(1j * q1)
    pin = ground + rocker * np.exp(1j * q3)
    assert abs(pin - elbow) == pytest.approx(coupler, abs=1e-9)
    sense = np.imag(np.conj(ground - elbow) * (pin - elbow))
    assert (sense > 0.0) == (mode == "counterclockwise")
    other = Robot(reframed(replace(drawn, reference={}), frames, farthest=0.0)[0])
    assert other.close(other.reference).singularity > 1e-4
    again = other.close(machine.reference)
    np.testing.assert_allclose(again.s, state.s, atol=1e-9 / state.singularity)


def test_a_pose_in_which_nothing_moves_has_no_reference_beside_it() -> None:
    """Three stretched legs pull a plate three ways."""
    machine = robot(STRETCHED)
    assert not any("change point" in note for note in machine.description.notes)
    with pytest.raises(SingularityError):
        machine.close(machine.reference)
