"""What nobody drives: idle coordinates, and those among them that move no mass."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hybrid_dynamics_core import ClosedState, DescriptionError, MassSingularityError, Robot
from hybrid_dynamics_core.description.effects import JointEffect
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.mechanism.configuration import configuration_at
from hybrid_dynamics_core.mechanism.total_inertia import total_inertia
from hybrid_dynamics_core.mechanism.tree import build_tree
from hybrid_dynamics_core.simulation import simulate
from tests.generated.case import Case
from tests.generated.robots import examples, robots
from tests.spinning import TINY, Spinning, far_away, reframed, spinning

SEEDS = st.integers(0, 1000)
FAR = 5e5  # [m]


def built(linkage: Spinning, spin_inertia: float = 0.0) -> Robot:
    """The robot; linkages that stand near a toggle point are passed over."""
    try:
        robot = linkage.robot(spin_inertia)
    except DescriptionError:
        robot = None
    assume(robot is not None)
    state = robot.close(robot.reference, check=False)
    assume(state.status == 0 and state.singularity > 0.1)
    return robot


def in_motion(robot: Robot, seed: int) -> ClosedState:
    """The reference, in motion."""
    rates = np.random.default_rng(seed).uniform(-1.0, 1.0, len(robot.active))
    return robot.close(robot.reference, rates)


def efforts(robot: Robot, seed: int) -> np.ndarray:
    """An effort of the motor, and none along idle coordinates."""
    tau = np.zeros(len(robot.active))
    tau[0] = np.random.default_rng(seed).uniform(-20.0, 20.0)
    return tau


def spins_of(linkage: Spinning, robot: Robot) -> list[int]:
    """Idle coordinates that are joints of a rod, by their place in u."""
    return [k for k, name in enumerate(robot.active) if name in linkage.spins]


def assert_close(ours: np.ndarray, theirs: np.ndarray, bound: float) -> None:
    """Relative to the largest."""
    assert np.abs(ours - theirs).max() < bound * max(1.0, np.abs(theirs).max())


@examples(12)
@given(spinning(), SEEDS)
def test_a_spin_without_mass_is_left_out(linkage: Spinning, seed: int) -> None:
    """All else accelerates as with a tiny inertia about the rods, of which nothing is left out."""
    robot, other = built(linkage), built(linkage, TINY)
    assert robot.drives == ("a",)
    assert other.active == robot.active
    spins = spins_of(linkage, robot)
    assert len(spins) == linkage.rods
    state, tau = in_motion(robot, seed), efforts(robot, seed)
    ddu = robot.forward_dynamics(state, tau)
    assert (ddu[spins] == 0.0).all()
    expected = other.forward_dynamics(in_motion(other, seed), tau)
    others = [k for k in range(len(tau)) if k not in spins]
    assert_close(ddu[others], expected[others], 1e-5)
    assert_close(robot.inverse_dynamics(state, ddu), tau, 1e-9)


@examples(4)
@given(spinning(), SEEDS)
def test_so_do_derivatives(linkage: Spinning, seed: int) -> None:
    robot, other = built(linkage), built(linkage, TINY)
    state, tau = in_motion(robot, seed), efforts(robot, seed)
    spins = spins_of(linkage, robot)
    others = [k for k in range(len(tau)) if k not in spins]
    slopes = robot.forward_dynamics_derivatives(state, tau)
    expected_slopes = other.forward_dynamics_derivatives(in_motion(other, seed), tau)
    for ours, theirs in zip(slopes, expected_slopes, strict=True):
        assert (ours[spins] == 0.0).all()
        assert_close(ours[np.ix_(others, others)], theirs[np.ix_(others, others)], 1e-4)


@examples(6)
@given(spinning(), SEEDS)
def test_batches_compiled_calls_and_simulations_leave_it_out_alike(
    linkage: Spinning, seed: int
) -> None:
    robot = built(linkage)
    state, tau = in_motion(robot, seed), efforts(robot, seed)
    ddu = robot.forward_dynamics(state, tau)
    batch = robot.close([state.u, state.u], [state.du, 0.0 * state.du])
    rows = robot.forward_dynamics(batch, [tau, tau])
    assert_close(rows[0], ddu, 1e-12)
    assert_close(robot.kernels.forward_dynamics(state.u, state.du, tau), ddu, 1e-12)
    motion = simulate(robot, state.u, 0.2 * state.du, t_span=(0.0, 0.05))
    spins = spins_of(linkage, robot)
    assert np.ptp(motion.state.du[:, spins], axis=0).max() < 1e-9
    total = motion.energy.total
    assert np.ptp(total) < 1e-6 * max(1.0, np.abs(total).max())


@examples(8)
@given(spinning(), SEEDS, st.sampled_from(["tau", "spring", "friction"]))
def test_a_force_along_a_spin_without_mass_is_refused(
    linkage: Spinning, seed: int, kind: str
) -> None:
    """It would make the spin infinitely fast."""
    description = linkage.description()
    robot = built(linkage)
    k = spins_of(linkage, robot)[0]
    name = robot.active[k]
    effects = {"spring": JointEffect(stiffness=2.0, rest=1.0), "friction": JointEffect(viscous=0.1)}
    if kind in effects:
        robot = Robot(replace(description, effects={name: effects[kind]}))
    tau = np.zeros(len(robot.active))
    tau[k] = 0.3 * (kind == "tau")
    with pytest.raises(MassSingularityError, match=name):
        robot.forward_dynamics(in_motion(robot, seed), tau)


SHARED_MASS = """
format: 1
name: shared
active_set: motors
gravity: [0, 0, 0]
links: {base: {}, a: {}, b: {mass: 2}}
joints:
  p: {type: prismatic, parent: base, child: a, axis: x}
  q: {type: prismatic, parent: a, child: b, axis: x}
active: [p]
end_effector: {link: b}
"""


def test_an_idle_coordinate_that_takes_the_motor_along_is_not_left_out() -> None:
    """The mass stands still where the two slides move against each other: p'' is not determined."""
    robot = Robot(parse_description(SHARED_MASS))
    assert robot.idle == ("q",)
    with pytest.raises(MassSingularityError, match=r"p .*q"):
        robot.forward_dynamics(robot.close([0.0, 0.0]), [0.0, 0.0])


@examples(6)
@given(spinning(), SEEDS)
def test_what_moves_no_mass_depends_on_no_frame(linkage: Spinning, seed: int) -> None:
    robot = built(linkage)
    tau = efforts(robot, seed)
    ddu = robot.forward_dynamics(in_motion(robot, seed), tau)
    for description in (
        reframed(robot.description, seed),
        far_away(robot.description, seed, FAR),
    ):
        other = Robot(description)
        assert other.active == robot.active
        # so far away a place is known to 1e-10 m
        assert_close(other.forward_dynamics(in_motion(other, seed), tau), ddu, 1e-5)


@examples(30)
@given(robots(), SEEDS)
def test_scales_of_inertia_belong_to_the_mechanism(case: Case, seed: int) -> None:
    sizes: list[float] = []
    for description in (
        case.description,
        reframed(case.description, seed),
        far_away(case.description, seed, FAR),
    ):
        tree = build_tree(description)
        s = [description.reference[name] for name in tree.coordinates]
        sizes.append(total_inertia(tree, configuration_at(tree, s)))
    assert sizes[0] > 0.0
    assert sizes[1] == pytest.approx(sizes[0], rel=1e-9)
    assert sizes[2] == pytest.approx(sizes[0], rel=1e-7)  # places so far away have 10 digits left


ROD = """
format: 1
name: rod_idle
active_set: motors
links:
  base: {}
  crank: {mass: 1, com: [0.08, 0, 0], inertia: {rod: {axis: x, length: 0.16}}}
  s1: {}
  s2: {}
  rod: {mass: 1, com: [0.25, 0, 0], inertia: {xx: SPIN, yy: 1/48, zz: 1/48}}
  rock: {mass: 1, com: [0, 0, 0.18], inertia: {rod: {axis: z, length: 0.36}}}
joints:
  a: {type: revolute, parent: base, child: crank, origin: {rpy: [pi/2, 0, 0]}, axis: z}
  u: {type: revolute, parent: crank, child: s1, origin: {xyz: [0.16, 0, 0]}, axis: z}
  v: {type: revolute, parent: s1, child: s2, axis: y}
  w: {type: revolute, parent: s2, child: rod, axis: x}
  c: {type: revolute, parent: base, child: rock, origin: {xyz: [0.42, 0.25, 0]}, axis: y}
closures:
  p: {kind: point, between: {rod: [0.5, 0, 0], rock: [0, 0, 0.36]}}
active: [a]
end_effector: {link: rock}
reference: {a: 1.0, u: -0.5, v: -0.3, c: 0.1}
"""


@pytest.mark.parametrize("inertia", ["0", "1e-8", "1e-6"])
def test_rod_between_two_balls(inertia: str) -> None:
    robot = Robot(parse_description(ROD.replace("SPIN", inertia)))
    assert (robot.active, robot.idle, robot.drives) == (("a", "w"), ("w",), ("a",))
    state = robot.close(robot.reference)
    ddu = robot.forward_dynamics(state, np.zeros(2))
    # the same robot without w, by hand and by MuJoCo
    assert ddu[0] == pytest.approx(-35.3839, abs=1e-3 if float(inertia) > 1e-7 else 5e-5)


FOUR_BAR = """
format: 1
name: four_bar
links:
  base: {}
  crank: {mass: 1, com: [0.1, 0, 0], inertia: {xx: 4e-6, yy: 1/300, zz: 1/300}}
  coup: {mass: 2, com: [0.25, 0, 0], inertia: {xx: 5e-5, yy: 1/24, zz: 1/24}}
  rock: {mass: 1.5, com: [0.2, 0, 0], inertia: {xx: 2.4e-5, yy: 0.02, zz: 0.02}}
joints:
  a: {type: revolute, parent: base, child: crank, axis: z,
      origin: {xyz: [X, Y, Z], rpy: [pi/2, 0, 0]}}
  b: {type: revolute, parent: crank, child: coup, axis: z, origin: {xyz: [0.2, 0, 0]}}
  c: {type: revolute, parent: base, child: rock, axis: z,
      origin: {xyz: [X + 0.45, Y, Z], rpy: [pi/2, 0, 0]}}
closures:
  c0: {kind: planar, between: {coup: [0.5, 0, 0], rock: [0.4, 0, 0]}}
active: [a]
end_effector: {link: rock}
reference: {a: 1.0, b: -0.6, c: 1.4}
"""


@pytest.mark.parametrize("place", [(0, 0, 0), (31250, 500000, 120)])
def test_a_base_in_map_coordinates(place: tuple[int, int, int]) -> None:
    text = FOUR_BAR
    for letter, value in zip("XYZ", place, strict=True):
        text = text.replace(f"{letter},", f"{value},").replace(f"{letter} ", f"{value} ")
        text = text.replace(f"{letter}]", f"{value}]")
    robot = Robot(parse_description(text))
    ddu = robot.forward_dynamics(robot.close([1.0]), [0.0])
    assert ddu == pytest.approx(-27.8004, abs=1e-4)


def test_an_idle_coordinate_with_an_inertia_that_no_body_has_is_not_left_out() -> None:
    robot = Robot(parse_description(ROD.replace("SPIN", "0")))
    rod = robot.description.links["rod"]
    wrong = replace(rod, inertia=np.diag([-0.01, 1 / 48, 1 / 48]))
    other = Robot(replace(robot.description, links={**robot.description.links, "rod": wrong}))
    with pytest.raises(MassSingularityError, match="not positive definite"):
        other.forward_dynamics(other.close(other.reference), np.zeros(2))
