"""Passive joints that are followed go round without a jump; without a history they do not."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hybrid_dynamics_core import Robot
from hybrid_dynamics_core.formats.reader import parse_description
from hybrid_dynamics_core.simulation import simulate
from tests.mechanisms import mechanism
from tests.sampling import examples
from tests.turning import Turning, turning_linkages

SEEDS = st.integers(0, 50)
TURNS = 3
CLOSED = 1e-9  # rounding, times what a linkage near its toggle points makes of it


def motion(linkage: Turning, way: float = 1.0) -> np.ndarray:
    """Crank angles (N, 1) over some turns."""
    return linkage.start + way * np.linspace(0.0, 2.0 * np.pi * TURNS, 400)[:, None]


@examples(60)
@given(turning_linkages(), SEEDS, st.sampled_from([1.0, -1.0]))
def test_a_path_is_that_of_the_circles_turn_after_turn(
    linkage: Turning, seed: int, way: float
) -> None:
    robot = linkage.robot(seed)
    u = motion(linkage, way)
    state = robot.close_path(u)
    order = [robot.coordinates.index(name) for name in "bcg"]
    expected = linkage.passive(u[:, 0], state.s[0, order[0]])
    expected[:, 1] += state.s[0, order[1]] - expected[0, 1]  # the turn it begins with
    np.testing.assert_allclose(state.s[:, order], expected, atol=CLOSED)
    reference = robot.close(robot.reference).s
    for name, turns in state.turns.items():
        k = robot.coordinates.index(name)
        off = state.s[:, k] - reference[k] - 2.0 * np.pi * np.asarray(turns)
        assert np.abs(off).max() <= np.pi + CLOSED


@examples(60)
@given(turning_linkages(), SEEDS)
def test_springs_see_the_turns(linkage: Turning, seed: int) -> None:
    robot = linkage.robot(seed)
    u = motion(linkage)
    path = robot.close_path(u)
    torque = robot.inverse_dynamics(path, np.zeros_like(u))[:, 0]
    expected = linkage.torque(u[:, 0], path.s[0, robot.coordinates.index("b")])
    scale = 1.0 + np.abs(expected).max()
    # central differences: 1e-10 of the scale of the third derivative
    np.testing.assert_allclose(torque, expected, atol=1e-6 * scale)


@examples(30)
@given(turning_linkages(), SEEDS)
def test_steps_batches_and_compiled_calls_follow_alike(linkage: Turning, seed: int) -> None:
    robot = linkage.robot(seed)
    u = motion(linkage)
    path = robot.close_path(u)
    before, here = path.rows(slice(None, -1)), path.rows(slice(1, None))
    batch = robot.close(here.u, near=before)
    np.testing.assert_allclose(batch.s, here.s, atol=CLOSED)
    still = np.zeros_like(here.u)
    efforts = robot.kernels.inverse_dynamics(here.u, still, still, guess=before.s)
    np.testing.assert_allclose(efforts, robot.inverse_dynamics(here, still), atol=1e-8)
    one_by_one = robot.follow_turns(robot.close(u), path.s[0])
    np.testing.assert_allclose(one_by_one.s, path.s, atol=CLOSED)
    far = robot.close(u[-1], near=path.rows(0))
    np.testing.assert_allclose(far.s, path.s[-1], atol=CLOSED)


TRAIN = """
format: 1
name: train
links:
  base: {{}}
  crank: {{}}
  coupler: {{}}
  follower: {{}}
  disc: {{mass: 1, com: [0.1, 0, 0]}}
  rod: {{mass: 1, com: [0.2, 0, 0]}}
  rocker: {{mass: 1, com: [0.1, 0, 0]}}
  wheel: {{mass: 1, com: [0.1, 0, 0]}}
joints:
  a: {{type: revolute, parent: base, child: crank, axis: z}}
  b: {{type: revolute, parent: crank, child: coupler, axis: z, origin: {{xyz: [0.4, 0, 0]}}}}
  c: {{type: revolute, parent: base, child: follower, axis: z, origin: {{xyz: [0.1, 0, 0]}}}}
  d: {{type: revolute, parent: base, child: disc, axis: z, origin: {{xyz: [2, 0, 0]}},
    mimic: {{joint: c, multiplier: {ratio}, offset: {offset}}}}}
  e: {{type: revolute, parent: disc, child: rod, axis: z, origin: {{xyz: [{arm}, 0, 0]}}}}
  f: {{type: revolute, parent: base, child: rocker, axis: z, origin: {{xyz: [2.5, 0, 0]}}}}
  h: {{type: revolute, parent: base, child: wheel, axis: z, origin: {{xyz: [0, 1, 0]}},
    mimic: {{joint: e, multiplier: {second}}}, spring: {{stiffness: 2}}}}
closures:
  first: {{kind: planar, between: {{coupler: [0.35, 0, 0], follower: [0.45, 0, 0]}},
    assembly: {mode}}}
  next: {{kind: planar, between: {{rod: [{rod}, 0, 0], rocker: [{rocker}, 0, 0]}},
    assembly: {mode}}}
active: [a]
end_effector: {{link: rocker}}
reference: {{a: 0.5}}
"""
RATIOS = st.floats(0.2, 1.8)
TURNING = {"arm": 0.1, "rod": 0.45, "rocker": 0.35, "offset": 0.2}  # right round
SWAYING = {"arm": 0.3, "rod": 0.15, "rocker": 0.15, "offset": -0.55}  # it closes up to 0.58 rad
MODES = st.sampled_from(["counterclockwise", "clockwise"])


def coupler_angle(crank: np.ndarray, lengths: tuple[float, ...], mode: str) -> np.ndarray:
    """Angle of the coupler of a four-bar from its crank, continuous; by two circles."""
    arm, ground, rod, rocker = lengths
    elbow = arm * np.exp(1j * crank)
    way = ground - elbow
    along = (rod**2 - rocker**2 + np.abs(way) ** 2) / (2.0 * np.abs(way))
    across = np.sqrt(rod**2 - along**2) * (1.0 if mode == "counterclockwise" else -1.0)
    turned = way / np.abs(way) * (along + 1j * across)
    return np.unwrap(np.angle(turned * np.exp(-1j * crank)))


@examples(12)
@given(RATIOS, RATIOS, MODES)
def test_a_follower_of_a_turning_joint_moves_the_loops_behind_it(
    ratio: float, second: float, mode: str
) -> None:
    """A gear on a drag link turns the crank of another four-bar, whose coupler turns a wheel."""
    text = TRAIN.format(ratio=ratio, second=second, mode=mode, **TURNING)
    robot = Robot(parse_description(text))
    assert robot.depends_on_turns
    u = 0.5 + np.linspace(0.0, 2.0 * np.pi * 5, 600)[:, None]
    path = robot.close_path(u)
    followed = robot.follow_turns(robot.close(u), path.s[0])
    np.testing.assert_allclose(followed.s, path.s, atol=CLOSED)
    at = {name: path.s[:, k] for k, name in enumerate(robot.coordinates)}
    np.testing.assert_allclose(at["d"], ratio * at["c"] + 0.2, atol=CLOSED)
    expected = coupler_angle(at["d"], (0.1, 0.5, 0.45, 0.35), mode)
    expected += at["e"][0] - expected[0]
    np.testing.assert_allclose(at["e"], expected, atol=CLOSED)
    np.testing.assert_allclose(at["h"], second * expected, atol=2.0 * CLOSED)


@examples(60)
@given(turning_linkages(), SEEDS, st.floats(-20.0, 20.0))
def test_without_a_history_angles_are_nearest_to_the_reference(
    linkage: Turning, seed: int, u: float
) -> None:
    robot = linkage.robot(seed)
    reference = robot.close(robot.reference).s
    state, again = robot.close([u]), robot.close([u + 2.0 * np.pi])
    for name in ("b", "c"):
        k = robot.coordinates.index(name)
        np.testing.assert_allclose(again.s[k], state.s[k], atol=CLOSED)
        if robot.joint_types[name] == "revolute":
            assert abs(state.s[k] - reference[k]) <= np.pi + CLOSED
            assert state.turns[name] == 0


@examples(12)
@given(turning_linkages(), st.floats(4.0, 12.0))
def test_energy_is_constant_while_springs_wind_up(linkage: Turning, speed: float) -> None:
    robot = linkage.robot()
    result = simulate(robot, [linkage.start], [speed], None, (0.0, 1.5))
    assert result.completed
    assert result.relative_energy_error < 1e-6  # of tolerances of 1e-9 a step


@examples(12)
@given(turning_linkages(), st.integers(20, 60))
def test_a_far_way_is_followed_to_its_end(linkage: Turning, turns: int) -> None:
    robot = linkage.robot()
    start = robot.close([linkage.start])
    far = robot.close([linkage.start + 2.0 * np.pi * turns], near=start)
    went = [abs(count) for name, count in far.turns.items() if name == "b"]
    assert went[0] in (0, turns)


def test_turns_of_a_crank_lead_an_iteration_to_the_same_places() -> None:
    """Three legs hold a plate: no closed form, and the crank has turned many times."""
    robot = mechanism("three_rrr")
    place = robot.close(robot.reference)
    for turns in (1, 11, 300, -40):
        u = np.array(robot.reference)
        u[0] += 2.0 * np.pi * turns
        state = robot.close(u)
        np.testing.assert_allclose(state.u, u)
        np.testing.assert_allclose(state.z, place.z, atol=1e-9)
