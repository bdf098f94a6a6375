"""What a simulation meets between its steps: limits in order, dips, and energy errors to scale."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from hybrid_dynamics_core import Robot, load
from hybrid_dynamics_core.simulation import Settings, simulate
from hybrid_dynamics_core.simulation.step_bound import StepBound
from tests.hard_cases.linkages import HEAD, robot
from tests.sampling import examples

GRAVITY = 9.81
MASS = (
    HEAD
    + """\
links: {{base: {{}}, block: {{mass: 2}}}}
joints:
  z: {{type: prismatic, parent: base, child: block, axis: z, limits: [{lower}, {upper}]}}
active: [z]
end_effector: {{link: block}}
"""
)
CRANK = (
    HEAD
    + """\
gravity: [0, 0, 0]
links: {{base: {{}}, crank: {{mass: 1, inertia: {{zz: 1, xx: 1, yy: 1}}}}, rod: {{mass: 1.0e-3}},
  ram: {{mass: 1.0e-3}}}}
joints:
  a: {{type: revolute, parent: base, child: crank, axis: z}}
  b: {{type: revolute, parent: crank, child: rod, axis: z, origin: {{xyz: [1, 0, 0]}}}}
  x: {{type: prismatic, parent: base, child: ram, axis: x}}
closures: {{cl: {{kind: planar, between: {{rod: [{rod}, 0, 0], ram: [0, 0, 0]}},
  assembly: extended}}}}
active: [a]
end_effector: {{link: ram}}
reference: {{a: 0}}
"""
)


def thrown(lower: float, upper: float) -> Robot:
    """A block that slides up and down."""
    return robot(MASS.format(lower=lower, upper=upper))


@examples(60)
@given(
    upper=st.floats(0.2, 3.0),
    lower=st.floats(-3.0, -0.2),
    speed=st.floats(-8.0, 8.0),
    method=st.sampled_from(["DOP853", "RK45", "LSODA"]),
)
def test_limits_are_met_in_their_order_at_their_times(
    upper: float, lower: float, speed: float, method: str
) -> None:
    """By hand: z = v t - g t^2 / 2."""
    top = speed**2 / (2.0 * GRAVITY) if speed > 0.0 else 0.0
    assume(abs(top - upper) > 1e-3)
    expected = []
    if top > upper:
        expected.append((speed - math.sqrt(speed**2 - 2.0 * GRAVITY * upper)) / GRAVITY)
    expected.append((speed + math.sqrt(speed**2 - 2.0 * GRAVITY * lower)) / GRAVITY)
    machine = thrown(lower, upper)
    every = Settings(stop_at_limits=False, method=method)
    result = simulate(machine, [0.0], [speed], None, (0.0, 5.0), every)
    sides = [event.message.split()[3] for event in result.events]
    assert sides == ["upper", "lower"][-len(expected) :]
    times = [event.time for event in result.events]
    np.testing.assert_allclose(times, expected, atol=1e-6)
    first = simulate(machine, [0.0], [speed], None, (0.0, 5.0), Settings(method=method))
    assert first.t[-1] == pytest.approx(expected[0], abs=1e-6)
    assert lower - 1e-6 <= first.u.min()
    assert first.u.max() <= upper + 1e-6


@examples(40)
@given(
    over=st.floats(1e-7, 0.3), speed=st.floats(0.3, 3.0), setting=st.sampled_from([0.01, 0.1, 0.3])
)
def test_a_dip_between_steps_is_seen(over: float, speed: float, setting: float) -> None:
    """A crank in a rod hardly longer: the loop passes a toggle at a quarter turn."""
    machine = robot(CRANK.format(rod=1.0 + over))
    angles = np.linspace(0.0, 2.0, 4001)
    distances = machine.close(angles[:, None]).singularity
    least = float(np.min(distances))
    assume(abs(least - setting) > 1e-3)
    settings = Settings(rate=20.0, singular=setting)
    result = simulate(machine, [0.0], [speed], None, (0.0, 2.0 / speed), settings)
    assert result.completed == (least > setting)
    if not result.completed:
        (event,) = result.events
        assert event.kind == "singular"
        reached = machine.close(result.u[-1]).singularity
        assert reached == pytest.approx(setting, abs=1e-6)


def test_the_energy_error_is_a_share_of_the_energy_that_is_there() -> None:
    """At rest and where none is exchanged it stays small, wherever the base stands."""
    still = robot(CRANK.format(rod=2.0))
    assert simulate(still, [0.3], [0.0], None, (0.0, 1.0)).relative_energy_error == 0.0
    turning = simulate(still, [0.3], [5.0], None, (0.0, 2.0))
    assert turning.relative_energy_error < 1e-7  # of tolerances of 1e-9 a step
    machine = thrown(-10.0, 10.0)
    held = simulate(machine, [1.0], [0.0], [2.0 * GRAVITY], (0.0, 1.0))
    assert held.relative_energy_error < 1e-6
    falling = simulate(machine, [1.0], [0.0], None, (0.0, 1.0))
    assert falling.relative_energy_error < 1e-9


def test_steps_are_bounded_by_the_angles_they_turn() -> None:
    """A crank that turns freely takes steps of a radian at most, however smooth its motion is."""
    machine = robot(CRANK.format(rod=2.0))
    result = simulate(machine, [0.0], [40.0], None, (0.0, 1.0))
    assert result.completed
    assert result.steps >= 40
    assert abs(result.state.turns["b"][-1]) == 6


@pytest.mark.parametrize("move", [0.05, 0.35, 0.95])
def test_places_of_a_step_that_are_looked_at_are_a_tenth_of_a_radian_apart(move: float) -> None:
    machine = load("type_c")
    start = machine.close(machine.reference)
    y = np.zeros((2, 2 * start.n + 1))
    turning = [name for name in machine.coordinates if machine.joint_types[name] == "revolute"]
    rows = [machine.coordinates.index(name) for name in turning]
    fastest = np.abs(start.R[rows, 0]).max()
    y[:, : start.n] = start.u
    y[1, 0] += move / fastest  # so that no angle goes farther
    more = StepBound(machine, np.inf).more_places(start, y)
    assert move / (1 + more) <= 0.1 + 1e-9
    assert more <= 10 * move + 1e-9


def test_a_ball_joint_at_rest_is_simulated() -> None:
    """No rate, and no longest step: warnings are errors here."""
    pendulum = robot(
        HEAD
        + """\
links: {base: {}, bob: {mass: 1, com: [0, 0, -1], inertia: {xx: 1, yy: 1, zz: 1}}}
joints: {socket: {type: ball, parent: base, child: bob}}
active: [socket]
end_effector: {link: bob}
"""
    )
    motion = simulate(pendulum, pendulum.reference, t_span=(0.0, 0.1))
    assert np.abs(motion.u).max() < 1e-12
